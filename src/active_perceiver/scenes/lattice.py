"""The pose lattice a robot moves on: actions, transitions, islands, goal states, shortest paths.

A pose is (x, z, heading, tilt): metres, and degrees; heading clockwise seen from above with 0 along +z and 90
along +x; tilt positive upwards. Section III of the paper; sideways moves and look actions as in its simulation.
"""

from __future__ import annotations

from collections.abc import Sequence
from enum import Enum
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from scipy import sparse

UNREACHABLE = -1


class Action(str, Enum):
    """What a robot can do; the values are the names used in scene files."""

    MOVE_AHEAD = "MoveAhead"
    MOVE_BACK = "MoveBack"
    MOVE_LEFT = "MoveLeft"
    MOVE_RIGHT = "MoveRight"
    ROTATE_LEFT = "RotateLeft"
    ROTATE_RIGHT = "RotateRight"
    LOOK_UP = "LookUp"
    LOOK_DOWN = "LookDown"


EIGHT_ACTIONS: tuple[Action, ...] = tuple(Action)
TURTLEBOT_ACTIONS: tuple[Action, ...] = (
    Action.MOVE_AHEAD,
    Action.MOVE_BACK,
    Action.ROTATE_LEFT,
    Action.ROTATE_RIGHT,
    Action.LOOK_UP,
    Action.LOOK_DOWN,
)

MOVE_DIRECTION = {Action.MOVE_AHEAD: 0, Action.MOVE_RIGHT: 90, Action.MOVE_BACK: 180, Action.MOVE_LEFT: 270}
"""Direction of a move relative to the heading, in degrees clockwise."""
TURN = {Action.ROTATE_LEFT: -1, Action.ROTATE_RIGHT: 1}
"""Which way an action turns: 1 is clockwise seen from above."""
LOOK = {Action.LOOK_UP: 1, Action.LOOK_DOWN: -1}
"""Which way an action tilts: 1 is up."""


def lattice_poses(
    positions: NDArray[np.floating], headings: Sequence[float], tilts: Sequence[float]
) -> NDArray[np.float32]:
    """All poses over some positions: for each position each heading, for each heading each tilt.

    Args:
        positions: (P, 2) x, z in metres.
        headings: degrees.
        tilts: degrees.

    Returns:
        (P * len(headings) * len(tilts), 4) float32.
    """
    place = np.repeat(np.asarray(positions, np.float32), len(headings) * len(tilts), axis=0)
    view = np.stack(np.meshgrid(headings, tilts, indexing="ij"), axis=-1).reshape(-1, 2)
    return np.hstack([place, np.tile(view, (len(positions), 1))]).astype(np.float32)


def nearest_tilt(tilts: Sequence[float], tilt: float) -> int:
    """The number of the one of a lattice's tilts that is nearest to another, in degrees; of two such, the first."""
    return int(np.abs(np.asarray(tilts) - tilt).argmin())


def lattice_transitions(poses: NDArray[np.floating], actions: Sequence[Action], step: float) -> NDArray[np.int32]:
    """The next state for each state and action; a move to where there is no pose leaves the state as it is.

    Args:
        poses: (S, 4) on a regular lattice: positions `step` apart, headings and tilts evenly spaced.
        actions: the columns of the result.
        step: metres moved by one move.

    Returns:
        (S, A) int32.

    Raises:
        ValueError: if two states share a pose.
    """
    headings = np.unique(poses[:, 2] % 360)
    tilts = np.unique(poses[:, 3])
    # Counted from the lattice's own corner, so that rounding never falls between two numbers, and in sixteenths of a
    # step, so that two lattices shifted against each other stay apart.
    corner = poses[:, :2].min(axis=0)
    key = np.column_stack(
        [
            np.round((poses[:, :2] - corner) / step * 16),
            np.searchsorted(headings, poses[:, 2] % 360),
            np.searchsorted(tilts, poses[:, 3]),
        ]
    ).astype(np.int64)
    state_of = {tuple(row): state for state, row in enumerate(key.tolist())}
    if len(state_of) != len(poses):
        raise ValueError(f"{len(poses) - len(state_of)} poses occur twice; a scene needs one view per pose")
    transitions = np.tile(np.arange(len(poses), dtype=np.int32)[:, None], (1, len(actions)))
    for column, action in enumerate(actions):
        moved = key.copy()
        if action in MOVE_DIRECTION:
            angle = np.radians(poses[:, 2] + MOVE_DIRECTION[action])
            moved[:, 0] += np.round(16 * np.sin(angle)).astype(np.int64)
            moved[:, 1] += np.round(16 * np.cos(angle)).astype(np.int64)
        elif action in TURN:
            moved[:, 2] = (moved[:, 2] + TURN[action]) % len(headings)
        else:
            moved[:, 3] += LOOK[action]
        for state, row in enumerate(moved.tolist()):
            transitions[state, column] = state_of.get(tuple(row), state)
    return transitions


