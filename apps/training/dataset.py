"""Rendered recordings in memory, and random training batches from them."""

import multiprocessing.pool
import pathlib
from typing import NamedTuple

import cv2
import numpy as np
import torch
from torch import Tensor

import augment
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


class View(NamedTuple):
    """A picture and its truth as stored: grey levels, and instances as MOTS ids."""

    picture: np.ndarray
    instances: np.ndarray


class Objects(NamedTuple):
    """The objects of one picture."""

    boxes: Tensor  # [n, 4]: left, top, right, bottom, pixels
    classes: Tensor  # [n]
    masks: Tensor  # [n, H/2, W/2]: visible part of each cell
    ignored: Tensor  # [H/2, W/2]: part of each cell that the loss ignores


class Batch(NamedTuple):
    pictures: Tensor  # [B, 1, H, W], 0..1
    objects: list[Objects]


def read_view(picture: pathlib.Path, instances: pathlib.Path) -> View:
    """One picture with its truth. Raises FileNotFoundError naming the unreadable file."""
    read = [cv2.imread(str(path), cv2.IMREAD_UNCHANGED) for path in (picture, instances)]
    for path, image in zip((picture, instances), read):
        if image is None:
            raise FileNotFoundError(f"cannot read {path}; render the recording again")
    return View(*read)


def views_of(recording: pathlib.Path, views: tuple[str, ...] = ("left", "right")) -> list[tuple[pathlib.Path, pathlib.Path]]:
    """Paths of the pictures of a simulated recording, each with its instances' path, in order of time."""
    folders = {"left": "image_00", "right": "image_01"}
    pairs = []
    for view in views:
        for picture in sorted(recording.glob(f"*/*/{folders[view]}/data/*.png")):
            pairs.append((picture, recording / "truth" / "masks" / f"instances_{view}" / picture.name))
    return pairs


def load(recordings: list[pathlib.Path]) -> list[View]:
    """All views of the recordings, decoded."""
    pairs = [pair for recording in recordings for pair in views_of(recording)]
    with multiprocessing.pool.ThreadPool() as pool:
        return pool.starmap(read_view, pairs)


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
    """Endless random batches; the same number is always the same batch."""

    def __init__(self, views: list[View], seed: int) -> None:
        self._views = views
        self._seed = seed

    def __len__(self) -> int:
        return 1 << 30

    def __getitem__(self, number: int) -> Batch:
        random = np.random.default_rng((self._seed, number))
        (height, width), _, count = SHAPES[random.choice(len(SHAPES), p=[part for _, part, _ in SHAPES])]
        pictures, objects = [], []
        for index in random.integers(len(self._views), size=count):
            picture, instances = augment.cut(*self._views[index], height, width, random)
            if random.random() < PASTED:
                other = self._views[random.integers(len(self._views))]
                augment.paste(picture, instances, *augment.cut(*other, height, width, random), random)
            pictures.append(torch.from_numpy(augment.degrade(picture, instances, random)))
            objects.append(objects_in(instances))
        return Batch(torch.stack(pictures)[:, None], objects)
