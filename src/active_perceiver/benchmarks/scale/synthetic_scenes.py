"""Scenes made of random numbers, of any size: searches as in a rendered room, in a second and without a picture.

A scene is a hall of square cells, some of them obstacles. Every free cell is a place of the robot, with four headings
and three tilts, and the eight actions. Targets are balls in cells that are not free, seen from in front of them, with
boxes that grow as one comes nearer. Features are smooth random functions of the pose, different ones in every scene,
with noise of their own: as little of the way can be read from them without learning as from a backbone's.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from active_perceiver.envs import Observations, SearchTask
from active_perceiver.errors import UserError
from active_perceiver.policies.training_task import TrainingTask
from active_perceiver.scenes import EIGHT_ACTIONS
from active_perceiver.scenes.lattice import goal_states, lattice_poses, lattice_transitions, steps_to_goal

HEADINGS = (0.0, 90.0, 180.0, 270.0)
TILTS = (-30.0, 0.0, 30.0)
VIEWS_PER_PLACE = len(HEADINGS) * len(TILTS)
STEP = 0.5
"""Metres between two places."""
FEATURES = 672
"""As many as EfficientNet-Lite0's."""
PICTURES = 2
"""Of each target."""

_OBSTACLES = 0.2  # share of the hall that obstacles take
_CAMERA_HEIGHT = 1.2
_REACH = np.tan(np.radians(75.0) / 2)  # half the image's width at a distance of 1
_SMALLEST = 4e-4  # boxes that take less of the image are not seen
_NOISE = 0.2
_AHEAD = np.array([[0, 1], [1, 0], [0, -1], [-1, 0]])  # cells in x and z per heading


def synthetic_tasks(scenes: int, states: int, targets: int, seed: int = 0) -> list[TrainingTask]:
    """Searches in some scenes, named "synthetic_0" and so on; the same seed gives the same, however many they are.

    Args:
        scenes: how many.
        states: in each; a place has 12, so it is the nearest multiple of that.
        targets: in each.
        seed: of everything random.

    Returns:
        A problem for each; from every state that is no goal a way leads to a goal.

    Raises:
        UserError: if there are fewer than one scene or target, or too few states for the targets.
    """
    if scenes < 1 or targets < 1:
        raise UserError(f"there must be at least one scene and one target, got {scenes} and {targets}")
    return [_problem(f"synthetic_{number}", states, targets, seed, number) for number in range(scenes)]


def _problem(name: str, states: int, targets: int, seed: int, number: int) -> TrainingTask:
    rng = np.random.default_rng([seed, number, states, targets])
    places = round(states / VIEWS_PER_PLACE)
    free = free_cells(places, rng)
    sites = _sites(free)
    if places < 2 or len(sites) < targets:
        raise UserError(
            f"{targets} targets do not fit into a scene of {states} states; give fewer targets or more states "
            f"({VIEWS_PER_PLACE * max(4, targets)} are enough)"
        )
    chosen = sites[rng.choice(len(sites), targets, replace=False)]
    cells = np.argwhere(free)
    poses = lattice_poses(cells * STEP, HEADINGS, TILTS)
    boxes = _boxes(poses, free, cells, chosen, rng)
    areas = np.nan_to_num(boxes[..., 2] * boxes[..., 3])
    transitions = lattice_transitions(poses, EIGHT_ACTIONS, STEP)
    goals = goal_states(areas)
    task = SearchTask(
        scene=name,
        actions=tuple(action.value for action in EIGHT_ACTIONS),
        targets=tuple(f"target_{index}" for index in range(targets)),
        transitions=transitions,
        areas=areas,
        goals=goals,
        steps=np.stack([steps_to_goal(transitions, goals[:, index]) for index in range(targets)], axis=1),
    )
    code = np.abs(rng.normal(size=(targets, 1, FEATURES)))
    shown = code + _NOISE * rng.normal(size=(targets, PICTURES, FEATURES))
    return TrainingTask(task, Observations.from_boxes(_pose_features(poses, rng), shown.astype(np.float32), boxes))


