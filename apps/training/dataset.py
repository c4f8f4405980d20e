"""Rendered recordings in memory, and random training batches from them."""

import functools
import multiprocessing.pool
import pathlib
from typing import Iterable, NamedTuple

import cv2
import numpy as np
import torch
from torch import Tensor

import augment
import stereo
from network import PROTOTYPE_STRIDE

# MOTS classes of the simulator's truth by the network's classes; things on wheels (3, the trolley) are vehicles too.
CLASS_OF_MOTS = {1: 0, 2: 1, 3: 0}
MOTS_IDS_PER_CLASS = 1000

# The loss ignores smaller objects in the network's input.
MIN_HEIGHT_PX = 8
MIN_AREA_PX = 40

# Sizes of the input (rows, columns), their share of all batches, and pictures per batch, chosen for about equal cost.
SHAPES = (((192, 320), 0.3, 16), ((192, 640), 0.25, 8), ((256, 832), 0.25, 5), ((288, 352), 0.2, 10))

# Fraction of the pictures with instances pasted from another one.
PASTED = 0.5
# Fraction of the pictures with disparities whose grey levels say little.
DISGUISED = 0.25


class Files(NamedTuple):
    """Paths of a view: picture, the other camera's, and instances."""

    picture: pathlib.Path
    other: pathlib.Path
    instances: pathlib.Path
    is_right: bool


class Objects(NamedTuple):
    """The objects of one picture."""

    boxes: Tensor  # [n, 4]: left, top, right, bottom, pixels
    classes: Tensor  # [n]
    masks: Tensor  # [n, H/2, W/2]: visible part of each cell
    ignored: Tensor  # [H/2, W/2]: part of each cell that the loss ignores


class Batch(NamedTuple):
    pictures: Tensor  # [B, 2, H, W]: grey levels 0..1, encoded disparities
    objects: list[Objects]


def read_images(paths: Iterable[pathlib.Path]) -> list[np.ndarray]:
    """Decoded images. Raises FileNotFoundError naming the unreadable file."""
    read = []
    for path in paths:
        image = cv2.imread(str(path), cv2.IMREAD_UNCHANGED)
        if image is None:
            raise FileNotFoundError(f"cannot read {path}; render the recording again")
        read.append(image)
    return read


def read_view(files: Files) -> augment.View:
    """One picture with its disparities and truth. Raises FileNotFoundError naming the unreadable file."""
    picture, other, instances = read_images(files[:3])
    return augment.View(picture, (stereo.match_right if files.is_right else stereo.match)(picture, other), instances)


def views_of(recording: pathlib.Path, views: tuple[str, ...] = ("left", "right")) -> list[Files]:
    """Paths of the views of a simulated recording, in order of time."""
    folders = {"left": "image_00", "right": "image_01"}
    found = []
    for view in views:
        other = "right" if view == "left" else "left"
        for picture in sorted(recording.glob(f"*/*/{folders[view]}/data/*.png")):
            found.append(Files(picture, picture.parents[2] / folders[other] / "data" / picture.name,
                               recording / "truth" / "masks" / f"instances_{view}" / picture.name, view == "right"))
    return found


def load(recordings: list[pathlib.Path]) -> list[augment.View]:
    """All views of the recordings, decoded."""
    files = [view for recording in recordings for view in views_of(recording)]
    with multiprocessing.pool.ThreadPool() as pool:
        return pool.map(read_view, files)


def mask_on_prototypes(mask: np.ndarray) -> np.ndarray:
    """Fraction of each prototype cell that the mask covers."""
    height, width = mask.shape
    size = (width // PROTOTYPE_STRIDE, height // PROTOTYPE_STRIDE)
    return cv2.resize(mask.astype(np.float32), size, interpolation=cv2.INTER_AREA)


def objects_in(instances: np.ndarray) -> Objects:
    """The objects of a picture that are large enough; smaller ones and those of unknown class are ignored."""
    ignored = np.zeros(instances.shape, bool)
    boxes, classes, masks = [], [], []
    for identity in np.unique(instances[instances > 0]):
        mask = instances == identity
        rows, columns = np.flatnonzero(mask.any(1)), np.flatnonzero(mask.any(0))
        class_of = CLASS_OF_MOTS.get(int(identity) // MOTS_IDS_PER_CLASS)
        if class_of is None or rows[-1] - rows[0] + 1 < MIN_HEIGHT_PX or mask.sum() < MIN_AREA_PX:
            ignored |= mask
            continue
        boxes.append((columns[0], rows[0], columns[-1] + 1, rows[-1] + 1))
        classes.append(class_of)
        masks.append(mask_on_prototypes(mask))
    empty = np.zeros((0, *mask_on_prototypes(ignored).shape), np.float32)
    return Objects(torch.tensor(boxes, dtype=torch.float32).reshape(-1, 4), torch.tensor(classes, dtype=torch.int64),
                   torch.from_numpy(np.stack(masks) if masks else empty), torch.from_numpy(mask_on_prototypes(ignored)))


class Batches(torch.utils.data.Dataset):
    """Endless random batches; the same number is always the same batch.

    The process that asks for the first one loads the views: a worker, so that gigabytes of them do not slow down the training process.
    """

    def __init__(self, recordings: list[pathlib.Path], seed: int) -> None:
        self._recordings = recordings
        self._seed = seed

    @functools.cached_property
    def _views(self) -> list[augment.View]:
        return load(self._recordings)

    def __len__(self) -> int:
        return 1 << 30

    def __getitem__(self, number: int) -> Batch:
        random = np.random.default_rng((self._seed, number))
        (height, width), _, count = SHAPES[random.choice(len(SHAPES), p=[part for _, part, _ in SHAPES])]
        pictures, objects = [], []
        for index in random.integers(len(self._views), size=count):
            sample = augment.cut(self._views[index], height, width, random)
            if random.random() < PASTED:
                other = self._views[random.integers(len(self._views))]
                augment.paste(sample, augment.cut(other, height, width, random), random)
            levels = augment.degrade(sample, random)
            disparities = augment.degrade_disparities(sample.disparities, random)
            if disparities.any() and random.random() < DISGUISED:
                levels = augment.disguise(levels, random)
            pictures.append(torch.from_numpy(np.stack((levels, stereo.encoded(disparities)))))
            objects.append(objects_in(sample.instances))
        return Batch(torch.stack(pictures), objects)
