"""Scene dumps of Zhu et al., "Target-driven Visual Navigation in Indoor Scenes", ICRA 2017: one `<scene>.h5`.

As written down in the README of the authors' code and read by its `scene_loader.py`
(https://github.com/jkulhanek/icra2017-visual-navigation, a copy): `observation` (N, 300, 400, 3) uint8,
`resnet_feature` (N, K, 2048), `location` (N, 2) x, z, `rotation` (N,) degrees, `graph` (N, 4) the next state by
action, -1 for a collision, `shortest_path_distance` (N, N), -1 where no way leads. A target there is a state, so that
the scene has no objects, only views to search for.
"""

from __future__ import annotations

from pathlib import Path

import h5py
import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csgraph

from active_perceiver.datasets.io import (
    Imported,
    against_poses,
    check_image_size,
    check_pixels,
    dataset,
    encoded_view,
    finite,
)
from active_perceiver.scenes.hdf5 import open_hdf5
from active_perceiver.scenes.hdf5_values import read_whole
from active_perceiver.scenes.lattice import UNREACHABLE, Action, transition_graph
from active_perceiver.scenes.scene import Scene, SceneError
from active_perceiver.utils.progress import ProgressCallback, quiet

ZHU_ACTIONS = (Action.MOVE_AHEAD, Action.ROTATE_RIGHT, Action.ROTATE_LEFT, Action.MOVE_BACK)
"""The columns of `graph`: MoveForward, RotateRight, RotateLeft, MoveBackward."""
COLLISION = -1

PUBLISHED_TARGETS = {
    "bathroom_02": (26, 37, 43, 53, 69),
    "bedroom_04": (134, 264, 320, 384, 387),
    "kitchen_02": (90, 136, 157, 207, 329),
    "living_room_08": (92, 135, 193, 228, 254),
}
"""The states that the authors' code searches for in the four scenes that were published (its `constants.py`)."""

# Bytes of observations in memory at a time, and rows of the distances that are computed anew.
_CHUNK_BYTES, _CHECKED_ROWS = 32_000_000, 64


def import_zhu(
    path: Path,
    *,
    name: str | None = None,
    image_size: int = 300,
    fov: float = 75.0,
    progress: ProgressCallback = quiet,
) -> Imported:
    """Make a scene of a dump, whose views are read a few at a time.

    Args:
        path: the `.h5` file.
        name: of the scene; the file's stem if not given.
        image_size: side of the views in pixels; the pictures, wider than high, are padded to squares.
        fov: the camera's field of view across the width, in degrees; the file does not say it.
        progress: called with the number of views done and of all.

    Raises:
        SceneError: if the file is missing, damaged, or not of this format; the message names the dataset.
    """
    check_image_size(image_size)
    with open_hdf5(path) as file:
        poses, transitions, notes = _moves(file, path)
        published = PUBLISHED_TARGETS.get(path.stem, ())
        if published and max(published) < len(poses):
            wanted = " ".join(str(state) for state in published)
            notes.append(f"the states that the authors search for: train --task view --targets {wanted}")
        notes += _about_features(file, path, len(poses)) + _about_distances(file, path, transitions)
        views = _views(file, path, image_size, len(poses), progress)
    scene = Scene(
        name=name or path.stem,
        actions=ZHU_ACTIONS,
        views=views,
        poses=poses,
        transitions=transitions,
        boxes=np.zeros((len(poses), 0, 4), np.float32),
        targets=(),
        image_size=image_size,
        fov=fov,
        source="a scene dump of Zhu et al., ICRA 2017",
    )
    return Imported(scene, tuple(notes))


