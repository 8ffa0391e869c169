"""What a learner is given for one scene."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from active_perceiver.envs.observations import Observations
from active_perceiver.envs.task import SearchTask


@dataclass(frozen=True, eq=False)
class TrainingTask:
    """A search task and what the policy is shown in it; the policy gets one branch per problem.

    Attributes:
        task: the search.
        observations: of the same states and targets, in the same order.
        changed: the same once more or several times, as a worse camera or other light shows it; learners that fit the
            network to a table train on these half of the time, the others do without.

    Raises:
        SearchError: if the two do not fit.
    """

    task: SearchTask
    observations: Observations
    changed: tuple[Observations, ...] = ()

    def __post_init__(self) -> None:
        for observations in (self.observations, *self.changed):
            observations.check_fits(self.task)

    def drawn(self, rng: np.random.Generator) -> Observations:
        """Those to train a batch on: every second time the ones as they are, else some of the changed."""
        if not self.changed or rng.random() < 0.5:
            return self.observations
        return self.changed[rng.integers(len(self.changed))]
