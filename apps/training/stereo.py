"""Disparities of stereo pictures: the network's second channel."""

import cv2
import numpy as np

# Matching is done at half of the size: a quarter of the pixels, half of the disparities.
REDUCTION = 2
_LEVELS = 64
# Raw values of the matcher for one pixel of disparity.
_FRACTION = 16
_BLOCK = 5

# Disparities in pixels of the network's input become log2(1 + disparity) / this: 0 (far away, or unknown) to about 1.
_OCTAVES = 7.0


def match(picture: np.ndarray, other: np.ndarray) -> np.ndarray:
    """Raw disparities (int16, sixteenths of a pixel of the result) of a rectified left picture, at half of its size; unknown: 0.

    Semi-global matching (Hirschmueller 2008) of OpenCV, the same as in the product (neural/src/opencv_runtime.cpp).
    """
    matcher = cv2.StereoSGBM_create(minDisparity=0, numDisparities=_LEVELS, blockSize=_BLOCK, P1=8 * _BLOCK ** 2,
                                    P2=32 * _BLOCK ** 2, disp12MaxDiff=1, preFilterCap=31, uniquenessRatio=10,
                                    speckleWindowSize=50, speckleRange=2, mode=cv2.STEREO_SGBM_MODE_SGBM_3WAY)
    # The matcher leaves out the first columns, as many as levels.
    small = [cv2.copyMakeBorder(_halved(view), 0, 0, _LEVELS, 0, cv2.BORDER_REPLICATE) for view in (picture, other)]
    return np.maximum(matcher.compute(*small)[:, _LEVELS:], 0)


def match_right(picture: np.ndarray, other: np.ndarray) -> np.ndarray:
    """The same of a right picture: mirrored, it is a left one."""
    return np.ascontiguousarray(match(np.ascontiguousarray(picture[:, ::-1]), np.ascontiguousarray(other[:, ::-1]))[:, ::-1])


def pixels(raw: np.ndarray) -> np.ndarray:
    """Disparities in pixels of the matched picture."""
    return raw.astype(np.float32) * np.float32(REDUCTION / _FRACTION)


def enlarged(small: np.ndarray, shape: tuple[int, int]) -> np.ndarray:
    """A map of half of the size at the picture's size."""
    return cv2.resize(small, shape[::-1], interpolation=cv2.INTER_NEAREST)


def encoded(disparities: np.ndarray) -> np.ndarray:
    """The network's input from disparities in pixels of its input."""
    return np.log2(1 + np.maximum(disparities, 0)) * np.float32(1 / _OCTAVES)


def _halved(picture: np.ndarray) -> np.ndarray:
    return cv2.resize(picture, (picture.shape[1] // REDUCTION, picture.shape[0] // REDUCTION), interpolation=cv2.INTER_AREA)
