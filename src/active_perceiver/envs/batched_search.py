"""Many searches at once, by table look-ups: the stepping that the vector environment, PPO and evaluation share."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from active_perceiver.envs.rewards import Reward
from active_perceiver.envs.task import SearchTask
from active_perceiver.errors import SearchError


class Outcome(NamedTuple):
    """What one step of N searches led to.

    Attributes:
        rewards: (N,) float64.
        terminated: (N,) bool, a goal was reached.
        truncated: (N,) bool, no goal and no steps left.
    """

    rewards: NDArray[np.float64]
    terminated: NDArray[np.bool_]
    truncated: NDArray[np.bool_]


class Searches:
    """N searches under way in one task. Plain arrays, all (N,), that `begin` and `step` write.

    Attributes:
        states: where each search is.
        targets: what each looks for.
        best_areas: the largest area each has seen in its episode.
        steps: actions each has taken.
    """

    def __init__(self, task: SearchTask, count: int, reward: Reward, max_steps: int) -> None:
        if count < 1 or max_steps < 1:
            raise SearchError(f"searches and their steps must be at least 1, got {count} and {max_steps}")
        self.task = task
        self.reward = reward
        self.max_steps = max_steps
        self.states = np.zeros(count, np.int64)
        self.targets = np.zeros(count, np.int64)
        self.steps = np.zeros(count, np.int64)
        self.best_areas = np.zeros(count, np.float32)
        # Starts of all targets in one row, so that a batch of starts is two look-ups.
        starts = [task.starts(target) for target in range(len(task.targets))]
        self._starts = np.concatenate(starts)
        self._start_counts = np.array([len(some) for some in starts])
        self._start_offsets = np.cumsum(self._start_counts) - self._start_counts

    def random_starts(self, targets: NDArray[np.integer], rng: np.random.Generator) -> NDArray[np.int64]:
        """One start for each target given, uniform over those from which a goal can be reached."""
        chosen = rng.integers(0, self._start_counts[targets])
        return self._starts[self._start_offsets[targets] + chosen]

    def begin(self, which: NDArray[np.integer], states: NDArray[np.integer], targets: NDArray[np.integer]) -> None:
        """Start the episodes of some searches.

        Args:
            which: (n,) indices of the searches.
            states: (n,) where they start.
            targets: (n,) what they look for.
        """
        self.states[which] = states
        self.targets[which] = targets
        self.steps[which] = 0
        self.best_areas[which] = self.task.areas[states, targets]

    def step(self, actions: NDArray[np.integer]) -> Outcome:
        """Take one action in every search.

        Args:
            actions: (N,) columns of the task's transitions.
        """
        self.states = self.task.transitions[self.states, actions].astype(np.int64)
        self.steps += 1
        area = self.task.areas[self.states, self.targets]
        arrived = self.task.goals[self.states, self.targets]
        rewards = self.reward.function(area, self.best_areas, arrived, self.task.goal_areas[self.targets])
        self.best_areas = np.maximum(self.best_areas, area)
        return Outcome(np.asarray(rewards, np.float64), arrived, ~arrived & (self.steps >= self.max_steps))
