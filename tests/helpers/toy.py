"""A toy scene for tests: a square room of painted walls with coloured balls, drawn by a 20-line ray caster."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from active_perceiver.scenes import EIGHT_ACTIONS, Action, FloorPlan, Scene, Target
from active_perceiver.scenes.images import encode_image
from active_perceiver.scenes.lattice import lattice_poses, lattice_transitions

STEP = 0.4
CAMERA_HEIGHT = 1.2
CEILING = 2.4
COLOURS = np.array([[220, 30, 30], [30, 200, 40], [40, 60, 230], [230, 210, 30], [220, 40, 210], [20, 20, 20]], float)


def toy_scene(
    seed: int = 0,
    side: int = 4,
    targets: int = 3,
    image_size: int = 48,
    tilts: tuple[float, ...] = (-30.0, 0.0, 30.0),
    actions: tuple[Action, ...] = EIGHT_ACTIONS,
    headings: tuple[float, ...] = (0, 90, 180, 270),
) -> Scene:
    """A room of side x side places with `targets` balls along its walls; the same seed gives the same scene."""
    rng = np.random.default_rng(seed)
    extent = (side + 1) * STEP
    grid = (np.arange(side) + 1) * STEP
    positions = np.stack(np.meshgrid(grid, grid, indexing="ij"), -1).reshape(-1, 2)
    poses = lattice_poses(positions, headings, tilts)
    balls = _balls(rng, targets, extent)
    phase = rng.uniform(0, 6, (6, 3))
    drawn = [_draw(pose, balls, extent, phase, image_size) for pose in poses]
    return Scene(
        name=f"toy_{seed}",
        actions=actions,
        views=tuple(encode_image(image, "png") for image, _ in drawn),
        poses=poses,
        transitions=lattice_transitions(poses, actions, STEP),
        boxes=np.stack([boxes for _, boxes in drawn]),
        targets=tuple(Target(f"ball{k}", _pictures(k, image_size), "ball", held_out=2) for k in range(targets)),
        image_size=image_size,
        fov=75.0,
        source="tests",
        floor_plan=FloorPlan(np.array([[0, 0], [extent, 0], [extent, extent], [0, extent]])),
    )


def _balls(rng: np.random.Generator, count: int, extent: float) -> NDArray[np.float64]:
    """(T, 4): centre x, z, height, radius, spread along the walls."""
    angle = (np.arange(count) + rng.uniform(0.2, 0.8, count)) / count * 2 * np.pi
    centre = extent / 2 + (extent / 2 - 0.12) * np.stack([np.sin(angle), np.cos(angle)], 1)
    return np.column_stack([centre, rng.uniform(0.9, 1.5, count), rng.uniform(0.08, 0.14, count)])


def _pictures(index: int, size: int) -> tuple[bytes, ...]:
    grid = (np.arange(size) + 0.5) / size - 0.5
    across, down = np.meshgrid(grid, grid)
    pictures = []
    for number in range(4):
        ball = (across - 0.03 * number) ** 2 + down**2 < (0.28 + 0.03 * number) ** 2
        shade = (1.0 - 0.5 * (across + down))[..., None]
        image = np.where(ball[..., None], COLOURS[index] * shade, 215.0)
        pictures.append(encode_image(np.clip(image, 0, 255).astype(np.uint8), "png"))
    return tuple(pictures)


def _draw(pose, balls, extent, phase, size) -> tuple[NDArray[np.uint8], NDArray[np.float32]]:
    heading, tilt = np.radians(pose[2:])
    origin = np.array([pose[0], pose[1], CAMERA_HEIGHT])
    ahead = np.array([np.sin(heading) * np.cos(tilt), np.cos(heading) * np.cos(tilt), np.sin(tilt)])
    right = np.array([np.cos(heading), -np.sin(heading), 0.0])
    up = np.cross(right, ahead)
    reach = np.tan(np.radians(75.0) / 2)
    grid = ((np.arange(size) + 0.5) / size * 2 - 1) * reach
    rays = ahead + grid[None, :, None] * right - grid[:, None, None] * up
    limits = np.stack([np.zeros(3), np.array([extent, extent, CEILING])])
    with np.errstate(divide="ignore"):
        distance = (np.where(rays > 0, limits[1], limits[0]) - origin) / rays
    face = distance.argmin(-1)
    hit = origin + rays * distance.min(-1, keepdims=True)
    wall = face * 2 + (np.take_along_axis(rays, face[..., None], -1)[..., 0] > 0)
    image = 128 + 60 * np.sin(hit * [2.0, 2.6, 1.8] + phase[wall]) + 20 * np.sin(hit.sum(-1, keepdims=True) * 9)
    boxes = np.full((len(balls), 4), np.nan, np.float32)
    toward = balls[:, :3] - origin
    for index in np.argsort(-np.linalg.norm(toward, axis=1)):  # far ones first
        depth = toward[index] @ ahead
        if depth < 0.1:
            continue
        centre = np.array([toward[index] @ right, -(toward[index] @ up)]) / depth / reach
        radius = balls[index, 3] / depth / reach
        ball = (grid[None] / reach - centre[0]) ** 2 + (grid[:, None] / reach - centre[1]) ** 2 < radius**2
        if not ball.any():
            continue
        image[ball] = COLOURS[index]
        rows, columns = np.flatnonzero(ball.any(1)), np.flatnonzero(ball.any(0))
        low, high = np.array([columns[0], rows[0]]) / size, np.array([columns[-1] + 1, rows[-1] + 1]) / size
        boxes[index] = [*(low + high) / 2, *(high - low)]
    return np.clip(image, 0, 255).astype(np.uint8), boxes
