"""What a search does next: the one place where it is decided, for a live robot and for the tables of evaluation.

The policy leads, unless it leads in circles or what is seen has to be made sure of.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from active_perceiver.agent.exploration import Explorer
from active_perceiver.agent.found_criterion import says_found
from active_perceiver.agent.loop_escape import escape_loop
from active_perceiver.agent.search_policy import Observation, SearchPolicy
from active_perceiver.agent.visit_memory import VisitMemory

REVISIT_LIMIT = 4
"""An agent that has looked at the present view so often before is lost: the policy does not lead on."""
EXPLORATION_BUDGET = 8
"""So many actions an agent that is lost for the first time goes round the room before it follows its policy again,
twice as many the second time, and so on: it may have been caught by a chair leg, and the target is where it was."""


@dataclass(frozen=True, eq=False)
class Decision:
    """What follows from a look.

    Attributes:
        action: index of the action to do next; meaningless once found.
        probabilities: (A,) float64, from which it was drawn.
        found: whether the agent says that it is in front of what it looks for.
    """

    action: int
    probabilities: NDArray[np.float64]
    found: bool


class SearchController:
    """Decides for one search, look by look, and remembers of it what decisions need.

    Args:
        policy: leads to the target.
        confirm: whether found needs that the last other view nearly showed the target as well.
        explorer: where to go when the search is lost; None to follow the policy all the same.
        seed: the draws of actions follow from it.

    Attributes:
        exploring: whether the search is lost, and the room explored instead of following the policy.
    """

    def __init__(
        self,
        policy: SearchPolicy,
        *,
        confirm: bool = False,
        explorer: Explorer | None = None,
        seed: int | np.random.Generator | None = None,
    ) -> None:
        self.exploring = False
        self._policy = policy
        self._confirm = confirm
        self._explorer = explorer
        self._rng = np.random.default_rng(seed)
        self._visits = VisitMemory()
        self._nearly = self._nearly_before = False
        self._budget, self._left = EXPLORATION_BUDGET, 0
        self._action = -1
        self._blocked: set[int] = set()

    def step(self, observation: Observation) -> Decision:
        """Take in a look and decide; the action is then taken for carried out.

        Raises:
            ValueError: if the controller has an explorer, and the observation no likeness to the room's states.
        """
        visit = self._visits.visit(observation.view, observation.robot_moved)
        if visit.view_changed:
            self._nearly_before = self._nearly
        self._nearly = observation.goal.nearly
        self._note_blocked(observation.robot_moved)
        probabilities = escape_loop(self._unblocked(self._policy(observation)), visit.earlier)
        settled = False
        if self._explorer is not None:
            self._update(self._explorer, observation)
            self.exploring = self._is_exploring(self._explorer, visit.earlier)
            settled = self.exploring and self._explorer.settled()
        found = says_found(
            observation.goal.found,
            self._nearly_before,
            confirm=self._confirm,
            exploring=self.exploring,
            settled=settled,
        )
        if self._explorer is not None and self.exploring and not found:
            probabilities = np.zeros(len(probabilities))
            probabilities[self._explorer.action()] = 1.0
        self._action = self._draw(probabilities)
        if self._explorer is not None:
            self._explorer.notify_action(self._action)
        return Decision(self._action, probabilities, found)

    def _note_blocked(self, robot_moved: bool | None) -> None:
        """Remember which actions have been tried here in vain."""
        if robot_moved is False:
            self._blocked.add(self._action)
        elif robot_moved:
            self._blocked.clear()

    def _unblocked(self, probabilities: NDArray[np.floating]) -> NDArray[np.floating]:
        """The policy's probabilities without the actions that are blocked here, if that leaves any."""
        unblocked = probabilities.copy()
        unblocked[list(self._blocked)] = 0.0
        total = unblocked.sum()
        return unblocked / total if total > 0 else probabilities

    def _update(self, explorer: Explorer, observation: Observation) -> None:
        if observation.view.likeness is None:
            raise ValueError("an explorer needs to know how alike the view is to those of its room")
        explorer.update(observation.view.likeness, observation.goal.detection, observation.robot_moved)

    def _is_exploring(self, explorer: Explorer, earlier: int) -> bool:
        if self._left > 0 or (self.exploring and explorer.follows()):
            self._left -= 1
            return True
        if earlier < REVISIT_LIMIT:
            return False
        self._left, self._budget = self._budget - 1, 2 * self._budget
        return True

    def _draw(self, probabilities: NDArray[np.float64]) -> int:
        """As `Generator.choice` does, without its checks, which take longer than the rest of a step in tables."""
        limits = probabilities.cumsum()
        return int((limits / limits[-1]).searchsorted(self._rng.random(), side="right"))
