"""How far it is between the states of a room: computed when first asked, and remembered."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from active_perceiver.scenes.lattice import steps_from, steps_to_goal

# At most so many distances are remembered of a kind; beyond, all are forgotten: 64 MB, every pair of 4000 states.
MOST_REMEMBERED = 2**24


class ShortestPaths:
    """Where a room's actions lead, and the fewest actions from a state to another one.

    Many searches go round the same room, and each asks for the same ways at every action: what was computed is kept,
    up to a limit.

    Args:
        transitions: (S, A) the next state; the state's own index where the move is blocked. Not to be changed.

    Attributes:
        transitions: the same.
    """

    def __init__(self, transitions: NDArray[np.integer]) -> None:
        self.transitions = transitions
        self._to: dict[int, NDArray[np.int32]] = {}
        self._from: dict[int, NDArray[np.int32]] = {}

    def to(self, goal: int) -> NDArray[np.int32]:
        """Fewest actions from each state to one, (S,); `UNREACHABLE` where no way leads. Not to be changed."""
        if goal not in self._to:
            self._make_room(self._to)
            goals = np.arange(len(self.transitions)) == goal
            self._to[goal] = steps_to_goal(self.transitions, goals).astype(np.int32)
        return self._to[goal]

    def away(self, start: int) -> NDArray[np.int32]:
        """Fewest actions from one state to each, (S,); `UNREACHABLE` where no way leads. Not to be changed."""
        if start not in self._from:
            self._make_room(self._from)
            self._from[start] = steps_from(self.transitions, start).astype(np.int32)
        return self._from[start]

    def without(self, state: int, action: int) -> ShortestPaths:
        """The ways that are left if an action is blocked in a state."""
        if self.transitions[state, action] == state:
            return self
        transitions = self.transitions.copy()
        transitions[state, action] = state
        return ShortestPaths(transitions)

    def _make_room(self, remembered: dict[int, NDArray[np.int32]]) -> None:
        if (len(remembered) + 1) * len(self.transitions) > MOST_REMEMBERED:
            remembered.clear()
