"""What leads a search: the policy, seen from the controller, that knows neither networks nor tables."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from active_perceiver.agent.goals.goal import GoalObservation
from active_perceiver.agent.visit_memory import ViewFeatures
from active_perceiver.policies.policy import ActionPolicy
from active_perceiver.utils.sections import section
from active_perceiver.vision.location import location_mask

NOWHERE = np.full(4, np.nan)
"""The box of a target that is not seen."""


@dataclass(frozen=True, eq=False)
class Observation:
    """One look, and all that the next action is decided by.

    Attributes:
        goal: what is seen of what is searched for.
        view: what is seen at all.
        robot_moved: whether the last action moved the robot, as `Robot.execute` says; None to tell by the views, and
            at the first look.
    """

    goal: GoalObservation
    view: ViewFeatures
    robot_moved: bool | None = None


class SearchPolicy(Protocol):
    """The policy of one search: it knows the target and the scene."""

    def __call__(self, observation: Observation) -> NDArray[np.floating]:
        """(A,) probabilities of the actions."""
        ...


class TargetPolicy:
    """A policy that is asked for one target in one scene (the paper, section IV-B).

    Args:
        policy: of all targets and scenes.
        target: (1, D) float32 features of the target's picture.
        branch: the scene whose branch decides.
    """

    def __init__(self, policy: ActionPolicy, target: NDArray[np.float32], branch: str) -> None:
        self._policy = policy
        self._target = target
        self._branch = branch

    def __call__(self, observation: Observation) -> NDArray[np.floating]:
        """See `SearchPolicy`: the policy is shown the view, the target, and where in the view the target is seen."""
        detection = observation.goal.detection
        mask = location_mask(NOWHERE if detection is None else detection.box)
        with section("policy"):
            views = observation.view.features[None]
            return self._policy.probabilities(views, self._target, mask[None], self._branch)[0]
