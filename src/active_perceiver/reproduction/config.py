"""Settings of `reproduce`; the docstring under a field is its help on the command line."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from active_perceiver.errors import UserError

SetupName = Literal["one_object", "four_objects", "sixteen_objects", "conference_room"]
MethodName = Literal["random", "reward_1", "reward_2", "record_high", "record_low"]
LearnerName = Literal["a3c", "ppo"]
Experiment = Literal["table1", "table2", "curves", "entropy", "trajectories", "choices", "all"]


@dataclass(frozen=True)
class ReproduceConfig:
    """What to reproduce, and how much of it."""

    boxes: Literal["recogniser", "ground-truth"] = "recogniser"
    """Whose boxes the policy is shown: those of the paper's recogniser, cross-validated (each view is judged by one
    that was not trained in its place), or the true ones."""
    learners: tuple[LearnerName, ...] = ("a3c", "ppo")
    """The paper's learner, and the one that needs no processes."""
    setups: tuple[SetupName, ...] = ()
    """Parts of table 1; all if not given."""
    methods: tuple[MethodName, ...] = ()
    """Methods of table 1; all if not given."""
    seeds: int | None = None
    """Trainings of each kind; 3 if not given."""
    quick: bool = False
    """Everything small, in minutes: to see that it works, not for its figures."""
    backbone: str = "efficientnet_lite0"
    """Frozen feature extractor: efficientnet_lite0 or resnet50, the paper's (downloads its weights once)."""
    minutes: float | None = None
    """Begin no further training after so many minutes; the same command goes on where it stopped."""

    def __post_init__(self) -> None:
        if self.seeds is not None and self.seeds < 1:
            raise UserError(f"at least one seed is needed, got {self.seeds}")
        if not self.learners:
            raise UserError("name at least one learner: a3c or ppo")
        if self.minutes is not None and not self.minutes > 0:
            raise UserError(f"minutes must be positive, got {self.minutes}")
