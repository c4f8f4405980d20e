"""Random other views of a picture: as other lenses, sensors and lights would have shown it."""

import cv2
import numpy as np

# Grey of the network's input where there is no picture.
PAD = 114

# The scale at which a street of 832 columns enters a network of 640, and all scales that are tried.
USUAL_SCALE = 640 / 832
SCALES = (0.36, 1.25)


def cut(picture: np.ndarray, instances: np.ndarray, height: int, width: int,
        random: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
    """A part of the picture of this size, scaled, turned a little and perhaps mirrored; and the same of its truth."""
    scale = USUAL_SCALE * random.uniform(0.93, 1.07) if random.random() < 0.4 else np.exp(random.uniform(*np.log(SCALES)))
    angle = random.normal(0.0, 0.03)
    rows, columns = picture.shape
    # The middle of the part: anywhere that wastes no input, or the picture's own middle where the input is larger.
    slack = np.maximum(0.0, np.array((columns, rows)) - np.array((width, height)) / scale)
    middle = np.array((columns, rows)) / 2 + slack * random.uniform(-0.5, 0.5, 2)
    turn = scale * np.array(((np.cos(angle), -np.sin(angle)), (np.sin(angle), np.cos(angle))))
    if random.random() < 0.5:
        turn[:, 0] *= -1
    affine = np.column_stack((turn, np.array((width, height)) / 2 - turn @ middle))
    return (cv2.warpAffine(picture, affine, (width, height), flags=cv2.INTER_LINEAR, borderValue=PAD),
            cv2.warpAffine(instances, affine, (width, height), flags=cv2.INTER_NEAREST, borderValue=0))


def disturb(picture: np.ndarray, random: np.random.Generator) -> np.ndarray:
    """Another exposure and sensor, sometimes out of focus or with dirt on the lens; grey levels 0..1."""
    if random.random() < 0.2:
        picture = cv2.GaussianBlur(picture, (0, 0), random.uniform(0.3, 1.2))
    levels = picture.astype(np.float32) / 255
    levels = levels ** np.exp(random.normal(0.0, 0.25)).astype(np.float32)
    levels = (levels - 0.45) * np.float32(random.uniform(0.6, 1.3)) + np.float32(0.45 + random.normal(0.0, 0.08))
    if random.random() < 0.5:
        levels += random.standard_normal(levels.shape, np.float32) * np.float32(random.uniform(0.0, 0.03))
    if random.random() < 0.15:
        _cover(levels, random)
    return np.clip(levels, 0, 1)


def _cover(levels: np.ndarray, random: np.random.Generator) -> None:
    """Covers a small part with one grey: what is partly hidden is still there."""
    height, width = levels.shape
    rows, columns = random.integers(8, 40, size=2)
    top, left = random.integers(0, height - rows), random.integers(0, width - columns)
    levels[top:top + rows, left:left + columns] = random.random()
