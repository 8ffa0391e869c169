"""A scene as a dump for agents written for those of Zhu et al., ICRA 2017; the format is in `zhu/reader.py`.

Features need a backbone, which scenes know nothing of: `datasets/zhu/features.py` fills in `resnet_feature`.
"""

from __future__ import annotations

from dataclasses import dataclass

import h5py
import numpy as np
from numpy.typing import NDArray
from PIL import Image
from scipy.sparse import csgraph

from active_perceiver.datasets.zhu.reader import COLLISION, ZHU_ACTIONS
from active_perceiver.scenes.lattice import UNREACHABLE, transition_graph
from active_perceiver.scenes.scene import Scene, SceneError
from active_perceiver.utils.progress import ProgressCallback, quiet

HEIGHT, WIDTH = 300, 400
FEATURES = 2048
"""Pixels of an observation, and numbers of a feature, that the agents' networks are built for."""
CARDINAL = (0, 90, 180, 270)

# Rows of distances that are computed at a time: enough to be quick, few enough to be small.
_ROWS = 256


@dataclass(frozen=True, eq=False)
class ZhuDump:
    """The states of a scene that a dump can hold, and the moves between them.

    Attributes:
        scene: where they are from.
        states: (N,) their numbers in the scene: those that look straight ahead, as the format has no tilts.
        graph: (N, 4) the number in the dump of the next state, -1 for a collision.
        notes: sentences on what the format cannot say.
    """

    scene: Scene
    states: NDArray[np.int64]
    graph: NDArray[np.int64]
    notes: tuple[str, ...]

    @property
    def transitions(self) -> NDArray[np.int64]:
        """(N, 4) the next state, the state's own number for a collision."""
        return np.where(self.graph == COLLISION, np.arange(len(self.states))[:, None], self.graph)

    def observation(self, row: int) -> NDArray[np.uint8]:
        """(300, 400, 3) uint8, a view between two bars of the median colour of its edges."""
        view = Image.fromarray(self.scene.view(int(self.states[row])))
        image = np.asarray(view.resize((HEIGHT, HEIGHT), Image.Resampling.LANCZOS))
        wide = np.empty((HEIGHT, WIDTH, 3), np.uint8)
        wide[:] = np.median(np.concatenate([image[:, 0], image[:, -1]]), axis=0).astype(np.uint8)
        left = (WIDTH - HEIGHT) // 2
        wide[:, left : left + HEIGHT] = image
        return wide


def zhu_dump(scene: Scene) -> ZhuDump:
    """What of a scene goes into a dump.

    Raises:
        SceneError: if no move of the format is possible in it.
    """
    tilts = scene.poses[:, 3]
    level = float(tilts[np.abs(tilts).argmin()])
    states = np.flatnonzero(tilts == level)
    number = np.full(len(scene), COLLISION)
    number[states] = np.arange(len(states))
    graph = np.full((len(states), len(ZHU_ACTIONS)), COLLISION)
    notes = []
    if len(states) < len(scene):
        notes.append(
            f"{len(scene) - len(states)} of {len(scene)} states are tilted otherwise than {level:g} degrees; the "
            "format has no tilts, they are left out"
        )
    for column, action in enumerate(ZHU_ACTIONS):
        if action in scene.actions:
            following = scene.transitions[states, scene.actions.index(action)]
            graph[:, column] = np.where(following == states, COLLISION, number[following])
        else:
            notes.append(f"the scene has no {action.value}; in the dump it collides everywhere")
    if unknown := [action.value for action in scene.actions if action not in ZHU_ACTIONS]:
        notes.append(f"the format has no {', '.join(unknown)}; these moves are left out")
    if not np.isin(scene.poses[states, 2] % 360, CARDINAL).all():
        notes.append(
            "some headings are none of 0, 90, 180 and 270 degrees, which is all that the format's agents know"
        )
    if (graph == COLLISION).all():
        raise SceneError(
            f"none of the format's moves ({', '.join(action.value for action in ZHU_ACTIONS)}) is possible in scene "
            f"'{scene.name}'; there is nothing to export"
        )
    return ZhuDump(scene, states, graph, tuple(notes))


def write_zhu(dump: ZhuDump, file: h5py.File, progress: ProgressCallback = quiet) -> None:
    """Write everything but the features.

    Args:
        dump: what is written.
        file: open for writing.
        progress: called with the number of states done and of all.

    Raises:
        ImageError: if a view cannot be decoded.
    """
    states = len(dump.states)
    poses = dump.scene.poses[dump.states]
    file["location"] = poses[:, :2].astype(np.float64)
    heading = poses[:, 2].astype(np.float64) % 360
    file["rotation"] = heading.astype(np.int64) if (heading % 1 == 0).all() else heading
    file["graph"] = dump.graph
    moves = transition_graph(dump.transitions)
    distances = file.create_dataset("shortest_path_distance", (states, states), np.int64, compression="gzip")
    for start in range(0, states, _ROWS):
        rows = np.arange(start, min(start + _ROWS, states))
        steps = csgraph.dijkstra(moves, indices=rows, unweighted=True)
        distances[rows] = np.where(np.isinf(steps), UNREACHABLE, steps)
    # One state a chunk: agents read single rows of it.
    observation = file.create_dataset(
        "observation", (states, HEIGHT, WIDTH, 3), np.uint8, chunks=(1, HEIGHT, WIDTH, 3), compression="gzip"
    )
    for row in range(states):
        observation[row] = dump.observation(row)
        progress(row + 1, states)
