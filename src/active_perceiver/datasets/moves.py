"""Moves between photographs: those of a lattice of poses, and those that have no way back."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from active_perceiver.scenes.lattice import LOOK, MOVE_DIRECTION, TURN, Action, lattice_transitions

COUNTERPARTS = {
    Action.MOVE_AHEAD: Action.MOVE_BACK,
    Action.MOVE_LEFT: Action.MOVE_RIGHT,
    Action.ROTATE_LEFT: Action.ROTATE_RIGHT,
    Action.LOOK_UP: Action.LOOK_DOWN,
}
_SIDEWAYS = (Action.MOVE_LEFT, Action.MOVE_RIGHT)


def lattice_actions(poses: NDArray[np.floating], sideways: bool) -> tuple[Action, ...]:
    """The actions that a lattice has: no moves with one place, no rotations with one heading, no looks with one tilt.

    Args:
        poses: (S, 4), snapped.
        sideways: whether the robot can move to its sides.
    """
    places, headings, tilts = (len(np.unique(part, axis=0)) for part in (poses[:, :2], poses[:, 2], poses[:, 3]))
    several = {**dict.fromkeys(MOVE_DIRECTION, places > 1), **dict.fromkeys(TURN, headings > 1)}
    several |= dict.fromkeys(LOOK, tilts > 1)
    return tuple(action for action in Action if several[action] and (sideways or action not in _SIDEWAYS))


def snapped_transitions(
    poses: NDArray[np.floating], actions: Sequence[Action], spacing: float, heading_step: float
) -> NDArray[np.int32]:
    """`lattice_transitions`, without rotations over headings in which there is no photograph at all.

    Args:
        poses: (S, 4), snapped.
        actions: the columns of the result.
        spacing: metres.
        heading_step: degrees.
    """
    transitions = lattice_transitions(poses, actions, spacing)
    own = np.arange(len(poses))
    for column, action in enumerate(actions):
        if action in TURN:
            turned = (poses[transitions[:, column], 2] - poses[:, 2]) * TURN[action] % 360
            transitions[:, column] = np.where(np.abs(turned - heading_step) < 0.5, transitions[:, column], own)
    return transitions


def one_way_moves(actions: Sequence[Action], transitions: NDArray[np.integer]) -> list[tuple[int, Action, int]]:
    """Moves whose counterpart does not lead back: (from, action, to).

    Actions whose counterpart the robot does not have are left out.

    Args:
        actions: the columns of `transitions`.
        transitions: (S, A).
    """
    own = np.arange(len(transitions))
    found = []
    for there, back in [*COUNTERPARTS.items(), *((back, there) for there, back in COUNTERPARTS.items())]:
        if there in actions and back in actions:
            to = transitions[:, actions.index(there)]
            lost = (to != own) & (transitions[to, actions.index(back)] != own)
            found += [(int(state), there, int(to[state])) for state in np.flatnonzero(lost)]
    return found
