"""How undecided a policy is at each place of a room, for instance at the start, middle and end of its training."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import PatchCollection
from matplotlib.figure import Figure
from matplotlib.patches import Polygon, Rectangle
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from active_perceiver.figures.floor import draw_floor, panel_size
from active_perceiver.figures.style import INK
from active_perceiver.scenes import Scene

COLOURS = "viridis"
# Share of the lattice spacing that a square takes, so that a little of the floor shows between two.
_FILL = 0.92


def entropy_maps(
    scene: Scene, rows: Mapping[str, Sequence[NDArray[np.floating]]], columns: Sequence[str], most: float
) -> Figure:
    """Floor plans with the policy's entropy at each place, averaged over headings and tilts; one scale for all.

    Args:
        scene: the room.
        rows: for each row's label, for each column (S,) entropies in nats, 0..most, of the policy at each state.
        columns: titles above the columns.
        most: the end of the colour scale in nats, the logarithm of the number of actions.

    Raises:
        ValueError: if there is nothing to draw, if a row does not fit the columns or the scene, or if an entropy is
            not a number from 0 to `most`.
    """
    if not rows or not columns or not 0 < most < np.inf:
        raise ValueError(f"at least one row, one column and a positive scale are needed, got {most} nats")
    for label, row in rows.items():
        _check(scene, label, row, columns, most)
    width, height = panel_size(scene, 3.2)
    figure = Figure(
        figsize=(len(columns) * width + 1.3, len(rows) * height + 0.5), dpi=130, layout="constrained"
    )  # fmt: skip
    grid = figure.subplots(len(rows), len(columns), squeeze=False)
    for row_axes, row in zip(grid, rows.values(), strict=True):
        for axes, entropy in zip(row_axes, row, strict=True):
            draw_floor(axes, scene, details=False)
            squares = _draw_squares(axes, scene, entropy, most)
    for axes, title in zip(grid[0], columns, strict=True):
        axes.set_title(title, fontsize=12, color=INK)
    for axes, label in zip(grid[:, 0], rows, strict=True):
        # The axes are switched off, and with them their own labels.
        axes.annotate(
            label, (0, 0.5), (-6, 0), "axes fraction", "offset points", rotation=90, ha="right", va="center",
            fontsize=12, color=INK, annotation_clip=False,
        )  # fmt: skip
    bar = figure.colorbar(squares, ax=grid, shrink=0.9, aspect=28 if len(rows) > 1 else 18, pad=0.02)
    bar.set_label("mean entropy (nats)", fontsize=11, color=INK)
    bar.ax.tick_params(labelsize=9, colors=INK)
    bar.outline.set_visible(False)
    return figure


def mean_by_place(
    poses: NDArray[np.floating], values: NDArray[np.floating]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Average over all headings and tilts at each place.

    Args:
        poses: (S, 4).
        values: (S,).

    Returns:
        (P, 2) places in metres, to the millimetre, and (P,) means.
    """
    places, place = np.unique(np.round(poses[:, :2].astype(float), 3), axis=0, return_inverse=True)
    place = place.ravel()  # NumPy 2.0 returns it with a second axis
    return places, np.bincount(place, values, len(places)) / np.bincount(place, minlength=len(places))


def lattice_spacing(places: NDArray[np.floating]) -> float:
    """The side in metres of equal squares along x and z around the places that do not overlap.

    On the lattices that robots move on, it is the distance of neighbours; 0.5 for a single place. Measured places
    keep no even distance: squares are at least half the usual one, even if the two closest places then overlap.
    """
    if len(places) < 2:
        return 0.5
    distance, _ = cKDTree(places).query(places, k=2, p=np.inf)
    nearest = distance[:, 1]
    return float(max(nearest.min(), np.median(nearest) / 2))


def _check(scene: Scene, label: str, row: Sequence[NDArray], columns: Sequence[str], most: float) -> None:
    if len(row) != len(columns):
        raise ValueError(f"{label}: {len(columns)} columns are needed, got {len(row)}")
    for title, entropy in zip(columns, row, strict=True):
        if np.shape(entropy) != (len(scene),):
            raise ValueError(f"{label}, {title}: {len(scene)} entropies are needed, got shape {np.shape(entropy)}")
        # Single precision may put a uniform policy slightly beyond the logarithm; NaN fails both comparisons.
        if not ((np.asarray(entropy) >= -1e-4) & (np.asarray(entropy) <= most + 1e-4)).all():
            raise ValueError(f"{label}, {title}: each entropy is a number from 0 to {most:.4g} nats")


def _draw_squares(axes: Axes, scene: Scene, entropy: NDArray[np.floating], most: float) -> PatchCollection:
    places, means = mean_by_place(scene.poses, entropy)
    side = _FILL * lattice_spacing(places)
    # On the floor, but under what stands on it.
    squares = PatchCollection(
        [Rectangle((x - side / 2, z - side / 2), side, side) for x, z in places.tolist()],
        cmap=COLOURS, linewidths=0, zorder=0.5,
    )  # fmt: skip
    squares.set_array(means)
    squares.set_clim(0, most)
    axes.add_collection(squares)
    if scene.floor_plan is not None:  # a wide lattice's squares would reach through the walls
        squares.set_clip_path(Polygon(scene.floor_plan.outline, transform=axes.transData))
    return squares
