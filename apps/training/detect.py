"""Runs an exported model in OpenCV's DNN and returns the instances of a picture, as the product does."""

import pathlib
from typing import NamedTuple

import cv2
import numpy as np

import stereo
from augment import PAD
from network import CLASSES, OUTPUTS, PROTOTYPE_STRIDE, STRIDES, cell_middles


class Thresholds(NamedTuple):
    score: float
    overlap: float  # IoU of boxes of one class, for non-maximum suppression


class Instance(NamedTuple):
    class_of: int
    score: float
    mask: np.ndarray  # of the picture's size, bool


class Fit(NamedTuple):
    """Placement of a picture in the network's input: scaled, then moved right by `left` and down by `top`."""

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


def input_size(picture_rows: int, picture_columns: int, pixels: int) -> tuple[int, int]:
    """Rows and columns of the input for such pictures: the widest in multiples of 32 that is no wider than the picture rounded up,
    contains it, and has at most `pixels` pixels. The same as the product's ModelInput::sized_for."""
    for columns in range(_rounded_up(picture_columns), STRIDES[-1], -STRIDES[-1]):
        rows = _rounded_up(-(-picture_rows * columns // picture_columns))
        if rows * columns <= pixels:
            return rows, columns
    return _rounded_up(-(-picture_rows * STRIDES[-1] // picture_columns)), STRIDES[-1]


def _rounded_up(size: int) -> int:
    return -(-size // STRIDES[-1]) * STRIDES[-1]


class Detector:
    """A model written by train; its input has at most `pixels` pixels."""

    def __init__(self, model: pathlib.Path, pixels: int, threads: int = 1) -> None:
        cv2.setNumThreads(threads)
        self._model = cv2.dnn.readNetFromONNX(str(model))
        self._pixels = pixels

    def outputs(self, picture: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Outputs for an input [2, H, W]: a row per cell of left, top, right, bottom (box corners in pixels), scores,
        coefficients; and the prototypes."""
        self._model.setInput(picture[None].astype(np.float32))
        *maps, prototypes = self._model.forward(OUTPUTS)
        rows = np.concatenate([cells[0].reshape(cells.shape[1], -1) for cells in maps], 1).T.copy()
        middles = cell_middles(*picture.shape[1:])[0].numpy()
        rows[:, :2] = middles - rows[:, :2]
        rows[:, 2:4] = middles + rows[:, 2:4]
        return rows, prototypes[0]

    def detect(self, picture: np.ndarray, right: np.ndarray | None, thresholds: Thresholds) -> list[Instance]:
        """The instances of a grey picture, the left one of a rectified pair or a single one; best first."""
        size = input_size(*picture.shape, self._pixels)
        fitted, fit = letterbox(picture, *size)
        disparities = np.zeros(size, np.float32)
        if right is not None:
            raw = stereo.match(fitted, letterbox(right, *size)[0])
            disparities = stereo.encoded(stereo.enlarged(stereo.pixels(raw), size))
        rows, prototypes = self.outputs(np.stack((fitted.astype(np.float32) / 255, disparities)))
        boxes = np.concatenate((rows[:, :2], rows[:, 2:4] - rows[:, :2]), 1)
        coefficients = rows[:, 4 + len(CLASSES):]
        found = []
        for class_of in range(len(CLASSES)):
            scores = rows[:, 4 + class_of]
            kept = cv2.dnn.NMSBoxes(boxes.tolist(), scores.tolist(), thresholds.score, thresholds.overlap)
            for cell in np.asarray(kept, int).ravel():
                mask = self._mask(np.tensordot(coefficients[cell], prototypes, 1), boxes[cell], fit, picture.shape)
                found.append(Instance(class_of, float(scores[cell]), mask))
        return sorted(found, key=lambda instance: -instance.score)

    def _mask(self, logits: np.ndarray, box: np.ndarray, fit: Fit, shape: tuple[int, ...]) -> np.ndarray:
        """A mask in the picture from logits on prototype cells and a box (left, top, width, height) of the input."""
        # Maps pixel coordinates to cell coordinates; integers are centres.
        per_pixel = fit.scale / PROTOTYPE_STRIDE
        x, y = (0.5 * per_pixel + side / PROTOTYPE_STRIDE - 0.5 for side in (fit.left, fit.top))
        to_cells = np.array(((per_pixel, 0, x), (0, per_pixel, y)))
        mask = cv2.warpAffine(logits, to_cells, shape[::-1], flags=cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP,
                              borderMode=cv2.BORDER_REPLICATE) > 0
        left, top = (box[:2] - (fit.left, fit.top)) / fit.scale
        right, bottom = (box[:2] + box[2:] - (fit.left, fit.top)) / fit.scale
        rows, columns = np.arange(shape[0])[:, None] + 0.5, np.arange(shape[1])[None] + 0.5
        return mask & (rows >= top) & (rows < bottom) & (columns >= left) & (columns < right)
