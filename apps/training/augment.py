"""Random augmentation of pictures: other lenses, sensors and illumination, and other objects in them.

Rendered worlds are all similar; varying everything else makes the network learn the objects themselves (Tobin et al., "Domain
randomization", 2017). Instances are pasted between pictures (Ghiasi et al., "Simple copy-paste", 2021).
"""

from typing import NamedTuple

import cv2
import numpy as np

import stereo

# Grey level of padding in the network's input.
PAD = 114

# Usual size of the network's input, rows of a tall picture and columns of a wide one, for the scale of most pictures; and the range of
# scales.
USUAL_INPUT = (416, 832)
SCALES = (0.36, 2.0)
# Wide pictures have a higher ratio of columns to rows; they are scaled by their columns.
_WIDE = 2.0

# Added to the ids of pasted instances; a picture has fewer of its own.
_PASTED_IDS = 500
# MOTS ids of people begin here and end before twice this.
_PEOPLE = 2000


class View(NamedTuple):
    """A picture and its truth as stored: grey levels, raw disparities at half of the size, and instances as MOTS ids."""

    picture: np.ndarray
    disparities: np.ndarray
    instances: np.ndarray


class Sample(NamedTuple):
    """Images of the network's input size: grey levels, disparities in its pixels, and instances as MOTS ids."""

    picture: np.ndarray
    disparities: np.ndarray
    instances: np.ndarray


def cut(view: View, height: int, width: int, random: np.random.Generator) -> Sample:
    """A random crop of this size, scaled, slightly rotated and possibly mirrored, of a view of the dataset."""
    rows, columns = view.picture.shape
    if random.random() < 0.35:
        fitting = USUAL_INPUT[1] / columns if columns > _WIDE * rows else USUAL_INPUT[0] / rows
        scale = fitting * random.uniform(0.93, 1.07)
    else:
        # The lowest scale shows the whole picture with little padding.
        least = max(SCALES[0], 0.95 * min(width / columns, height / rows))
        scale = np.exp(random.uniform(np.log(least), np.log(SCALES[1])))
    stretch = np.exp(random.normal(0.0, 0.06))
    angle = random.normal(0.0, 0.03)
    # The crop's middle: random without padding, or the picture's own middle where the input is larger.
    slack = np.maximum(0.0, np.array((columns, rows)) - np.array((width, height)) / scale)
    middle = np.array((columns, rows)) / 2 + slack * random.uniform(-0.5, 0.5, 2)
    turn = scale * np.array(((np.cos(angle), -np.sin(angle)), (np.sin(angle), np.cos(angle))))
    turn[0] *= stretch
    if random.random() < 0.5:
        turn[:, 0] *= -1
    affine = np.column_stack((turn, np.array((width, height)) / 2 - turn @ middle))
    # From the smaller map; pixel coordinates of both are of middles.
    half = (stereo.REDUCTION - 1) / 2
    from_small = affine @ np.array(((stereo.REDUCTION, 0, half), (0, stereo.REDUCTION, half), (0, 0, 1)))
    raw = cv2.warpAffine(view.disparities, from_small, (width, height), flags=cv2.INTER_NEAREST, borderValue=0)
    return Sample(cv2.warpAffine(view.picture, affine, (width, height), flags=cv2.INTER_LINEAR, borderValue=PAD),
                  np.float32(scale * stretch) * stereo.pixels(raw),
                  cv2.warpAffine(view.instances, affine, (width, height), flags=cv2.INTER_NEAREST, borderValue=0))


