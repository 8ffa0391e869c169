"""The room from above: where a robot can stand, the goal states, and the paths of searches (the paper's figure 4)."""

from __future__ import annotations

import io
import re
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.colors import LinearSegmentedColormap, to_hex, to_rgb
from matplotlib.figure import Figure
from numpy.typing import ArrayLike, NDArray
from PIL import Image

from active_perceiver.figures.style import FLOOR, GOAL, INK, MUTED, OBSTACLE, OBSTACLE_EDGE, PATHS, START
from active_perceiver.scenes.floor_plan import HasFloorPlan

PANELS_PER_ROW = 4
# Metres between two searches drawn on the same lattice edge, and between the first and the last of many.
_APART, _SPREAD = 0.05, 0.22
# Metres around the places of a scene without a floor plan: arrows that stand there and look outwards fit.
_AROUND = 0.3
# Half the width in metres of what is shown, at least, around a path in a room of which nothing is known.
_LEAST_HALF = 1.0


@dataclass(frozen=True, eq=False)
class SearchPanel:
    """What one floor plan shows.

    Attributes:
        title: above the plan.
        paths: searches, each (N, 4) poses, N at least 1.
        goals: (S,) bool, goal states of the target; None for none.
    """

    title: str
    paths: Sequence[ArrayLike]
    goals: NDArray[np.bool_] | None = None


def draw_room(axes: Axes, room: HasFloorPlan | None, paths: Sequence[ArrayLike]) -> None:
    """Draw the room of searches: its floor, or, where nothing is known of it, a grid of metres around the paths.

    Args:
        axes: where.
        room: what is known of it.
        paths: whole searches, each (N, 4) poses; at least one if nothing is known of the room.
    """
    if room is not None:
        draw_floor(axes, room)
        return
    places = np.concatenate([np.asarray(path, float)[:, :2] for path in paths])
    low, high = places.min(0), places.max(0)
    half = max(float((high - low).max()) / 2 + _AROUND, _LEAST_HALF)
    x, z = ((low + high) / 2).tolist()
    axes.set(xlim=(x - half, x + half), ylim=(z - half, z + half), aspect="equal")
    axes.set_xlabel("x, m", fontsize=9, color=MUTED)
    axes.set_ylabel("z, m", fontsize=9, color=MUTED)
    axes.tick_params(labelsize=8, colors=MUTED)
    axes.grid(color=FLOOR, linewidth=1.2)
    axes.set_axisbelow(True)
    for spine in axes.spines.values():
        spine.set_color(OBSTACLE_EDGE)


def draw_floor(axes: Axes, scene: HasFloorPlan, details: bool = True) -> None:
    """Draw the floor plan, or just the places if the scene has no plan, in metres.

    Args:
        axes: where.
        scene: the room.
        details: whether large obstacles are named and places are dotted.
    """
    axes.set_aspect("equal")
    axes.axis("off")
    plan = scene.floor_plan
    if plan is not None:
        axes.fill(*plan.outline.T, facecolor=FLOOR, zorder=0)
        for label, polygon in plan.obstacles:
            axes.fill(*polygon.T, facecolor=OBSTACLE, edgecolor=OBSTACLE_EDGE, linewidth=0.8)
            if details:
                _name_obstacle(axes, label, polygon)
        axes.fill(*plan.outline.T, fill=False, edgecolor=INK, linewidth=2)
    places = np.unique(scene.poses[:, :2], axis=0)
    if plan is None:
        (left, low), (right, high) = (places.min(0) - _AROUND).tolist(), (places.max(0) + _AROUND).tolist()
        axes.set(xlim=(left, right), ylim=(low, high))
    if details or plan is None:
        axes.scatter(places[:, 0], places[:, 1], s=5, color=MUTED, alpha=0.6, linewidths=0, zorder=2)


def _name_obstacle(axes: Axes, label: str, polygon: NDArray[np.floating]) -> None:
    """Write what an obstacle is, unless it is too small for that."""
    width, depth = np.ptp(polygon, axis=0).tolist()
    if min(width, depth) > 0.3 and max(width, depth) > 0.55:
        x, z = polygon.mean(0).tolist()
        name = re.sub(r"_\d+$", "", label).replace("_", " ")
        upright = 90 if depth > 1.5 * width else 0
        axes.text(x, z, name, ha="center", va="center", rotation=upright, fontsize=7, color=MUTED)


def draw_poses(axes: Axes, poses: NDArray[np.floating], colour: str, scale: float = 1.0) -> None:
    """Draw poses (N, 4) as arrows from where the robot stands to where it looks."""
    heading = np.radians(poses[:, 2])
    axes.quiver(
        *poses[:, :2].T, np.sin(heading), np.cos(heading), color=colour, angles="xy", scale_units="xy",
        scale=5.0 / scale, width=0.009, headwidth=4, headlength=4, headaxislength=3.5, zorder=5,
    )  # fmt: skip


