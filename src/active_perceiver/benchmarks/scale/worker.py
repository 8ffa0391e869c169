"""A process of its own that trains one policy on synthetic scenes, and prints what it took in time and memory.

Being fresh, its memory is that of this training. Measuring the policy is not part of the training's time.
Run by `measure.py`.
"""

from __future__ import annotations

import ctypes
import functools
import gc
import json
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager, suppress
from pathlib import Path
from typing import Any

from active_perceiver.benchmarks.scale.synthetic_scenes import synthetic_tasks
from active_perceiver.policies.learners import LEARNERS
from active_perceiver.policies.training_task import TrainingTask
from active_perceiver.utils.memory import peak_memory

RATIOS = (1.25, 1.02)
"""Qualities to reach, each with success 1.0: mean steps over the fewest possible."""
PARTS = ("forward", "backward", "optimiser", "advantages", "rollouts")
"""Where the time of a training goes; what is left is the rest, mostly taking rows of tables."""
CHECK_LIMIT = 1000
"""Steps after which a search has failed."""

# From one measurement to the next the training is at least this much longer, so many measurements cost little.
_SPACING = 1.03


def measure_training(
    learner: str,
    scenes: int,
    states: int,
    targets: int,
    seconds: float,
    iterations: int | None = None,
    threads: int = 1,
    seed: int = 0,
) -> dict[str, Any]:
    """Train until the searches are as short as the last of `RATIOS` says, or time is up.

    Args:
        learner: a name in `LEARNERS`.
        scenes: number of scenes.
        states: of each.
        targets: of each.
        seconds: longest training, measurements not counted.
        iterations: most iterations; None for the learner's own default.
        threads: CPU threads of torch.
        seed: of the scenes and of the training.

    Returns:
        "scenes", "states" of each, "rows": pairs of a state and a target; "data_mib": of tables and features;
        "parameters" of the network; "iterations", "seconds", "cpu_seconds" and "seconds_per_iteration" of the
        training; "parts": seconds in each of `PARTS` and the "rest"; "reached": for each of `RATIOS` {"seconds",
        "cpu_seconds", "iterations", "after_seconds": of the measurement before} or None; "success" and "ratio" at
        the end; "ended" by "quality", "time" or "iterations"; "training_mib": peak memory above what there was
        before, in an iteration, and "peak_mib" with the measurements, None where the system does not tell;
        "measuring_seconds" and "measurements".
    """
    chosen = LEARNERS[learner]
    fixed: dict[str, Any] = {
        "seed": seed,
        "threads": threads,
        "target_ratio": None,
        "patience": None,
        "check_limit": CHECK_LIMIT,
    }
    # What the libraries do once is done here.
    chosen.train(synthetic_tasks(1, 96, 1), chosen.config(**{**fixed, "iterations": 1}))
    training_tasks = synthetic_tasks(scenes, states, targets, seed)
    config = chosen.config(**fixed, **({} if iterations is None else {"iterations": iterations}))
    clock = TrainingClock(seconds, config.iterations)
    with clock.watching():
        network, _ = chosen.train(training_tasks, config)
    return {
        "learner": learner,
        "scenes": scenes,
        "states": len(training_tasks[0].task),
        "rows": sum(training_task.task.goals.size for training_task in training_tasks),
        "data_mib": sum(map(data_bytes, training_tasks)) / 2**20,
        "parameters": sum(weights.numel() for weights in network.parameters()),
        **clock.result(),
    }


def data_bytes(training_task: TrainingTask) -> int:
    """What the tables and features of a problem take."""
    task, seen = training_task.task, training_task.observations
    arrays = (
        task.transitions, task.areas, task.goals, task.steps,
        seen.view_features, seen.target_features, seen.masks,
    )  # fmt: skip
    return sum(array.nbytes for array in arrays)


