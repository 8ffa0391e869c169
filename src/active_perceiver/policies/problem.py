"""What a learner is given for one scene."""

from __future__ import annotations

from dataclasses import dataclass

from active_perceiver.search.observations import Observations
from active_perceiver.search.task import SearchTask


@dataclass(frozen=True, eq=False)
class Problem:
    """A search task and what the policy is shown in it; the policy gets one branch per problem.

    Attributes:
        task: the search.
        observations: of the same states and targets, in the same order.

    Raises:
        SearchError: if the two do not fit.
    """

    task: SearchTask
    observations: Observations

    def __post_init__(self) -> None:
        self.observations.check_fits(self.task)
