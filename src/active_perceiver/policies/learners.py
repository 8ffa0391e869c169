"""The learners by name. Importing this does not import torch; training does."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING

from active_perceiver.errors import SearchError
from active_perceiver.policies.config import A3cConfig, DistilConfig, LearnerConfig, MirrorDescentConfig, PpoConfig
from active_perceiver.policies.training_task import TrainingTask
from active_perceiver.utils.progress import ProgressCallback, quiet

if TYPE_CHECKING:
    from active_perceiver.policies.monitor import Inspect, Monitor
    from active_perceiver.policies.network import PolicyNetwork


# Imported by name when a training begins, for it needs torch.
_MONITOR = "active_perceiver.policies.monitor"


@dataclass(frozen=True)
class Learner:
    """A way to train a policy.

    Attributes:
        name: its key in `LEARNERS`.
        config: the class of its settings.
        function: where it is, as "module:function". It is given the training tasks, the settings and a `Monitor`,
            which it starts, and asks after each iteration whether that was the last; it returns the network.
        meaning: one line for help texts.
        keeps_checkpoints: whether it takes so long that it keeps its state in a file.
    """

    name: str
    config: type[LearnerConfig]
    function: str
    meaning: str
    keeps_checkpoints: bool = False

    def train(
        self,
        training_tasks: Sequence[TrainingTask],
        config: LearnerConfig | None = None,
        progress: ProgressCallback = quiet,
        inspect: Inspect | None = None,
        checkpoint: Path | None = None,
        monitor: Monitor | None = None,
    ) -> tuple[PolicyNetwork, list[dict[str, float]]]:
        """Train a policy with a branch for each problem.

        Args:
            training_tasks: one per scene, with features of one backbone.
            config: of the class `config`; None for its defaults.
            progress: told at each measurement how many iterations are done, and how good the policy is.
            inspect: is shown each record of the history with the policy tables it measures.
            checkpoint: where a learner that keeps checkpoints keeps its state; one that is there is gone on with.
            monitor: another one than is made of `progress` and `inspect`.

        Returns:
            The network and the history; see `Monitor` for what a record holds.

        Raises:
            SearchError: if torch is not installed, the configuration is another learner's, or the problems do not
                go together.
        """
        config = self.config() if config is None else config
        if not isinstance(config, self.config):
            raise SearchError(f"'{self.name}' needs a {self.config.__name__}, got a {type(config).__name__}")
        module, function = self.function.split(":")
        try:
            train = getattr(import_module(module), function)
        except ModuleNotFoundError as error:
            raise SearchError(f"training needs {error.name}: pip install 'active-perceiver[train]'") from None
        with _torch_set_up(config.threads):
            monitor = monitor or import_module(_MONITOR).Monitor(training_tasks, config, progress, inspect)
            kept = (checkpoint,) if self.keeps_checkpoints else ()
            return train(training_tasks, config, monitor, *kept), monitor.history


LEARNERS: dict[str, Learner] = {
    learner.name: learner
    for learner in (
        Learner(
            "mirror-descent",
            MirrorDescentConfig,
            "active_perceiver.policies.mirror_descent:train_mirror_descent",
            "exact advantages from the scene's transitions; by far the fastest that is only told a reward",
        ),
        Learner(
            "distil",
            DistilConfig,
            "active_perceiver.policies.distil:train_distil",
            "is shown the shortest paths: the practical upper bound",
        ),
        Learner(
            "ppo",
            PpoConfig,
            "active_perceiver.policies.ppo:train_ppo",
            "rollouts by table look-ups; for any reward",
        ),
        Learner(
            "a3c",
            A3cConfig,
            "active_perceiver.policies.a3c.learner:train_a3c",
            "a process per scene and target, as the paper trains; slow",
            keeps_checkpoints=True,
        ),
    )
}


def learner_named(name: str) -> Learner:
    """A learner by name.

    Raises:
        SearchError: if there is none; the message lists those there are.
    """
    if name not in LEARNERS:
        raise SearchError(f"there is no learner '{name}'; choose one of {', '.join(LEARNERS)}")
    return LEARNERS[name]


@contextmanager
def _torch_set_up(threads: int) -> Iterator[None]:
    """Give torch so many threads, and let it round what it multiplies to bfloat16; afterwards it is as before.

    Weights and sums stay float32. On a CPU that multiplies bfloat16 a training takes two thirds of the time and needs
    as many steps; on others nothing changes.
    """
    torch = import_module("torch")
    before = torch.get_num_threads(), torch.get_float32_matmul_precision()
    torch.set_num_threads(threads)
    torch.set_float32_matmul_precision("medium")
    try:
        yield
    finally:
        torch.set_num_threads(before[0])
        torch.set_float32_matmul_precision(before[1])
