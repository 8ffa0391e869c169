"""Watching a policy while it is trained: the history, and when to stop."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray

from active_perceiver.policies.config import LearnerConfig
from active_perceiver.policies.evaluation import SearchResult, exact_evaluation, mean_evaluation
from active_perceiver.policies.markov_chain import entropies
from active_perceiver.policies.network import PolicyNetwork, task_table
from active_perceiver.policies.training_task import TrainingTask
from active_perceiver.utils.progress import ProgressCallback, quiet

Record = dict[str, float]
# Is shown every record and the policy tables (S, T, A) that it measures, one per problem.
Inspect = Callable[[Record, Sequence[NDArray[np.float32]]], None]

# Rounding keeps an exact success from being 1.
ALWAYS = 1 - 1e-6
# Less than this is no progress: pictures and batches differ by as much.
PROGRESS = 0.002


class Monitor:
    """Measures a network every few iterations, exactly, and says when it is good enough or time is up.

    Args:
        training_tasks: what it is measured in.
        config: how often, and when it is good enough.
        progress: told of each measurement.
        inspect: is shown each record and the tables it measures.

    A measurement uses one picture per target, another one each time; only when that one is good enough are all of
    them tried.

    Attributes:
        history: a record per measurement: `iteration`, `seconds` since the start, `measuring` (how many of these
            went into measurements, so that a benchmark can leave them out), `samples` (steps of rollouts so far),
            `success` (0..1), `mean_steps`, `ratio` (to the fewest steps) and `entropy` (mean over states and targets,
            in nats).
    """

    def __init__(
        self,
        training_tasks: Sequence[TrainingTask],
        config: LearnerConfig,
        progress: ProgressCallback = quiet,
        inspect: Inspect | None = None,
    ) -> None:
        self.history: list[Record] = []
        self._training_tasks = training_tasks
        self._config = config
        self._progress = progress
        self._inspect = inspect
        self._measured = 0  # the iteration
        self._measuring = 0.0
        self._started = time.monotonic()
        self._best_ratio = float("inf")
        self._best_at = 0  # measurements up to the best one

    def start(self, earlier: Sequence[Record] = ()) -> None:
        """Begin to count time; the learner calls it when its first iteration begins.

        Args:
            earlier: records of a training that goes on.
        """
        self._started = time.monotonic()
        if earlier:
            self.history[:] = earlier
            self._measured = int(earlier[-1]["iteration"])
            self._measuring = earlier[-1].get("measuring", 0.0)
            self._started -= earlier[-1]["seconds"]

    def finished(self, network: PolicyNetwork, iteration: int, samples: int = 0) -> bool:
        """Measure if it is time to, tell `progress`, and say whether to stop.

        Args:
            network: as it is after this iteration.
            iteration: counted from 1.
            samples: steps of rollouts so far.
        """
        config, began = self._config, time.monotonic()
        out_of_time = config.seconds is not None and began - self._started >= config.seconds
        waited = iteration - self._measured
        if waited < config.check_every and not out_of_time and not (waited and iteration >= config.iterations):
            return False
        self._measured = iteration
        result, entropy, tables = self._measure(network, picture=len(self.history))
        ended = time.monotonic()
        record = {
            "iteration": iteration,
            "seconds": ended - self._started,
            "measuring": self._measuring + ended - began,
            "samples": samples,
            "success": result.success,
            "mean_steps": result.mean_steps,
            "ratio": result.ratio,
            "entropy": entropy,
        }
        self.history.append(record)
        note = f"success {result.success:.3f}, {result.ratio:.3f} x the shortest paths"
        self._progress(iteration, config.iterations, note)
        if self._inspect is not None:
            self._inspect(record, tables)
        enough = (
            out_of_time or self._stalled(result) or (self._good(result) and self._good_with_every_picture(network))
        )
        # With what the callbacks did, which is no training either.
        self._measuring += time.monotonic() - began
        return enough

    def _measure(self, network: PolicyNetwork, picture: int) -> tuple[SearchResult, float, list[NDArray[np.float32]]]:
        tables = [
            task_table(network, training_task, picture % training_task.observations.pictures)[0]
            for training_task in self._training_tasks
        ]
        evaluations = [
            exact_evaluation(table, training_task.task, self._config.check_limit)
            for table, training_task in zip(tables, self._training_tasks, strict=True)
        ]
        entropy = float(np.mean([entropies(table).mean() for table in tables]))
        return mean_evaluation(evaluations).overall, entropy, tables

    def _stalled(self, result: SearchResult) -> bool:
        """Whether searches always arrive, but have not become shorter for `patience` measurements."""
        if result.success < ALWAYS:
            return False
        if result.ratio < self._best_ratio * (1 - PROGRESS):
            self._best_ratio, self._best_at = result.ratio, len(self.history)
        patience = self._config.patience
        return patience is not None and len(self.history) - self._best_at >= patience

    def _good(self, result: SearchResult) -> bool:
        target = self._config.target_ratio
        return target is not None and result.success >= ALWAYS and result.ratio <= target

    def _good_with_every_picture(self, network: PolicyNetwork) -> bool:
        most = max(training_task.observations.pictures for training_task in self._training_tasks)
        return all(self._good(self._measure(network, picture)[0]) for picture in range(most))