class TrainingClock:
    """Watches a training: its time and memory without those of the measurements, and when it is good enough.

    It takes the place of `Monitor.finished`, which the learners ask after each iteration whether to stop.

    Args:
        limit: seconds of training after which to stop.
        iterations: after which the learner stops itself.
    """

    def __init__(self, limit: float, iterations: int) -> None:
        self._limit = limit
        self._last = iterations
        self._next = 0.0  # seconds of training at which to measure
        self._parts = dict.fromkeys(PARTS, 0.0)
        self._training, self._measuring = Stopwatch(), Stopwatch()
        self._floor: float | None = None  # GiB
        self._peak = 0.0  # GiB
        self._training_mib: float | None = None
        self._records: list[dict[str, float]] = []
        self._iterations = 0
        self._ended = "iterations"

    @contextmanager
    def watching(self) -> Iterator[None]:
        """Trainings in this block are watched."""
        import torch

        from active_perceiver.policies import mirror_descent
        from active_perceiver.policies.monitor import Monitor
        from active_perceiver.policies.network import PolicyNetwork
        from active_perceiver.policies.rollouts import RolloutWorker

        timed: tuple[tuple[str, Any, str], ...] = (
            ("forward", PolicyNetwork, "table"),
            ("backward", torch.Tensor, "backward"),
            ("optimiser", torch.optim.Adam, "step"),
            ("optimiser", torch.optim.swa_utils.AveragedModel, "update_parameters"),
            ("advantages", mirror_descent, "exact_advantages"),
            ("rollouts", RolloutWorker, "run"),
        )
        measure = Monitor.finished

        def finished(monitor: Monitor, network: PolicyNetwork, iteration: int, samples: int = 0) -> bool:
            self._training.stop()
            if self._iterations == 0:
                self._training_mib = self._above_floor()  # all iterations are alike, and nothing was measured yet
            self._iterations = iteration
            out_of_time = self._training.seconds >= self._limit
            due = out_of_time or iteration >= self._last or self._training.seconds >= self._next
            if due:
                self._measuring.start()
                parts = dict(self._parts)
                measure(monitor, network, iteration, samples)
                self._parts = parts  # measuring has forward passes too
                self._measuring.stop()
                self._note(monitor.history[-1])
            if self._ended != "quality" and out_of_time:
                self._ended = "time"
            self._training.start()
            return self._ended != "iterations"

        with ExitStack() as patches:
            for part, owner, name in timed:
                patches.enter_context(replaced(owner, name, self._timed(part, getattr(owner, name))))
            patches.enter_context(replaced(Monitor, "finished", finished))
            self._floor = release_memory()
            self._training.start()
            yield

    def result(self) -> dict[str, Any]:
        """See `measure_training`."""
        seconds = self._training.seconds
        return {
            "iterations": self._iterations,
            "seconds": seconds,
            "cpu_seconds": self._training.cpu_seconds,
            "seconds_per_iteration": seconds / self._iterations,
            "parts": {**self._parts, "rest": seconds - sum(self._parts.values())},
            "reached": {f"{ratio:g}": self._reached(ratio) for ratio in RATIOS},
            "success": self._records[-1]["success"],
            "ratio": self._records[-1]["ratio"],
            "ended": self._ended,
            "training_mib": self._training_mib,
            "peak_mib": self._above_floor(),
            "measuring_seconds": self._measuring.seconds,
            "measurements": len(self._records),
        }

    def _note(self, record: dict[str, float]) -> None:
        seconds = self._training.seconds
        kept = {name: record[name] for name in ("success", "ratio", "iteration")}
        self._records.append({**kept, "seconds": seconds, "cpu_seconds": self._training.cpu_seconds})
        # Measuring a bad policy in many scenes can take longer than an iteration.
        self._next = max(seconds * _SPACING, seconds + self._measuring.last)
        if self._reached(RATIOS[-1]) is not None:
            self._ended = "quality"

    def _reached(self, ratio: float) -> dict[str, float] | None:
        from active_perceiver.policies.monitor import ALWAYS

        before = 0.0
        for record in self._records:
            if record["success"] >= ALWAYS and record["ratio"] <= ratio:
                return {
                    "seconds": record["seconds"],
                    "cpu_seconds": record["cpu_seconds"],
                    "iterations": record["iteration"],
                    "after_seconds": before,
                }
            before = record["seconds"]
        return None

    def _above_floor(self) -> float | None:
        """Most memory so far above what there was before the training, in MiB; None where no one can tell."""
        peak = peak_memory()
        if self._floor is None or peak is None:
            return None
        # The system's count is exact only to a fraction of a MiB, and so would sometimes go down.
        self._peak = max(self._peak, peak)
        return 1024 * (self._peak - self._floor)

    def _timed(self, part: str, function: Callable[..., Any]) -> Callable[..., Any]:
        """The function, adding how long it takes to a part."""

        @functools.wraps(function)
        def run(*arguments: Any, **options: Any) -> Any:
            started = time.perf_counter()
            try:
                return function(*arguments, **options)
            finally:
                self._parts[part] += time.perf_counter() - started

        return run


class Stopwatch:
    """Time of something that is done bit by bit.

    Attributes:
        seconds: of all bits so far.
        cpu_seconds: likewise.
        last: seconds of the last bit.
    """

    def __init__(self) -> None:
        self.seconds = self.cpu_seconds = self.last = 0.0
        self._started = self._cpu_started = 0.0

    def start(self) -> None:
        """Go on."""
        self._started, self._cpu_started = time.perf_counter(), time.process_time()

    def stop(self) -> None:
        """Pause."""
        self.last = time.perf_counter() - self._started
        self.seconds += self.last
        self.cpu_seconds += time.process_time() - self._cpu_started


@contextmanager
def replaced(owner: Any, name: str, instead: Any) -> Iterator[None]:
    """Put something else in an attribute's place for the length of the block: that is how a profiler gets in."""
    before = getattr(owner, name)
    setattr(owner, name, instead)
    try:
        yield
    finally:
        setattr(owner, name, before)


def release_memory() -> float | None:
    """Give back what is free and forget the peak: what is in use now, in GiB; None where that cannot be done."""
    gc.collect()
    with suppress(OSError, AttributeError):  # the C library of Linux has it
        ctypes.CDLL(None).malloc_trim(0)
    return peak_memory() if reset_peak_memory() else None


def reset_peak_memory() -> bool:
    """Let `peak_memory` count from what is in use now; whether the system can do that."""
    try:
        Path("/proc/self/clear_refs").write_text("5")
    except OSError:
        return False
    return True


if __name__ == "__main__":
    print(json.dumps(measure_training(**json.loads(sys.argv[1]))))
