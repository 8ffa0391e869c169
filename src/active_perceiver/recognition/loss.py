"""Losses that recognisers are trained with."""

from __future__ import annotations

import torch
from torch import Tensor
from torch.nn import functional

BOX_WEIGHT = 0.5
"""Weight of the box error in the paper's loss."""


def paper_loss(logits: Tensor, boxes: Tensor, present: Tensor, truth: Tensor) -> Tensor:
    """The paper's loss (section IV-A): sum of binary cross-entropy + 0.5 * sum of squared box error where present.

    Args:
        logits: (P,) presence.
        boxes: (P, 4).
        present: (P,) 0 or 1.
        truth: (P, 4); anything finite where not present.

    Returns:
        Scalar.
    """
    presence = functional.binary_cross_entropy_with_logits(logits, present, reduction="sum")
    return presence + BOX_WEIGHT * (present * (boxes - truth).square().sum(1)).sum()


def iou(one: Tensor, other: Tensor) -> Tensor:
    """Intersection over union of boxes (..., 4), differentiable; see `metrics.box_iou` for the NumPy form."""
    low = torch.maximum(one[..., :2] - one[..., 2:] / 2, other[..., :2] - other[..., 2:] / 2)
    high = torch.minimum(one[..., :2] + one[..., 2:] / 2, other[..., :2] + other[..., 2:] / 2)
    shared = (high - low).clamp(min=0.0).prod(-1)
    return shared / (one[..., 2:].prod(-1) + other[..., 2:].prod(-1) - shared).clamp(min=1e-9)


def centre_heat(truth: Tensor, present: Tensor, rows: int, columns: int) -> Tensor:
    """The heat map to be learned: a bump as large as the object, exactly 1 at the cell of its centre.

    Zhou, Wang, Kraehenbuehl, "Objects as Points", 2019, section 3; the bump follows the box's width and height.

    Args:
        truth: (P, 4) boxes.
        present: (P,) 0 or 1.
        rows: height of the map.
        columns: width of the map.

    Returns:
        (P, rows, columns), zero where not present.
    """
    x = (torch.arange(columns) + 0.5) / columns
    y = (torch.arange(rows) + 0.5) / rows
    across = (x[None, None, :] - truth[:, 0, None, None]) / (truth[:, 2, None, None] / 2 + 0.5 / columns)
    down = (y[None, :, None] - truth[:, 1, None, None]) / (truth[:, 3, None, None] / 2 + 0.5 / rows)
    heat = torch.exp(-4.0 * (across.square() + down.square()))
    column = (truth[:, 0] * columns).long().clamp(0, columns - 1)
    row = (truth[:, 1] * rows).long().clamp(0, rows - 1)
    heat[torch.arange(len(truth)), row, column] = 1.0
    return heat * present[:, None, None]


def focal_loss(logits: Tensor, heat: Tensor) -> Tensor:
    """Focal loss of a heat map, summed (Law, Deng, "CornerNet", ECCV 2018, equation 1, with alpha 2 and beta 4).

    Args:
        logits: (P, h, w).
        heat: (P, h, w) in 0..1; cells with 1 are centres.
    """
    probability = logits.sigmoid()
    centre = (1.0 - probability).square() * functional.logsigmoid(logits)
    elsewhere = (1.0 - heat) ** 4 * probability.square() * functional.logsigmoid(-logits)
    return -torch.where(heat >= 1.0, centre, elsewhere).sum()


def centre_loss(logits: Tensor, boxes: Tensor, present: Tensor, truth: Tensor) -> Tensor:
    """Loss of a centre heat map with a box in each cell.

    The heat map's focal loss, and for cells near the centre 1 - IoU (Yu et al., "UnitBox", 2016) and a smooth L1
    error (Girshick, "Fast R-CNN", 2015), which pulls on boxes that do not overlap at all.

    Args:
        logits: (P, h, w) of the centre's heat map.
        boxes: (P, 4, h, w) the box that each cell proposes.
        present: (P,) 0 or 1.
        truth: (P, 4); anything finite where not present.

    Returns:
        Scalar.
    """
    heat = centre_heat(truth, present, *logits.shape[1:])
    loss = focal_loss(logits, heat) / present.sum().clamp(min=1.0)
    pair, row, column = torch.nonzero(heat > 0.5, as_tuple=True)
    if len(pair) == 0:
        return loss
    proposed, right = boxes[pair, :, row, column], truth[pair]
    distance = functional.smooth_l1_loss(proposed, right, beta=0.02)
    return loss + 2.0 * ((1.0 - iou(proposed, right)).mean() + 5.0 * distance)
