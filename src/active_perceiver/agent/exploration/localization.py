"""Where in a known room a robot is: a belief over the room's states, from what it sees and what it does.

A view of a robot that is a little off the lattice, at another hour, is often a little more like some other state's
than like that of the nearest one. Which it can be follows from where the robot was and what it did since: the belief
is led along the room's transitions and weighed by how alike the view is (a Bayes filter: Thrun, Burgard and Fox,
Probabilistic Robotics, MIT Press 2005, section 2.4).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

ALIKENESS = 0.008
"""A state whose view is less alike by this much (cosine similarity) is e times less likely. Off the lattice, at dusk,
the nearest state of the bundled kitchen is less alike than the most similar one by 0.0014 in one of two views and by
0.008 in one of twenty."""
BLOCKED = 0.1
"""How likely an action is to lead nowhere if the robot does not say whether it moved."""
ASTRAY = 0.02
"""How likely the robot is to be anywhere, whatever it did."""


class BayesFilter:
    """A belief over the states of a room.

    Args:
        states: how many there are.
    """

    def __init__(self, states: int) -> None:
        self._belief = np.full(states, 1.0 / states)

    def update(
        self,
        likeness: NDArray[np.floating],
        transitions: NDArray[np.integer],
        action: int | None,
        robot_moved: bool | None,
    ) -> int:
        """Take in a view.

        Args:
            likeness: (S,) cosine similarity of the view to each state's.
            transitions: (S, A) where actions lead; a state's own number where they are blocked.
            action: what was done since the last look; None for nothing.
            robot_moved: whether it moved the robot; None if that is not known.

        Returns:
            The most likely state.
        """
        led = (
            self._belief if action is None or robot_moved is False else self._led(transitions[:, action], robot_moved)
        )
        prior = (1 - ASTRAY) * led + ASTRAY / len(led)
        weighed = prior * np.exp((likeness - likeness.max()) / ALIKENESS)
        self._belief = weighed / weighed.sum()
        return int(self._belief.argmax())

    def _led(self, leads: NDArray[np.integer], robot_moved: bool | None) -> NDArray[np.float64]:
        """Where the belief is after an action that leads from each state to another one, (S,)."""
        belief, here = self._belief, np.arange(len(leads))
        if robot_moved:
            belief = np.where(leads == here, 0.0, belief)  # it was in no state where that is blocked
            if not belief.any():
                return np.full(len(leads), 1.0 / len(leads))
        led = np.bincount(leads, belief / belief.sum(), len(leads)).astype(np.float64)
        return led if robot_moved else (1 - BLOCKED) * led + BLOCKED * self._belief
