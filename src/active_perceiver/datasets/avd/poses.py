"""Where the photographs of an Active Vision Dataset scene were taken: measured, or derived from the moves.

`image_structs.mat` (MATLAB, not version 7.3) has `image_structs`, a record for each photograph with `image_name`,
`world_pos` (3,), `direction` (3,) of the view and `R` (3, 3) from the world to the camera, and `scale`: world_pos *
scale is in millimetres. The axes are x to the right, y down, z ahead, so that x and z are this software's. Some
records lack R, some all of it.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy import sparse
from scipy.sparse import csgraph

from active_perceiver.datasets.avd.matlab_records import read_records
from active_perceiver.scenes.lattice import MOVE_DIRECTION, TURN, Action

MOVES = {
    "forward": Action.MOVE_AHEAD,
    "backward": Action.MOVE_BACK,
    "left": Action.MOVE_LEFT,
    "right": Action.MOVE_RIGHT,
    "rotate_ccw": Action.ROTATE_LEFT,
    "rotate_cw": Action.ROTATE_RIGHT,
}
STEP, TURN_STEP = 0.3, 30.0
"""Metres of a move and degrees of a turn."""


def read_poses(
    path: Path, names: Sequence[str], transitions: NDArray[np.int32], actions: Sequence[Action], notes: list[str]
) -> NDArray[np.float64]:
    """The measured poses.

    Args:
        path: of `image_structs.mat`.
        names: (S,) of the photographs.
        transitions: (S, A), from which the scale follows if the file does not have it.
        actions: the columns of `transitions`.
        notes: sentences on what was guessed are added to these.

    Returns:
        (S, 4) x, z in metres, heading in degrees, tilt 0; NaN where not measured.

    Raises:
        SceneError: if the file is missing, cannot be read, or a record is malformed.
    """
    records = read_records(path)
    row_of = {name: row for row, name in enumerate(names)}
    poses = np.full((len(names), 4), np.nan)
    for name, place, direction in zip(records.names, records.places, records.directions, strict=True):
        if name in row_of:
            ahead = direction[[0, 2]]
            looks = ahead @ ahead > 0  # not if it is NaN
            poses[row_of[name], :2] = place[[0, 2]]
            poses[row_of[name], 2] = np.degrees(np.arctan2(*ahead)) % 360 if looks else np.nan
    poses[:, 3] = 0.0
    poses[:, :2] *= _scale(records.scale, poses, transitions, actions, notes)
    return poses


def _scale(
    value: float,
    poses: NDArray[np.float64],
    transitions: NDArray[np.int32],
    actions: Sequence[Action],
    notes: list[str],
) -> float:
    """Metres per unit of `world_pos`; scenes that were never measured have the scale 0."""
    if value > 0:
        return value / 1000.0
    lengths = np.concatenate(
        [
            np.linalg.norm(poses[transitions[:, column], :2] - poses[:, :2], axis=1)
            for column, action in enumerate(actions)
            if action in MOVE_DIRECTION
        ]
        or [np.zeros(0)]
    )
    lengths = lengths[np.isfinite(lengths) & (lengths > 0)]
    if not len(lengths):
        notes.append("neither 'scale' nor a move says how long a unit of 'world_pos' is; it is taken as a metre")
        return 1.0
    notes.append(f"'scale' is {value:g}; moves were taken to be {STEP:g} m long")
    return STEP / float(np.median(lengths))


def place_views(
    poses: NDArray[np.float64], transitions: NDArray[np.int32], actions: Sequence[Action], notes: list[str]
) -> NDArray[np.float64]:
    """Complete poses: views that turns link share a place, and what was not measured follows from the moves.

    Args:
        poses: (S, 4), NaN where not measured.
        transitions: (S, A).
        actions: the columns of `transitions`.
        notes: sentences on what was derived or left out are added to these.

    Returns:
        (S, 4); NaN where nothing leads to a measured pose.
    """
    poses = poses.copy()
    unmeasured = ~np.isfinite(poses).all(1)
    place = _places(transitions, actions)
    count = int(place.max()) + 1
    measured = np.isfinite(poses[:, :2]).all(1)
    share = np.bincount(place[measured], minlength=count).astype(float)
    where = np.stack([np.bincount(place[measured], poses[measured, axis], count) for axis in range(2)], axis=1)
    where = np.divide(where, share[:, None], out=np.full(where.shape, np.nan), where=share[:, None] > 0)
    edges = _edges(transitions, actions)
    _fill(poses[:, 2], [(start, end, turn * TURN_STEP) for start, end, _, turn in edges], wrap=360.0)
    steps = []
    for start, end, direction, _ in edges:
        if direction is not None:
            angle = np.radians(poses[start, 2] + direction)
            steps.append((place[start], place[end], STEP * np.stack([np.sin(angle), np.cos(angle)], axis=1)))
    _fill(where, steps)
    poses[:, :2] = where[place]
    lost = ~np.isfinite(poses).all(1)
    if derived := int((unmeasured & ~lost).sum()):
        notes.append(f"{derived} views have no measured pose; theirs follows from the moves to their neighbours")
    if lost.any():
        notes.append(f"{int(lost.sum())} views have no pose, and no move leads to one that has; they are left out")
    return poses


class _Edges(NamedTuple):
    """Where one action leads from and to, (E,), in which direction it goes (None if it stays), and how it turns."""

    start: NDArray[np.int64]
    end: NDArray[np.int64]
    direction: float | None
    turn: int


def _edges(transitions: NDArray[np.int32], actions: Sequence[Action]) -> list[_Edges]:
    here = np.arange(len(transitions))
    edges = []
    for column, action in enumerate(actions):
        start = np.flatnonzero(transitions[:, column] != here)
        end = transitions[start, column].astype(np.int64)
        edges.append(_Edges(start, end, MOVE_DIRECTION.get(action), TURN.get(action, 0)))
    return edges


def _places(transitions: NDArray[np.int32], actions: Sequence[Action]) -> NDArray[np.int64]:
    """(S,) the number of each view's place: views that turns link are at the same one."""
    states = len(transitions)
    turns = [column for column, action in enumerate(actions) if action in TURN]
    start = np.repeat(np.arange(states), len(turns))
    end = transitions[:, turns].ravel()
    graph = sparse.csr_array((np.ones(len(start)), (start, end)), shape=(states, states))
    labels: NDArray[np.int64] = csgraph.connected_components(graph, directed=False)[1].astype(np.int64)
    return labels


def _fill(
    values: NDArray[np.float64], edges: Sequence[tuple[NDArray[np.int64], NDArray[np.int64], Any]], wrap: float = 0.0
) -> None:
    """Give a value to what has none and is linked, forwards or backwards, to what has one, until nothing is left.

    Args:
        values: (N,) or (N, D), NaN where unknown; changed in place.
        edges: start and end (E,) of edges, and what is added along each: a number or (E, D).
        wrap: if not 0, values are kept in 0..wrap.
    """
    known: NDArray[np.bool_] = np.asarray(np.isfinite(values.reshape(len(values), -1)).all(1))
    growing = True
    while growing:
        growing = False
        for start, end, added in edges:
            change = np.broadcast_to(np.asarray(added, float), (len(start), *values.shape[1:]))
            usable = np.isfinite(change).reshape(len(start), int(np.prod(values.shape[1:]))).all(1)
            for origin, goal, sign in ((start, end, 1.0), (end, start, -1.0)):
                new = known[origin] & ~known[goal] & usable
                if new.any():
                    found = values[origin[new]] + sign * change[new]
                    values[goal[new]] = found % wrap if wrap else found
                    known[goal[new]] = True
                    growing = True