def _moves(file: h5py.File, path: Path) -> tuple[NDArray[np.float32], NDArray[np.int32], list[str]]:
    """Poses, transitions and notes on how they agree."""
    location = finite(dataset(file, "location", (None, 2), "iuf", path), path)
    states = len(location)
    if states == 0:
        raise SceneError(f"{path}: 'location' is empty; there are no states")
    rotation = finite(dataset(file, "rotation", (states,), "iuf", path), path)
    graph = dataset(file, "graph", (states, len(ZHU_ACTIONS)), "iu", path)
    graph = read_whole(graph, f"{path}: ").astype(np.int64)
    outside = np.argwhere((graph < COLLISION) | (graph >= states))
    if len(outside):
        row, column = outside[0].tolist()
        raise SceneError(
            f"{path}: 'graph' leads to state {graph[row, column]} from state {row}, but there are states 0 to "
            f"{states - 1} and {COLLISION} for a collision"
        )
    here = np.arange(states)[:, None]
    transitions = np.where(graph == COLLISION, here, graph).astype(np.int32)
    poses, notes = _fitting_poses(location, rotation, transitions)
    wrong = against_poses(poses, transitions, ZHU_ACTIONS)
    if wrong.any():
        row, column = np.argwhere(wrong)[0].tolist()
        notes.append(
            f"{int(wrong.sum())} of {int((transitions != here).sum())} moves in 'graph' do not lead where 'location' "
            f"and 'rotation' say, the first from state {row} by {ZHU_ACTIONS[column].value}; the graph is taken"
        )
    return poses, transitions, notes


def _fitting_poses(
    location: NDArray[np.float64], rotation: NDArray[np.float64], transitions: NDArray[np.int32]
) -> tuple[NDArray[np.float32], list[str]]:
    """Poses in this software's frame: that of the format, unless the moves fit another one better."""
    best, least, chosen = None, np.inf, (1, 0)
    for mirrored in (1, -1):
        for offset in (0, 90, 180, 270):
            heading = (rotation + offset) % 360
            poses = np.column_stack([mirrored * location[:, 0], location[:, 1], heading, np.zeros(len(location))])
            wrong = int(against_poses(poses, transitions, ZHU_ACTIONS).sum())
            if wrong < least:
                best, least, chosen = poses.astype(np.float32), wrong, (mirrored, offset)
    assert best is not None
    if chosen == (1, 0):
        return best, []
    mirror = "with x the other way round" if chosen[0] < 0 else "as they are"
    return best, [
        f"the moves in 'graph' fit 'location' {mirror} and 'rotation' plus {chosen[1]} degrees; poses were made so"
    ]


def _about_features(file: h5py.File, path: Path, states: int) -> list[str]:
    """What is said of the features, which are not taken: this software computes its own."""
    if "resnet_feature" not in file:
        return []
    axes = getattr(file["resnet_feature"], "ndim", 0)
    dataset(file, "resnet_feature", (states, None, None) if axes == 3 else (states, None), "iuf", path)
    return []


def _about_distances(file: h5py.File, path: Path, transitions: NDArray[np.int32]) -> list[str]:
    """Compare some rows of the distances in the file with those that follow from the graph."""
    states = len(transitions)
    if "shortest_path_distance" not in file:
        return ["there is no 'shortest_path_distance'; distances follow from 'graph'"]
    given = dataset(file, "shortest_path_distance", (states, states), "iuf", path)
    rows = np.unique(np.linspace(0, states - 1, min(states, _CHECKED_ROWS)).astype(np.int64))
    steps = csgraph.dijkstra(transition_graph(transitions), indices=rows, unweighted=True)
    steps = np.where(np.isinf(steps), UNREACHABLE, steps)
    different = sum(int((given[row] != expected).sum()) for row, expected in zip(rows, steps, strict=True))
    if not different:
        return []
    return [
        f"{different} of {steps.size} distances that were checked in 'shortest_path_distance' are not those that "
        "follow from 'graph'; the graph is taken"
    ]


def _views(file: h5py.File, path: Path, size: int, states: int, progress: ProgressCallback) -> tuple[bytes, ...]:
    observation = dataset(file, "observation", (states, None, None, 3), "u", path)
    check_pixels(observation.shape[1:], f"{path}: a row of 'observation'")
    if observation.dtype != np.uint8:
        raise SceneError(f"{path}: 'observation' is of type {observation.dtype}, expected uint8")
    rows = max(1, _CHUNK_BYTES // int(np.prod(observation.shape[1:])))
    views: list[bytes] = []
    for start in range(0, states, rows):
        for image in observation[start : start + rows]:
            views.append(encoded_view(image, size))
            progress(len(views), states)
    return tuple(views)