def free_cells(places: int, rng: np.random.Generator) -> NDArray[np.bool_]:
    """A hall with walls and other obstacles in it, of which so many cells are free and connected.

    Returns:
        (side + 2, side + 2) bool over x and z; the outermost cells are never free.
    """
    side = int(np.ceil(np.sqrt(places / (1 - _OBSTACLES))))
    free = np.zeros((side + 2, side + 2), bool)
    free[1:-1, 1:-1] = True
    for _ in range(places):
        obstacle = free.copy()
        # Up to three cells thick in one direction, longer in the other: tables and walls.
        size = rng.permutation([rng.integers(1, 3), rng.integers(1, max(3, side // 3))])
        corner = rng.integers(1, side + 1, size=2)
        obstacle[corner[0] : corner[0] + size[0], corner[1] : corner[1] + size[1]] = False
        _, count = ndimage.label(obstacle)
        if count == 1 and obstacle.sum() >= places:
            free = obstacle
    # A few cells are left over: those farthest from a random one go, which leaves the others connected.
    start = np.argwhere(free)[rng.integers(int(free.sum()))]
    order = _flood_order(free, start)
    kept = np.zeros_like(free)
    kept[tuple(order[:places].T)] = True
    return kept


def _flood_order(free: NDArray[np.bool_], start: NDArray[np.int64]) -> NDArray[np.int64]:
    """The cells that can be reached from one, (n, 2), nearest by steps first."""
    distance = np.full(free.shape, -1)
    reached = np.zeros_like(free)
    reached[tuple(start)] = True
    steps = 0
    while (new := reached & (distance < 0)).any():
        distance[new] = steps
        steps += 1
        reached = ndimage.binary_dilation(reached) & free
    cells = np.argwhere(distance >= 0)
    return cells[np.argsort(distance[tuple(cells.T)], kind="stable")]


def _sites(free: NDArray[np.bool_]) -> NDArray[np.int64]:
    """(n, 3) where a target can be: x and z of a cell that is not free, and the heading to it from a free one."""
    found = []
    for heading, ahead in enumerate(_AHEAD):
        cells = np.argwhere(free) + ahead
        cells = cells[~free[tuple(cells.T)]]
        found.append(np.column_stack([cells, np.full(len(cells), heading)]))
    every = np.concatenate(found)
    # One target per cell.
    return every[np.unique(every[:, :2], axis=0, return_index=True)[1]]


def _boxes(
    poses: NDArray[np.float32],
    free: NDArray[np.bool_],
    cells: NDArray[np.int64],
    sites: NDArray[np.int64],
    rng: np.random.Generator,
) -> NDArray[np.float32]:
    """(S, T, 4) as in `Scene.boxes`: where a pinhole camera sees the middle of a ball, nothing being in between."""
    heading, tilt = np.radians(poses[:, 2].astype(float)), np.radians(poses[:, 3].astype(float))
    ahead = np.column_stack([np.sin(heading) * np.cos(tilt), np.cos(heading) * np.cos(tilt), np.sin(tilt)])
    right = np.column_stack([np.cos(heading), -np.sin(heading), np.zeros(len(poses))])
    up = np.cross(right, ahead)
    origin = np.column_stack([poses[:, :2], np.full(len(poses), _CAMERA_HEIGHT)])
    boxes = np.full((len(poses), len(sites), 4), np.nan, np.float32)
    for index, site in enumerate(sites):
        ball = np.array([*site[:2] * STEP, rng.uniform(0.9, 1.4)])
        radius = rng.uniform(0.08, 0.16)
        toward = ball - origin
        depth = np.maximum((toward * ahead).sum(axis=1), 1e-6)
        across = (toward * right).sum(axis=1) / depth / _REACH
        down = -(toward * up).sum(axis=1) / depth / _REACH
        size = np.minimum(radius / depth / _REACH, 1.0)
        seen = np.repeat(_in_front(free, cells, site), VIEWS_PER_PLACE)
        seen &= (np.abs(across) < 1) & (np.abs(down) < 1) & (size**2 >= _SMALLEST)
        box = np.column_stack([(1 + across) / 2, (1 + down) / 2, size, size])
        boxes[seen, index] = box[seen]
    return boxes


def _in_front(free: NDArray[np.bool_], cells: NDArray[np.int64], site: NDArray[np.int64]) -> NDArray[np.bool_]:
    """(P,) from which cells the front of a site can be seen: nothing that is not free is on the line to it."""
    line = site[:2] - cells
    in_front = line @ _AHEAD[site[2]] > 0
    # Two samples per cell; the last ones are in the site's own cell.
    count = 2 * int(np.abs(line).max())
    along = np.arange(count) / count
    passed = np.rint(cells[:, None] + along[:, None] * line[:, None]).astype(int)
    open_there = free[passed[..., 0], passed[..., 1]] | (passed == site[:2]).all(axis=-1)
    return in_front & open_there.all(axis=1)


def _pose_features(poses: NDArray[np.float32], rng: np.random.Generator) -> NDArray[np.float32]:
    """(S, FEATURES), not negative like pooled backbone features: smooth over metres, other in every direction."""
    heading = np.radians(poses[:, 2])
    basis = [poses[:, 0], poses[:, 1], np.cos(heading), np.sin(heading), poses[:, 3] / 30, np.ones(len(poses))]
    weights = rng.normal(size=(len(basis), FEATURES)).astype(np.float32)
    weights[-1] += rng.uniform(0, 2 * np.pi, FEATURES)
    waves = np.cos(np.column_stack(basis).astype(np.float32) @ weights)
    noise = _NOISE * np.abs(rng.standard_normal(waves.shape, np.float32))
    return np.maximum(waves, 0) + noise
