"""Runs an exported model in OpenCV's DNN and gives the instances of a picture, as the product does."""

import pathlib
from typing import NamedTuple

import cv2
import numpy as np

from augment import PAD
from network import CLASSES, PROTOTYPE_STRIDE


class Thresholds(NamedTuple):
    score: float
    overlap: float  # IoU of boxes of one class; of two that overlap more, the better one stays


class Instance(NamedTuple):
    class_of: int
    score: float
    mask: np.ndarray  # of the picture's size, bool


class Fit(NamedTuple):
    """How a picture lies in the network's input: scaled, then moved right by `left` and down by `top`."""

    scale: float
    left: int
    top: int


def letterbox(picture: np.ndarray, height: int, width: int) -> tuple[np.ndarray, Fit]:
    """The picture scaled to fit, padded in equal halves."""
    rows, columns = picture.shape
    scale = min(height / rows, width / columns)
    filtered = cv2.INTER_AREA if scale < 1 else cv2.INTER_LINEAR
    scaled = cv2.resize(picture, (round(columns * scale), round(rows * scale)), interpolation=filtered)
    top, left = (height - scaled.shape[0]) // 2, (width - scaled.shape[1]) // 2
    fitted = np.full((height, width), PAD, np.uint8)
    fitted[top:top + scaled.shape[0], left:left + scaled.shape[1]] = scaled
    return fitted, Fit(scale, left, top)


class Detector:
    """A model of one input size."""

    def __init__(self, model: pathlib.Path, height: int, width: int, threads: int = 1) -> None:
        cv2.setNumThreads(threads)
        self._model = cv2.dnn.readNetFromONNX(str(model))
        self.height, self.width = height, width

    def outputs(self, picture: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """What the model says of an input-sized picture of 0..1: rows [4 + classes + prototypes, cells], prototypes."""
        self._model.setInput(picture[None, None].astype(np.float32))
        rows, prototypes = self._model.forward(["output0", "output1"])
        return rows[0], prototypes[0]

    def detect(self, picture: np.ndarray, thresholds: Thresholds) -> list[Instance]:
        """The instances of a grey picture, best first."""
        fitted, fit = letterbox(picture, self.height, self.width)
        rows, prototypes = self.outputs(fitted.astype(np.float32) / 255)
        scores = rows[4:4 + len(CLASSES)]
        found = []
        for class_of in range(len(CLASSES)):
            boxes = np.concatenate((rows[:2] - rows[2:4] / 2, rows[2:4])).T
            kept = cv2.dnn.NMSBoxes(boxes.tolist(), scores[class_of].tolist(), thresholds.score, thresholds.overlap)
            for cell in np.asarray(kept, int).ravel():
                logits = np.tensordot(rows[4 + len(CLASSES):, cell], prototypes, 1)
                mask = self._mask(logits, boxes[cell], fit, picture.shape)
                found.append(Instance(class_of, float(scores[class_of, cell]), mask))
        return sorted(found, key=lambda instance: -instance.score)

    def _mask(self, logits: np.ndarray, box: np.ndarray, fit: Fit, shape: tuple[int, ...]) -> np.ndarray:
        """A mask in the picture from logits on prototype cells and a box (left, top, width, height) of the input."""
        # From the middle of a pixel to the cell around it.
        per_pixel = fit.scale / PROTOTYPE_STRIDE
        x, y = (0.5 * per_pixel + side / PROTOTYPE_STRIDE - 0.5 for side in (fit.left, fit.top))
        to_cells = np.array(((per_pixel, 0, x), (0, per_pixel, y)))
        mask = cv2.warpAffine(logits, to_cells, shape[::-1], flags=cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP,
                              borderMode=cv2.BORDER_REPLICATE) > 0
        left, top = (box[:2] - (fit.left, fit.top)) / fit.scale
        right, bottom = (box[:2] + box[2:] - (fit.left, fit.top)) / fit.scale
        rows, columns = np.arange(shape[0])[:, None] + 0.5, np.arange(shape[1])[None] + 0.5
        return mask & (rows >= top) & (rows < bottom) & (columns >= left) & (columns < right)
