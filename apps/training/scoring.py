"""Recall and precision of the instances in a picture."""

from typing import Iterable, NamedTuple

import numpy as np

from dataset import CLASS_OF_MOTS, MOTS_IDS_PER_CLASS
from detect import Instance

# Least height of instances that count, and least overlap of matching masks.
MIN_HEIGHT_PX = 40
MIN_IOU = 0.6


class Counts(NamedTuple):
    """Instances of one class, over some pictures."""

    there: int = 0  # above the height
    found: int = 0  # of those, with a matching mask
    reported: int = 0  # by the network, above the height
    right: int = 0  # of those, matching an instance of any height
    iou: float = 0.0  # summed over those found

    def __add__(self, other: "Counts") -> "Counts":
        return Counts(*(a + b for a, b in zip(self, other)))

    def recall(self) -> float:
        return self.found / self.there if self.there else float("nan")

    def precision(self) -> float:
        return self.right / self.reported if self.reported else float("nan")

    def mean_iou(self) -> float:
        return self.iou / self.found if self.found else float("nan")


def height_of(mask: np.ndarray) -> int:
    rows = np.flatnonzero(mask.any(1))
    return int(rows[-1] - rows[0] + 1) if len(rows) else 0


def true_masks(instances: np.ndarray, class_of: int) -> list[np.ndarray]:
    """The masks of a class in a picture of MOTS ids."""
    identities = np.unique(instances[instances > 0])
    return [instances == identity for identity in identities
            if CLASS_OF_MOTS.get(int(identity) // MOTS_IDS_PER_CLASS) == class_of]


def iou(a: np.ndarray, b: np.ndarray) -> float:
    common = np.count_nonzero(a & b)
    return common / max(1, np.count_nonzero(a) + np.count_nonzero(b) - common)


def match(found: Iterable[np.ndarray], truth: list[np.ndarray], min_iou: float) -> tuple[dict[int, float], dict[int, float]]:
    """Matches found masks, best first, each with the best unmatched true one; IoU by index found and by index true."""
    of_found: dict[int, float] = {}
    of_truth: dict[int, float] = {}
    for index, mask in enumerate(found):
        free = {other: iou(mask, truth[other]) for other in range(len(truth)) if other not in of_truth}
        best = max(free, key=free.get, default=None)
        if best is not None and free[best] >= min_iou:
            of_found[index] = of_truth[best] = free[best]
    return of_found, of_truth


class Findings(NamedTuple):
    """One class of one picture: found instances, best first, true masks, and matches between them."""

    found: list[Instance]
    truth: list[np.ndarray]
    of_found: dict[int, float]  # IoU by index found
    of_truth: dict[int, float]  # the same by index true

    def counts(self) -> Counts:
        there = [index for index, mask in enumerate(self.truth) if height_of(mask) >= MIN_HEIGHT_PX]
        reported = self._reported()
        return Counts(len(there), sum(index in self.of_truth for index in there), len(reported),
                      sum(index in self.of_found for index in reported), sum(self.of_truth.get(index, 0.0) for index in there))

    def beyond_truth(self) -> list[Instance]:
        """Found instances above the height without a match."""
        return [self.found[index] for index in self._reported() if index not in self.of_found]

    def _reported(self) -> list[int]:
        return [index for index, instance in enumerate(self.found) if height_of(instance.mask) >= MIN_HEIGHT_PX]


def compare(found: list[Instance], instances: np.ndarray, class_of: int, min_iou: float = MIN_IOU) -> Findings:
    """Compares one class of one picture with its truth; `found` best first."""
    of_class = [instance for instance in found if instance.class_of == class_of]
    truth = true_masks(instances, class_of)
    return Findings(of_class, truth, *match([instance.mask for instance in of_class], truth, min_iou))
