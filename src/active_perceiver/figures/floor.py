"""The room from above: where a robot can stand, the goal states, and the paths of searches (the paper's figure 4)."""

from __future__ import annotations

import io
from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.colors import LinearSegmentedColormap
from matplotlib.figure import Figure
from numpy.typing import ArrayLike, NDArray
from PIL import Image

from active_perceiver.figures.style import FLOOR, GOAL, INK, MUTED, OBSTACLE, OBSTACLE_EDGE, PATH, START
from active_perceiver.scenes import Scene

# From where the search starts (light) to where it ends (dark).
_TIME = LinearSegmentedColormap.from_list("time", ["#a9c8ff", PATH, "#0b2a6b"])


def draw_floor(axes: Axes, scene: Scene) -> None:
    """Draw the floor plan, or just the places if the scene has no plan, in metres."""
    axes.set_aspect("equal")
    axes.axis("off")
    plan = scene.floor_plan
    if plan is not None:
        axes.fill(plan.outline[:, 0], plan.outline[:, 1], facecolor=FLOOR, edgecolor=INK, linewidth=2)
        for label, polygon in plan.obstacles:
            axes.fill(polygon[:, 0], polygon[:, 1], facecolor=OBSTACLE, edgecolor=OBSTACLE_EDGE, linewidth=0.8)
            if np.ptp(polygon, axis=0).min() > 0.3 and np.ptp(polygon, axis=0).max() > 0.55:
                x, z = polygon.mean(0).tolist()
                axes.text(x, z, label.replace("_", " "), ha="center", va="center", fontsize=7, color=MUTED)
    places = np.unique(scene.poses[:, :2], axis=0)
    axes.scatter(places[:, 0], places[:, 1], s=5, color=MUTED, alpha=0.6, linewidths=0, zorder=2)


def draw_poses(axes: Axes, poses: NDArray[np.floating], colour: str, scale: float = 1.0) -> None:
    """Draw poses (N, 4) as arrows from where the robot stands to where it looks."""
    heading = np.radians(poses[:, 2])
    axes.quiver(
        *poses[:, :2].T, np.sin(heading), np.cos(heading), color=colour, angles="xy", scale_units="xy",
        scale=5.0 / scale, width=0.009, headwidth=4, headlength=4, headaxislength=3.5, zorder=5,
    )  # fmt: skip


def draw_path(axes: Axes, poses: ArrayLike) -> None:
    """Draw one search, (N, 4) poses: lighter at its start, darker at its end."""
    poses = np.asarray(poses, float)
    places = poses[:, :2] + _fan_out(poses)
    segments = np.stack([places[:-1], places[1:]], axis=1)
    lines = LineCollection(list(segments), cmap=_TIME, linewidths=2.2, zorder=4, capstyle="round")
    lines.set_array(np.linspace(0, 1, max(1, len(segments))))
    axes.add_collection(lines)
    axes.scatter(places[0, 0], places[0, 1], s=46, color=START, edgecolors="white", linewidths=1, zorder=6)
    draw_poses(axes, np.hstack([places[-1], poses[-1, 2:]])[None], "#0b2a6b", scale=1.3)


def _fan_out(poses: NDArray[np.floating]) -> NDArray[np.float64]:
    """Small offsets along the heading, so that turning on the spot shows as a small loop."""
    heading = np.radians(poses[:, 2])
    return 0.045 * np.stack([np.sin(heading), np.cos(heading)], axis=1)


def trajectory_figure(
    scene: Scene, paths: Sequence[ArrayLike], goals: NDArray[np.bool_] | None = None, title: str = ""
) -> Figure:
    """One floor plan with goal states (green arrows) and paths (blue, from an orange start).

    Args:
        scene: the room.
        paths: each (N, 4) poses.
        goals: (S,) bool, goal states of the target.
        title: above the plan.
    """
    figure = Figure(figsize=(5, 5), dpi=130, layout="constrained")
    axes = figure.subplots()
    draw_floor(axes, scene)
    if goals is not None:
        draw_poses(axes, scene.poses[goals], GOAL)
    for path in paths:
        draw_path(axes, path)
    axes.set_title(title, fontsize=11, color=INK)
    return figure


def figure_png(figure: Figure) -> bytes:
    """The figure as an encoded PNG."""
    out = io.BytesIO()
    figure.savefig(out, format="png", facecolor="white")
    return out.getvalue()


def figure_image(figure: Figure) -> NDArray[np.uint8]:
    """The figure as pixels, (H, W, 3) uint8."""
    return np.asarray(Image.open(io.BytesIO(figure_png(figure))).convert("RGB"))