def transition_graph(transitions: NDArray[np.integer]) -> sparse.csr_array:
    """The scene as a directed graph: (S, S) with a 1 where one action leads, blocked moves left out."""
    from scipy import sparse  # a robot never needs it, and is not asked to have it

    states, actions = transitions.shape
    source = np.repeat(np.arange(states), actions)
    goes = transitions.ravel() != source
    graph = sparse.csr_array(
        (np.ones(int(goes.sum())), (source[goes], transitions.ravel()[goes])), shape=(states, states)
    )
    graph.data[:] = 1.0  # two actions may lead the same way
    return graph


def islands(transitions: NDArray[np.integer]) -> NDArray[np.int64]:
    """Number of the strongly connected part of each state, (S,); 0 is the largest."""
    from scipy.sparse import csgraph  # as above

    _, labels = csgraph.connected_components(transition_graph(transitions), connection="strong")
    order = np.argsort(-np.bincount(labels), kind="stable")
    return np.argsort(order)[labels]


def goal_states(areas: NDArray[np.floating], rank: int = 5) -> NDArray[np.bool_]:
    """The paper's goal states: those whose box is at least as large as the `rank`-th largest of the target.

    Args:
        areas: (S, T) box areas, 0 where the target is not visible.
        rank: 5 in the paper. Ties enlarge the set; a target visible in fewer states has them all as goals.

    Returns:
        (S, T) bool.

    Raises:
        ValueError: if the rank is less than 1.
    """
    if rank < 1:
        raise ValueError(f"the rank of goal states is at least 1, got {rank}")
    nth_largest = np.sort(areas, axis=0)[-min(rank, len(areas))]
    return (areas >= nth_largest) & (areas > 0)


def steps_to_goal(transitions: NDArray[np.integer], goals: NDArray[np.bool_]) -> NDArray[np.int64]:
    """Fewest actions from each state to the nearest goal state.

    Args:
        transitions: (S, A).
        goals: (S,) bool, the goal states of one target.

    Returns:
        (S,) int64, 0 at goals, `UNREACHABLE` (-1) where no way leads.
    """
    steps = np.where(goals, 0, UNREACHABLE).astype(np.int64)
    for distance in range(1, len(transitions)):
        left = np.flatnonzero(steps == UNREACHABLE)
        arrived = left[(steps[transitions[left]] != UNREACHABLE).any(axis=1)]
        if not len(arrived):
            break
        steps[arrived] = distance
    return steps


def steps_from(transitions: NDArray[np.integer], start: int) -> NDArray[np.int64]:
    """Fewest actions from `start` to each state, (S,) int64; `UNREACHABLE` (-1) where no way leads."""
    steps = np.full(len(transitions), UNREACHABLE, np.int64)
    arrived, distance = np.array([start]), 0
    while len(arrived):
        steps[arrived] = distance
        following = np.unique(transitions[arrived])
        arrived, distance = following[steps[following] == UNREACHABLE], distance + 1
    return steps


def shortest_path(transitions: NDArray[np.integer], goals: NDArray[np.bool_], start: int) -> list[int]:
    """States of one shortest path from `start` to a goal, both ends included; empty if there is no way."""
    steps = steps_to_goal(transitions, goals)
    if steps[start] == UNREACHABLE:
        return []
    path = [start]
    while steps[path[-1]] > 0:
        options = transitions[path[-1]]
        path.append(int(options[np.argmax(steps[options] == steps[path[-1]] - 1)]))
    return path
