"""The network: a small convolutional pyramid, box and mask heads on three strides, prototypes at half of the size.

Instance masks are sums of prototypes (Bolya et al., YOLACT, 2019); boxes are four distances from the middle of a cell (Tian et
al., FCOS, 2019). Plain convolutions with ReLU are the fastest in OpenCV's DNN on a CPU.
"""

from typing import NamedTuple

import torch
from torch import Tensor, nn

CLASSES = ("vehicle", "person")
# Grey levels and encoded disparities.
CHANNELS = 2
STRIDES = (8, 16, 32)
PROTOTYPE_STRIDE = 2
PROTOTYPES = 16
# Hidden channels of the prototypes' sharpening.
EDGES = 24
# Of the exported model.
OUTPUTS = ("cells8", "cells16", "cells32", "prototypes")
# Default limit of the input's size.
PIXELS = 245760

# Before training: boxes four cells wide, and an object in one cell of a hundred.
_FIRST_LOG_DISTANCE = 0.7
_FIRST_SCORE_LOGIT = -4.6
# Limit before exp(), beyond any box in a picture.
_MAX_LOG_DISTANCE = 6.0


class Prediction(NamedTuple):
    """Output for a batch; cells of all strides concatenated, finest first."""

    scores: Tensor  # [B, cells, classes], logits
    distances: Tensor  # [B, cells, 4]: left, top, right, bottom, pixels of the input
    coefficients: Tensor  # [B, cells, prototypes]
    prototypes: Tensor  # [B, prototypes, H/2, W/2]


def convolution(inputs: int, outputs: int, stride: int = 1, size: int = 3) -> nn.Sequential:
    """Convolution, normalisation and ReLU."""
    return nn.Sequential(nn.Conv2d(inputs, outputs, size, stride, size // 2, bias=False), nn.BatchNorm2d(outputs),
                         nn.ReLU(inplace=True))


class Residual(nn.Module):
    """Two convolutions with a shortcut (He et al., 2016)."""

    def __init__(self, channels: int) -> None:
        super().__init__()
        self.first = convolution(channels, channels)
        self.second = nn.Sequential(nn.Conv2d(channels, channels, 3, padding=1, bias=False), nn.BatchNorm2d(channels))

    def forward(self, features: Tensor) -> Tensor:
        return torch.relu(features + self.second(self.first(features)))


def stage(inputs: int, outputs: int, blocks: int) -> nn.Sequential:
    """Halves the size, followed by residual blocks."""
    return nn.Sequential(convolution(inputs, outputs, 2), *(Residual(outputs) for _ in range(blocks)))


class Head(nn.Module):
    """Scores, distances and mask coefficients of every cell of one stride."""

    def __init__(self, inputs: int, width: int, stride: int) -> None:
        super().__init__()
        self.stride = stride
        self.trunk = convolution(inputs, width)
        self.scores = nn.Conv2d(width, len(CLASSES), 1)
        self.distances = nn.Conv2d(width, 4, 1)
        self.coefficients = nn.Conv2d(width, PROTOTYPES, 1)
        nn.init.constant_(self.scores.bias, _FIRST_SCORE_LOGIT)
        nn.init.constant_(self.distances.bias, _FIRST_LOG_DISTANCE)

    def forward(self, features: Tensor) -> tuple[Tensor, Tensor, Tensor]:
        features = self.trunk(features)
        # An upper limit by ReLU, because OpenCV 4.6 does not support clamp of this opset.
        log_distances = _MAX_LOG_DISTANCE - torch.relu(_MAX_LOG_DISTANCE - self.distances(features))
        return self.scores(features), log_distances.exp() * self.stride, self.coefficients(features)


class Network(nn.Module):
    """Grey levels of 0..1 and encoded disparities [B, 2, H, W], H and W multiples of 32, to a Prediction."""

    def __init__(self, widths: tuple[int, ...] = (16, 32, 64, 128, 192), blocks: tuple[int, ...] = (1, 1, 2, 1),
                 neck: int = 64) -> None:
        super().__init__()
        self.edges = convolution(CHANNELS, widths[0], 2)
        self.stem = stage(widths[0], widths[1], blocks[0])
        self.stages = nn.ModuleList(stage(widths[i], widths[i + 1], blocks[i]) for i in (1, 2, 3))
        self.laterals = nn.ModuleList(convolution(width, neck, size=1) for width in widths[2:])
        self.smooth = nn.ModuleList(convolution(neck, neck) for _ in range(2))
        self.heads = nn.ModuleList(Head(neck, neck, stride) for stride in STRIDES)
        self.fine = nn.Sequential(convolution(neck, widths[1], size=1), nn.Upsample(scale_factor=2, mode="nearest"))
        self.prototypes = nn.Sequential(convolution(widths[1], 2 * PROTOTYPES), nn.Conv2d(2 * PROTOTYPES, PROTOTYPES, 1),
                                        nn.Upsample(scale_factor=2, mode="bilinear", align_corners=False))
        self.sharpening = nn.Sequential(convolution(widths[0] + PROTOTYPES, EDGES), nn.Conv2d(EDGES, PROTOTYPES, 1))
        # Zero at first, so that a network trained without it is unchanged.
        for parameter in self.sharpening[1].parameters():
            nn.init.zeros_(parameter)

    def forward(self, picture: Tensor) -> Prediction:
        maps, prototypes = self.maps(picture)
        scores, distances, coefficients = (torch.cat([part.flatten(2) for part in kind], 2).transpose(1, 2)
                                           for kind in zip(*maps))
        return Prediction(scores, distances, coefficients, prototypes)

    def maps(self, picture: Tensor) -> tuple[list[tuple[Tensor, Tensor, Tensor]], Tensor]:
        """Scores, distances and coefficients of each stride as maps [B, n, H/stride, W/stride]; and the prototypes.

        Prototypes are computed at a quarter of the size, and then sharpened with edge features at half of it: at a quarter, a
        person of 40 rows is only three cells wide.
        """
        edges = self.edges(picture)
        fine = self.stem(edges)
        pyramid = self._pyramid(fine)
        maps = [head(features) for head, features in zip(self.heads, pyramid)]
        prototypes = self.prototypes(fine + self.fine(pyramid[0]))
        return maps, prototypes + self.sharpening(torch.cat((edges, prototypes), 1))

    def _pyramid(self, fine: Tensor) -> list[Tensor]:
        """Features of the three strides, each including the coarser ones (Lin et al., FPN, 2017)."""
        levels = []
        features = fine
        for down, lateral in zip(self.stages, self.laterals):
            features = down(features)
            levels.append(lateral(features))
        for level in (1, 0):
            coarser = nn.functional.interpolate(levels[level + 1], scale_factor=2, mode="nearest")
            levels[level] = self.smooth[level](levels[level] + coarser)
        return levels


def cell_middles(height: int, width: int) -> tuple[Tensor, Tensor]:
    """Middles [cells, 2] (x, y) and strides [cells] of all cells for an input of this size, in the order of Prediction."""
    middles, strides = [], []
    for stride in STRIDES:
        y, x = torch.meshgrid(torch.arange(height // stride), torch.arange(width // stride), indexing="ij")
        middles.append((torch.stack((x, y), -1).reshape(-1, 2) + 0.5) * stride)
        strides.append(torch.full((len(middles[-1]),), float(stride)))
    return torch.cat(middles), torch.cat(strides)
