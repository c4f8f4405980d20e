"""Assignment of cells to objects, and losses.

Cells are assigned by their present predictions; the target score is the quality of their box (Feng et al., TOOD: task-aligned
one-stage object detection, 2021). Boxes: generalised IoU (Rezatofighi et al., 2019). Masks: cross-entropy inside the box (Bolya et
al., YOLACT, 2019) and the Dice loss (Milletari et al., V-Net, 2016).
"""

from typing import NamedTuple

import torch
from torch import Tensor
from torch.nn import functional

from dataset import Batch, Objects
from network import PROTOTYPE_STRIDE, STRIDES, Prediction, cell_middles

SCORE_WEIGHT, BOX_WEIGHT, MASK_WEIGHT = 1.0, 2.0, 2.0

# Powers a and b of TOOD's alignment score^a * IoU^b; cells assigned to one object.
SCORE_POWER, IOU_POWER = 0.5, 4.0
CELLS_PER_OBJECT = 9

# Only objects that cover at least this fraction of one of a cell's prototype cells may be assigned to it.
MIN_COVERED = 0.4
# Masks in the loss of each picture; all of them would take long without much benefit.
MASKS_PER_PICTURE = 10


class Assignment(NamedTuple):
    """The cells of one picture that are assigned to an object."""

    cells: Tensor  # [p]
    objects: Tensor  # [p]
    qualities: Tensor  # [p]: the target score


class Losses(NamedTuple):
    score: Tensor
    box: Tensor
    mask: Tensor

    def total(self) -> Tensor:
        return SCORE_WEIGHT * self.score + BOX_WEIGHT * self.box + MASK_WEIGHT * self.mask


def boxes_of(distances: Tensor, middles: Tensor) -> Tensor:
    """Corners [..., 4] of boxes from distances to the middles of their cells."""
    return torch.cat((middles - distances[..., :2], middles + distances[..., 2:]), -1)


def overlap(a: Tensor, b: Tensor) -> tuple[Tensor, Tensor]:
    """IoU of boxes and, for the generalised one, the fraction of their common hull that neither covers."""
    size = (torch.minimum(a[..., 2:], b[..., 2:]) - torch.maximum(a[..., :2], b[..., :2])).clamp(min=0)
    hull = torch.maximum(a[..., 2:], b[..., 2:]) - torch.minimum(a[..., :2], b[..., :2])
    common = size.prod(-1)
    union = (a[..., 2:] - a[..., :2]).prod(-1) + (b[..., 2:] - b[..., :2]).prod(-1) - common
    hull_area = hull.prod(-1)
    return common / union.clamp(min=1e-6), (hull_area - union) / hull_area.clamp(min=1e-6)


def _on_cells(maps: Tensor) -> Tensor:
    """The largest value of each map [n, H/2, W/2] in every cell of all strides: [n, cells]."""
    pooled = [functional.max_pool2d(maps[:, None], stride // PROTOTYPE_STRIDE).flatten(1) for stride in STRIDES]
    return torch.cat(pooled, 1)


@torch.no_grad()
def assign(scores: Tensor, boxes: Tensor, objects: Objects) -> Assignment:
    """Assigns cells of a picture to its objects: among cells that see an object, those with the best present alignment."""
    count = len(objects.classes)
    if count == 0:
        none = torch.zeros(0, dtype=torch.int64)
        return Assignment(none, none, torch.zeros(0))
    iou, _ = overlap(objects.boxes[:, None], boxes[None])
    allowed = _on_cells(objects.masks) >= MIN_COVERED
    alignment = scores.sigmoid()[:, objects.classes].T ** SCORE_POWER * iou ** IOU_POWER * allowed
    best, cells = alignment.topk(CELLS_PER_OBJECT, 1)
    chosen = torch.zeros_like(alignment).scatter(1, cells, best)
    # A cell is assigned to one object only.
    strongest, owner = chosen.max(0)
    cells = torch.nonzero(strongest > 0)[:, 0]
    owner = owner[cells]
    of_object = torch.where(chosen > 0, iou, iou.new_zeros(())).amax(1)
    qualities = strongest[cells] / chosen.amax(1)[owner] * of_object[owner]
    return Assignment(cells, owner, qualities)


def score_loss(scores: Tensor, assignment: Assignment, objects: Objects) -> Tensor:
    """Cross-entropy with the target scores, summed over a picture's cells without the ignored ones."""
    asked = torch.zeros_like(scores)
    asked[assignment.cells, objects.classes[assignment.objects]] = assignment.qualities
    counted = _on_cells(objects.ignored[None])[0] < 0.5
    counted[assignment.cells] = True
    losses = functional.binary_cross_entropy_with_logits(scores, asked, reduction="none")
    return (losses * counted[:, None]).sum()


def mask_loss(coefficients: Tensor, prototypes: Tensor, boxes: Tensor, masks: Tensor) -> Tensor:
    """Sum over instances of cross-entropy and Dice loss inside their boxes, widened by a prototype cell.

    `prototypes`: [H/2, W/2, prototypes].
    """
    logits = (coefficients @ prototypes.flatten(0, 1).T).view(masks.shape)
    left, top, right, bottom = (boxes / PROTOTYPE_STRIDE).T[..., None]
    y, x = torch.arange(masks.shape[1]), torch.arange(masks.shape[2])
    inside = (((y >= top - 1) & (y < bottom + 1))[:, :, None] & ((x >= left - 1) & (x < right + 1))[:, None]).float()
    entropy = functional.binary_cross_entropy_with_logits(logits, masks, reduction="none")
    entropy = (entropy * inside).sum((1, 2)) / inside.sum((1, 2))
    found = logits.sigmoid() * inside
    dice = 1 - (2 * (found * masks).sum((1, 2)) + 1) / (found.sum((1, 2)) + masks.sum((1, 2)) + 1)
    return (entropy + dice).sum()


def losses(prediction: Prediction, batch: Batch) -> Losses:
    """Mean losses of a batch; box losses are weighted by the target scores."""
    middles, _ = cell_middles(*batch.pictures.shape[2:])
    all_boxes = boxes_of(prediction.distances, middles)
    prototypes_by_pixel = prediction.prototypes.permute(0, 2, 3, 1)
    score = box = mask = prediction.scores.new_zeros(())
    asked, compared = 0.0, 0
    for scores, boxes, coefficients, prototypes, objects in zip(prediction.scores, all_boxes, prediction.coefficients,
                                                                prototypes_by_pixel, batch.objects):
        assignment = assign(scores.detach(), boxes.detach(), objects)
        score = score + score_loss(scores, assignment, objects)
        if len(assignment.cells) == 0:
            continue
        asked += float(assignment.qualities.sum())
        iou, outside = overlap(boxes[assignment.cells], objects.boxes[assignment.objects])
        box = box + ((1 - iou + outside) * assignment.qualities).sum()
        picked = torch.randperm(len(assignment.cells))[:MASKS_PER_PICTURE]
        cells, owners = assignment.cells[picked], assignment.objects[picked]
        mask = mask + mask_loss(coefficients[cells], prototypes, objects.boxes[owners], objects.masks[owners])
        compared += len(picked)
    return Losses(score / max(asked, 1.0), box / max(asked, 1.0), mask / max(compared, 1))
