"""The course of one search: the policy leads, unless it leads in circles or what is seen has to be made sure of."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from active_perceiver.exploring import Explorer
from active_perceiver.known_targets import Sight
from active_perceiver.policies.restless import restless

LOST = 4
"""An agent that has looked at the present view so often before is lost: the policy does not lead on."""
EXCURSION = 8
"""So many actions an agent that is lost for the first time goes round the room before it follows its policy again,
twice as many the second time, and so on: it may have been caught by a chair leg, and the target is where it was."""


class Course:
    """What an agent remembers of a search, and what follows from it.

    Args:
        confirm: whether found needs that the last other view nearly showed the target as well.
        explorer: where to go when the search is lost; None to follow the policy all the same.

    Attributes:
        lost: whether the search is lost, and the room explored instead of following the policy.
    """

    def __init__(self, confirm: bool = False, explorer: Explorer | None = None) -> None:
        self.lost = False
        self._confirm = confirm
        self._explorer = explorer
        self._nearly = self._nearly_before = False
        self._excursion, self._left = EXCURSION, 0

    def decide(
        self,
        sight: Sight,
        probabilities: NDArray[np.floating],
        earlier: int,
        moved: bool,
        likeness: NDArray[np.floating] | None,
        told: bool | None = None,
    ) -> tuple[NDArray[np.float64], bool]:
        """What to make of a view.

        Args:
            sight: what is seen in it.
            probabilities: (A,) of actions, the policy's.
            earlier: how often this search has looked at the same view before.
            moved: whether the last look was at another view.
            likeness: (S,) how alike the view is to each state of the room that the explorer knows, see
                `Explorer.look`; None without an explorer.
            told: whether the last action moved the robot, if it says so.

        Returns:
            (A,) probabilities from which to draw the action, which has to be told to `did`; and whether the agent
            says found.
        """
        if moved:
            self._nearly_before = self._nearly
        self._nearly = sight.nearly
        found = sight.found and (self._nearly_before or not self._confirm)
        flattened = restless(probabilities, earlier)
        if self._explorer is None or likeness is None:
            return flattened, found
        self._explorer.look(likeness, sight.detection, told)
        self.lost = self._is_lost(earlier)
        if not self.lost:
            return flattened, found
        # A policy that led astray may have been led so by what it saw: a search that is lost takes two views to say
        # found, unless it has been round the room and there is nothing better.
        if (sight.found and self._nearly_before) or self._explorer.settled():
            return flattened, True
        certain = np.zeros(len(probabilities))
        certain[self._explorer.action()] = 1.0
        return certain, False

    def _is_lost(self, earlier: int) -> bool:
        assert self._explorer is not None
        if self._left > 0 or (self.lost and self._explorer.follows()):
            self._left -= 1
            return True
        if earlier < LOST:
            return False
        self._left, self._excursion = self._excursion - 1, 2 * self._excursion
        return True

    def did(self, action: int) -> None:
        """Note the action that is carried out next, by its index."""
        if self._explorer is not None:
            self._explorer.did(action)
