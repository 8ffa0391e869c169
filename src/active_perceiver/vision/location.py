"""The location mask: where in the image the target is seen, as the policy gets it (the paper, section IV-B)."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

GRID = 5
"""The location mask has GRID x GRID cells."""


def location_mask(boxes: ArrayLike) -> NDArray[np.float32]:
    """Binary 5 x 5 image of a box: a cell is 1 where the box covers part of it.

    Touching an edge is not covering, and neither is a box without extent.

    Args:
        boxes: (..., 4) centre x, centre y, width, height as fractions of the image; NaN where nothing is seen.

    Returns:
        (..., 25) float32, rows from top to bottom, each from left to right; all zeros where nothing is seen.

    Raises:
        ValueError: if the last axis is not 4 long.
    """
    boxes = np.asarray(boxes, np.float64)
    if boxes.shape[-1:] != (4,):
        raise ValueError(f"boxes need a last axis of 4 (centre x, centre y, width, height), got shape {boxes.shape}")
    columns = _covered(boxes[..., 0], boxes[..., 2])
    rows = _covered(boxes[..., 1], boxes[..., 3])
    cells = rows[..., :, None] & columns[..., None, :]
    return cells.reshape(*boxes.shape[:-1], GRID * GRID).astype(np.float32)


def _covered(centre: NDArray[np.float64], size: NDArray[np.float64]) -> NDArray[np.bool_]:
    """Which of the GRID intervals of 0..1 an interval overlaps, (..., GRID); comparisons with NaN are false."""
    low, high = (centre - size / 2)[..., None], (centre + size / 2)[..., None]
    edges = np.arange(GRID + 1) / GRID
    return (low < edges[1:]) & (high > edges[:-1]) & (low < high)
