"""The rewards a learner can be paid with: the paper's three and two that lead to shorter paths."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from active_perceiver.envs.task import SearchTask
from active_perceiver.errors import SearchError

STEP_COST = 0.02
GAIN_WEIGHT = 0.3

# Area seen after the step, largest area seen before it, whether it ended at a goal, smallest area of a goal.
RewardFunction = Callable[[Any, Any, Any, Any], NDArray[np.floating]]


@dataclass(frozen=True)
class Reward:
    """One way to pay for a step.

    Attributes:
        name: its key in `REWARDS`.
        function: maps `area` (seen after the step, fraction of the image), `record` (largest area seen in the
            episode before the step), `is_goal` (whether the step ended at a goal) and `goal_area` (the smallest
            that the target has at a goal), all of one shape or scalars, to the reward.
        markov: whether it depends on the step alone. Exact advantages need that; a reward for new records
            depends on the past.
        meaning: one line for help texts.
        pays_area: whether it is nothing but an area, a fraction of the image, so that its unit is arbitrary.
    """

    name: str
    function: RewardFunction
    markov: bool
    meaning: str
    pays_area: bool = False

    def largest(self, task: SearchTask) -> float:
        """Largest absolute reward of a step in a task: a learner divides by it so that returns are of order 1."""
        rewards = self.function(task.areas, np.zeros_like(task.areas), task.goals, task.goal_areas)
        return float(np.abs(rewards).max())


def record_reward(area: Any, best_area: Any, is_goal: Any, goal_area: Any) -> NDArray[np.floating]:
    """Equation 2 of the paper: the area if it beats every earlier area of the episode, else 0."""
    return np.where(area > best_area, area, 0.0)


def goal_reward(area: Any, best_area: Any, is_goal: Any, goal_area: Any) -> NDArray[np.floating]:
    """Reward 1 of the paper: 10 at a goal, -0.01 elsewhere."""
    return np.where(is_goal, 10.0, -0.01)


def area_reward(area: Any, best_area: Any, is_goal: Any, goal_area: Any) -> NDArray[np.floating]:
    """Reward 2 of the paper: the area, at every step."""
    return np.asarray(area, np.float64)


def gain_reward(area: Any, best_area: Any, is_goal: Any, goal_area: Any) -> NDArray[np.floating]:
    """Area gained over the record, 0.3 in all from nothing to a goal, plus 1 at a goal, less 0.02 a step.

    Unlike the record reward it pays for arriving, and many small records earn no more than one large one. What
    exceeds the area that makes a goal earns nothing, so that no detour to a larger view pays.
    """
    gained = np.maximum(np.minimum(area, goal_area) - best_area, 0.0) / goal_area
    return GAIN_WEIGHT * gained + arrival_reward(area, best_area, is_goal, goal_area)


def arrival_reward(area: Any, best_area: Any, is_goal: Any, goal_area: Any) -> NDArray[np.floating]:
    """1 at a goal, less 0.02 a step."""
    return np.where(is_goal, 1.0, 0.0) - STEP_COST


REWARDS: dict[str, Reward] = {
    reward.name: reward
    for reward in (
        Reward("gain", gain_reward, False, "area gained over the record, 1 at a goal, less a step cost"),
        Reward("arrival", arrival_reward, True, "1 at a goal, less a step cost"),
        Reward("record", record_reward, False, "the area when it is a record: equation 2 of the paper", True),
        Reward("goal", goal_reward, True, "10 at a goal, -0.01 elsewhere: reward 1 of the paper"),
        Reward("area", area_reward, True, "the area at every step: reward 2 of the paper", True),
    )
}


def reward_named(name: str) -> Reward:
    """A reward by name.

    Raises:
        SearchError: if there is none; the message lists those there are.
    """
    if name not in REWARDS:
        raise SearchError(f"there is no reward '{name}'; choose one of {', '.join(REWARDS)}")
    return REWARDS[name]