def paste(sample: Sample, other: Sample, random: np.random.Generator) -> None:
    """Pastes a few instances of another sample of the same size in front of the sample's content."""
    identities = random.permutation(np.unique(other.instances[other.instances > 0]))
    if random.random() < 0.8:
        # People first: they are rarer.
        identities = sorted(identities, key=lambda identity: identity // _PEOPLE != 1)
    for identity in identities[:random.integers(1, 6)]:
        mask = other.instances == identity
        shift = int(random.integers(-mask.shape[1] // 3, mask.shape[1] // 3))
        mask, moved = np.roll(mask, shift, 1), np.roll(other.picture, shift, 1)
        edge = cv2.GaussianBlur(mask.astype(np.float32), (0, 0), 0.7)
        blended = sample.picture + (moved.astype(np.float32) - sample.picture) * edge
        sample.picture[:] = np.where(edge > 0.02, blended, sample.picture).astype(np.uint8)
        sample.disparities[mask] = np.roll(other.disparities, shift, 1)[mask]
        sample.instances[mask] = identity + _PASTED_IDS


def degrade_disparities(disparities: np.ndarray, random: np.random.Generator) -> np.ndarray:
    """Disparities of another baseline, with errors and holes; sometimes none at all, as without a right picture."""
    if random.random() < 0.1:
        return np.zeros_like(disparities)
    known = disparities > 0
    disparities = disparities * np.float32(np.exp(random.normal(0.0, 0.4)))
    if random.random() < 0.4:
        wavy = _noise(disparities.shape, np.exp(random.uniform(1.0, 4.5)), random)
        disparities = disparities + known * np.float32(random.uniform(0, 1.0)) * wavy
    if random.random() < 0.5:
        for _ in range(random.integers(1, 4)):
            known &= ~_hole(disparities.shape, random)
    if random.random() < 0.3:
        known &= _noise(disparities.shape, np.exp(random.uniform(2.5, 4.5)), random) > random.uniform(-2.5, -0.5)
    if random.random() < 0.3:
        # Steps of depth off by a few pixels.
        size = 2 * int(random.integers(1, 4)) + 1
        change = cv2.dilate if random.random() < 0.7 else cv2.erode
        disparities = change(disparities.astype(np.float32), np.ones((size, size), np.uint8))
    return np.maximum(disparities, 0) * known


def _hole(shape: tuple[int, int], random: np.random.Generator) -> np.ndarray:
    """A random ellipse."""
    height, width = shape
    size = np.exp(random.uniform(np.log(4.0), np.log(60.0), 2))
    middle = random.uniform((0, 0), (width, height))
    mask = np.zeros(shape, np.uint8)
    cv2.ellipse(mask, tuple(map(int, middle)), tuple(map(int, size)), float(random.uniform(0, 180)), 0, 360, 1, -1)
    return mask > 0


def degrade(sample: Sample, random: np.random.Generator) -> np.ndarray:
    """Other illumination, exposure and sensor, and occluders that are no instances; grey levels 0..1.

    Occluded pixels are removed from the sample's instances, and mostly have the occluder's disparity.
    """
    levels = sample.picture.astype(np.float32) * np.float32(1 / 255)
    instances = sample.instances
    if random.random() < 0.35:
        _retone_instances(levels, instances, random)
    if random.random() < 0.25:
        _roughen_background(levels, instances, random)
    if random.random() < 0.35:
        for _ in range(random.integers(1, 4)):
            _cover(levels, sample, random)
    if random.random() < 0.65:
        for _ in range(random.integers(1, 4)):
            _shade(levels, random)
    levels = _expose(levels, random)
    levels = _soften(levels, random)
    if random.random() < 0.6:
        levels += random.standard_normal(levels.shape, np.float32) * np.float32(0.04 * random.random() ** 2)
    levels = np.clip(levels, 0, 1)
    if random.random() < 0.3:
        levels = _process(levels, random)
    return levels


def disguise(levels: np.ndarray, random: np.random.Generator) -> np.ndarray:
    """Grey levels that say little about the objects: the rest of them and their disparities have to do.

    Simulated objects can be recognised by any part of their grey levels; real ones look different, but have the same shape.
    """
    if random.random() < 0.3:
        nodes = np.linspace(0, 1, int(random.integers(3, 7)))
        return np.interp(levels, nodes, random.random(len(nodes))).astype(np.float32)
    texture = np.full(levels.shape, random.random(), np.float32)
    for _ in range(random.integers(0, 4)):
        texture += np.float32(random.uniform(0, 0.3)) * _noise(levels.shape, np.exp(random.uniform(0.5, 5.0)), random)
    where = np.float32(1)
    if random.random() < 0.65:
        where = np.maximum.reduce([_region(levels.shape, random) for _ in range(random.integers(1, 4))])
    return np.clip(levels + (texture - levels) * where, 0, 1)


def _noise(shape: tuple[int, ...], cells: float, random: np.random.Generator) -> np.ndarray:
    """Smooth noise of mean 0 and deviation about 1, with `cells` cells along the picture's height."""
    rows = max(2, round(cells))
    columns = max(2, round(cells * shape[1] / shape[0]))
    return cv2.resize(random.standard_normal((rows, columns), np.float32), shape[::-1], interpolation=cv2.INTER_CUBIC)


def _region(shape: tuple[int, ...], random: np.random.Generator) -> np.ndarray:
    """A random region, 0..1: a half plane, a polygon, or thresholded noise; with a hard or a soft edge."""
    height, width = shape
    kind = random.random()
    if kind < 0.35:
        direction = random.normal(size=2)
        y, x = np.mgrid[0:height, 0:width].astype(np.float32)
        away = (x - random.uniform(0, width)) * direction[0] + (y - random.uniform(0, height)) * direction[1]
        region = (away > 0).astype(np.float32)
    elif kind < 0.65:
        middle = random.uniform((0, 0), (width, height))
        corners = middle + random.normal(size=(random.integers(3, 8), 2)) * (random.uniform(0.1, 0.5) * width, 0.5 * height)
        region = np.zeros(shape, np.float32)
        cv2.fillPoly(region, [corners.astype(np.int32)], 1.0)
    else:
        region = (_noise(shape, np.exp(random.uniform(0.7, 3.2)), random) > random.uniform(-0.6, 1.0)).astype(np.float32)
    softness = random.uniform(0.3, 2.0) if random.random() < 0.7 else random.uniform(4.0, 25.0)
    return cv2.GaussianBlur(region, (0, 0), softness)


def _shade(levels: np.ndarray, random: np.random.Generator) -> None:
    """Darkens or brightens a region of the picture."""
    factor = np.exp(random.uniform(-1.8, -0.2)) if random.random() < 0.8 else np.exp(random.uniform(0.2, 0.9))
    levels *= 1 + np.float32(factor - 1) * _region(levels.shape, random)


def _retone_instances(levels: np.ndarray, instances: np.ndarray, random: np.random.Generator) -> None:
    """Other paint and clothes on some objects, and on a part of some of them."""
    for identity in np.unique(instances[instances > 0]):
        if random.random() < 0.5:
            levels[instances == identity] *= np.float32(np.exp(random.uniform(-1.6, 0.7)))
        if random.random() < 0.4:
            _retone_part(levels, instances == identity, random)


def _retone_part(levels: np.ndarray, mask: np.ndarray, random: np.random.Generator) -> None:
    """Darkens or brightens a random part of an object: half of it in the sun, bright hair or sleeves above dark trousers."""
    rows, columns = np.flatnonzero(mask.any(1)), np.flatnonzero(mask.any(0))
    box = slice(rows[0], rows[-1] + 1), slice(columns[0], columns[-1] + 1)
    part = _region(mask[box].shape, random) * mask[box]
    factor = np.exp(random.uniform(-1.6, 1.6))
    levels[box] *= 1 + np.float32(factor - 1) * part


def _roughen_background(levels: np.ndarray, instances: np.ndarray, random: np.random.Generator) -> None:
    """Adds speckles, as of leaves in hard light, to a part of the background."""
    cells = np.exp(random.uniform(2.0, 4.6))
    rough = _noise(levels.shape, cells, random) + 0.6 * _noise(levels.shape, 2.3 * cells, random)
    where = _region(levels.shape, random) * (instances == 0)
    levels *= np.exp(np.float32(random.uniform(0.2, 0.9)) * rough * where)


def _cover(levels: np.ndarray, sample: Sample, random: np.random.Generator) -> None:
    """Adds an occluder that is no instance: a shape of any texture."""
    height, width = levels.shape
    size = np.exp(random.uniform(np.log(6.0), np.log(90.0), 2))
    middle = random.uniform((0, 0), (width, height))
    mask = np.zeros(levels.shape, np.uint8)
    kind = random.random()
    if kind < 0.5:
        box = cv2.boxPoints((tuple(map(float, middle)), tuple(map(float, size)), float(random.normal(0, 12))))
        cv2.fillPoly(mask, [box.astype(np.int32)], 1)
    elif kind < 0.75:
        corners = middle + random.normal(size=(random.integers(3, 7), 2)) * size / 2
        cv2.fillPoly(mask, [corners.astype(np.int32)], 1)
    else:
        cv2.ellipse(mask, tuple(map(int, middle)), tuple(map(int, size / 2)), float(random.uniform(0, 180)), 0, 360, 1, -1)
    inside = mask > 0
    texture = random.random() + random.uniform(0, 0.25) * _noise(levels.shape, np.exp(random.uniform(1, 4.5)), random)
    if random.random() < 0.4:
        y, x = np.mgrid[0:height, 0:width].astype(np.float32)
        wave = x * random.normal(0, 0.5) + y * random.normal(0, 0.5)
        texture += random.uniform(0.1, 0.5) * np.sign(np.sin(wave))
    levels[inside] = np.clip(texture, 0, 1)[inside]
    sample.instances[inside] = 0
    if inside.any() and random.random() < 0.8:
        sample.disparities[inside] = sample.disparities[inside].max() * random.uniform(1.0, 1.6)


def _expose(levels: np.ndarray, random: np.random.Generator) -> np.ndarray:
    """Another exposure, contrast and vignetting; the caller clips the levels."""
    levels = np.clip(levels, 1e-4, 4.0) ** np.float32(np.exp(random.normal(0.0, 0.3)))
    middle = np.float32(levels.mean())
    aimed = random.uniform(0.15, 0.65)
    levels = (levels - middle) * np.float32(np.exp(random.normal(0.0, 0.25))) + middle
    gain = (aimed / (middle + 0.02)) ** random.random()
    levels = levels * np.float32(gain) + np.float32(random.normal(0.0, 0.03))
    if random.random() < 0.3:
        height, width = levels.shape
        y, x = np.mgrid[-1:1:height * 1j, -1:1:width * 1j].astype(np.float32)
        levels = levels * (1 - np.float32(random.uniform(0, 0.4)) * (x * x + y * y) / 2)
    return levels


def _soften(levels: np.ndarray, random: np.random.Generator) -> np.ndarray:
    """Defocus, motion blur, resampling or sharpening."""
    kind = random.random()
    if kind < 0.2:
        return cv2.GaussianBlur(levels, (0, 0), random.uniform(0.3, 1.6))
    if kind < 0.3:
        length = int(random.integers(2, 8))
        kernel = np.zeros((9, 9), np.float32)
        angle = random.uniform(0, np.pi) if random.random() < 0.5 else 0.0
        way = np.array((np.cos(angle), np.sin(angle))) * length / 2
        cv2.line(kernel, tuple(map(int, np.round(4 - way))), tuple(map(int, np.round(4 + way))), 1.0)
        return cv2.filter2D(levels, -1, kernel / kernel.sum())
    if kind < 0.45:
        small = cv2.resize(levels, None, fx=random.uniform(0.4, 0.9), fy=random.uniform(0.4, 0.9), interpolation=cv2.INTER_AREA)
        return cv2.resize(small, levels.shape[::-1], interpolation=cv2.INTER_LINEAR)
    if kind < 0.65:
        fine = levels - cv2.GaussianBlur(levels, (0, 0), random.uniform(0.6, 2.0))
        return levels + np.float32(random.uniform(0.2, 1.2)) * fine
    return levels


def _process(levels: np.ndarray, random: np.random.Generator) -> np.ndarray:
    """Processing in a camera: local contrast, compression."""
    grey = (levels * 255).astype(np.uint8)
    if random.random() < 0.5:
        tiles = int(random.integers(2, 7)), int(random.integers(2, 9))
        grey = cv2.createCLAHE(random.uniform(1.0, 4.0), tiles).apply(grey)
    else:
        quality = int(random.integers(25, 90))
        grey = cv2.imdecode(cv2.imencode(".jpg", grey, (cv2.IMWRITE_JPEG_QUALITY, quality))[1], cv2.IMREAD_GRAYSCALE)
    return grey.astype(np.float32) * np.float32(1 / 255)
