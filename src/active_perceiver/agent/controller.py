"""The course of one search: the policy leads, unless it leads in circles or what is seen has to be made sure of."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from active_perceiver.agent.exploration import Explorer
from active_perceiver.agent.loop_escape import escape_loop
from active_perceiver.goals.goal import GoalObservation

REVISIT_LIMIT = 4
"""An agent that has looked at the present view so often before is lost: the policy does not lead on."""
EXPLORATION_BUDGET = 8
"""So many actions an agent that is lost for the first time goes round the room before it follows its policy again,
twice as many the second time, and so on: it may have been caught by a chair leg, and the target is where it was."""


class SearchController:
    """What an agent remembers of a search, and what follows from it.

    Args:
        confirm: whether found needs that the last other view nearly showed the target as well.
        explorer: where to go when the search is lost; None to follow the policy all the same.

    Attributes:
        exploring: whether the search is lost, and the room explored instead of following the policy.
    """

    def __init__(self, confirm: bool = False, explorer: Explorer | None = None) -> None:
        self.exploring = False
        self._confirm = confirm
        self._explorer = explorer
        self._nearly = self._nearly_before = False
        self._budget, self._left = EXPLORATION_BUDGET, 0

    def step(
        self,
        goal_observation: GoalObservation,
        probabilities: NDArray[np.floating],
        earlier: int,
        view_changed: bool,
        likeness: NDArray[np.floating] | None,
        robot_moved: bool | None = None,
    ) -> tuple[NDArray[np.float64], bool]:
        """What to make of a view.

        Args:
            goal_observation: what is seen in it.
            probabilities: (A,) of actions, the policy's.
            earlier: how often this search has looked at the same view before.
            view_changed: whether the last look was at another view.
            likeness: (S,) how alike the view is to each state of the room that the explorer knows, see
                `Explorer.update`; None without an explorer.
            robot_moved: whether the last action moved the robot, if it says so.

        Returns:
            (A,) probabilities from which to draw the action, which has to be told to `notify_action`; and whether the
            agent says found.
        """
        if view_changed:
            self._nearly_before = self._nearly
        self._nearly = goal_observation.nearly
        found = goal_observation.found and (self._nearly_before or not self._confirm)
        flattened = escape_loop(probabilities, earlier)
        if self._explorer is None or likeness is None:
            return flattened, found
        self._explorer.update(likeness, goal_observation.detection, robot_moved)
        self.exploring = self._is_exploring(earlier)
        if not self.exploring:
            return flattened, found
        # A policy that led astray may have been led so by what it saw: a search that is lost takes two views to say
        # found, unless it has been round the room and there is nothing better.
        if (goal_observation.found and self._nearly_before) or self._explorer.settled():
            return flattened, True
        certain = np.zeros(len(probabilities))
        certain[self._explorer.action()] = 1.0
        return certain, False

    def _is_exploring(self, earlier: int) -> bool:
        assert self._explorer is not None
        if self._left > 0 or (self.exploring and self._explorer.follows()):
            self._left -= 1
            return True
        if earlier < REVISIT_LIMIT:
            return False
        self._left, self._budget = self._budget - 1, 2 * self._budget
        return True

    def notify_action(self, action: int) -> None:
        """Note the action that is carried out next, by its index."""
        if self._explorer is not None:
            self._explorer.notify_action(action)