def draw_path(axes: Axes, poses: ArrayLike, colour: str = PATHS[0], shift: float = 0.0) -> None:
    """Draw one search: lighter at its start, darker at its end.

    Args:
        axes: a floor plan.
        poses: (N, 4), N at least 1.
        colour: of the middle of the path.
        shift: metres by which the path is moved to the right and down, so that it does not hide another.

    Raises:
        ValueError: if the poses have another shape.
    """
    poses = np.asarray(poses, float)
    if poses.ndim != 2 or poses.shape[1] != 4 or not len(poses):
        raise ValueError(f"a path is (N, 4) poses, at least one, got {poses.shape}")
    light, dark = _mixed(colour, 1.0, 0.6), _mixed(colour, 0.0, 0.4)
    time = LinearSegmentedColormap.from_list("time", [light, to_rgb(colour), dark])
    places = poses[:, :2] + _fan_out(poses) + np.array([shift, -shift])
    segments = np.stack([places[:-1], places[1:]], axis=1)
    lines = LineCollection(list(segments), cmap=time, linewidths=2.2, zorder=4, capstyle="round")
    lines.set_array(np.linspace(0, 1, max(1, len(segments))))
    axes.add_collection(lines)
    axes.scatter(places[0, 0], places[0, 1], s=46, color=START, edgecolors="white", linewidths=1, zorder=6)
    draw_poses(axes, np.hstack([places[-1], poses[-1, 2:]])[None], to_hex(dark), scale=1.3)


def _mixed(colour: str, grey: float, share: float) -> tuple[float, float, float]:
    """A colour mixed with a share of grey, 0 (black) to 1 (white)."""
    red, green, blue = (share * grey + (1 - share) * value for value in to_rgb(colour))
    return red, green, blue


def _fan_out(poses: NDArray[np.floating]) -> NDArray[np.float64]:
    """Small offsets along the heading, so that turning on the spot shows as a small loop."""
    heading = np.radians(poses[:, 2])
    return 0.045 * np.stack([np.sin(heading), np.cos(heading)], axis=1)


def trajectory_figure(
    scene: HasFloorPlan | None, paths: Sequence[ArrayLike], goals: NDArray[np.bool_] | None = None, title: str = ""
) -> Figure:
    """One floor plan with goal states (green arrows) and paths (blue, from an orange start).

    Args:
        scene: the room; None if nothing is known of it.
        paths: each (N, 4) poses; at least one without a room.
        goals: (S,) bool, goal states of the target, in a room that is known.
        title: above the plan.
    """
    figure = Figure(figsize=(5, 5), dpi=130, layout="constrained")
    _draw_panel(figure.subplots(), scene, SearchPanel(title, paths, goals))
    return figure


def trajectory_panels(scene: HasFloorPlan, panels: Sequence[SearchPanel], title: str = "") -> Figure:
    """Several floor plans of one room side by side, up to four in a row, for instance one for each target.

    Args:
        scene: the room.
        panels: what each plan shows; the searches of one plan differ in colour and lie beside each other.
        title: above all.

    Raises:
        ValueError: if there is no panel, or if a path or the goals of one have a wrong shape.
    """
    if not panels:
        raise ValueError("at least one panel is needed")
    columns = min(PANELS_PER_ROW, len(panels))
    rows = -(-len(panels) // columns)
    width, height = panel_size(scene, 3.3)
    figure = Figure(figsize=(columns * width, rows * (height + 0.3) + 0.4), dpi=130, layout="constrained")
    grid = figure.subplots(rows, columns, squeeze=False).ravel()
    for axes, panel in zip(grid, panels, strict=False):
        _draw_panel(axes, scene, panel)
    for axes in grid[len(panels) :]:
        axes.remove()
    if title:
        figure.suptitle(title, fontsize=14, color=INK)
    return figure


def panel_size(scene: HasFloorPlan, longest: float) -> tuple[float, float]:
    """Width and height in inches of a plan whose longer side is `longest`; a very narrow room gets some margin."""
    plan = scene.floor_plan
    extent = np.ptp(scene.poses[:, :2] if plan is None else plan.outline, axis=0).astype(float)
    extent += 2 * _AROUND if plan is None else 0.0
    width, height = (longest * np.maximum(extent / max(extent.max(), 1e-6), 0.4)).tolist()
    return width, height


def _draw_panel(axes: Axes, scene: HasFloorPlan | None, panel: SearchPanel) -> None:
    draw_room(axes, scene, panel.paths)
    if scene is not None and panel.goals is not None:
        if np.shape(panel.goals) != (len(scene.poses),):
            raise ValueError(
                f"goals are one bool for each of {len(scene.poses)} states, got shape {np.shape(panel.goals)}"
            )
        draw_poses(axes, scene.poses[np.asarray(panel.goals, bool)], GOAL)
    count = len(panel.paths)
    shifts = (np.arange(count) - (count - 1) / 2) * min(_APART, _SPREAD / max(1, count))
    for index, (path, shift) in enumerate(zip(panel.paths, shifts.tolist(), strict=True)):
        draw_path(axes, path, PATHS[index % len(PATHS)], shift)
    axes.set_title(panel.title, fontsize=11, color=INK)


def figure_png(figure: Figure) -> bytes:
    """The figure as an encoded PNG."""
    out = io.BytesIO()
    figure.savefig(out, format="png", facecolor="white")
    return out.getvalue()


def figure_image(figure: Figure) -> NDArray[np.uint8]:
    """The figure as pixels, (H, W, 3) uint8."""
    return np.asarray(Image.open(io.BytesIO(figure_png(figure))).convert("RGB"))
