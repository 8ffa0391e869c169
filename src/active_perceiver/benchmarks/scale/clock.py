"""The clock of `benchmark scale`: a training's time and memory without those of its measurements."""

from __future__ import annotations

import ctypes
import gc
import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

from active_perceiver.policies.config import LearnerConfig
from active_perceiver.policies.monitor import ALWAYS, Monitor
from active_perceiver.policies.network import PolicyNetwork
from active_perceiver.policies.training_task import TrainingTask
from active_perceiver.utils.memory import peak_memory
from active_perceiver.utils.sections import listening

RATIOS = (1.25, 1.02)
"""Qualities to reach, each with success 1.0: mean steps over the fewest possible."""


PARTS = ("forward", "backward", "optimiser", "advantages", "rollouts")
"""Where the time of a training goes; what is left is the rest, mostly taking rows of tables."""

# From one measurement to the next the training is at least this much longer, so many measurements cost little.
SPACING = 1.03


class TrainingClock(Monitor):
    """Watches a training: its time and memory without those of the measurements, and when it is good enough.

    Args:
        training_tasks: what is trained in.
        config: of the learner, which stops itself after so many iterations.
        limit: seconds of training after which to stop.
    """

    def __init__(self, training_tasks: Sequence[TrainingTask], config: LearnerConfig, limit: float) -> None:
        super().__init__(training_tasks, config)
        self._limit = limit
        self._last = config.iterations
        self._next = 0.0  # seconds of training at which to measure
        self._parts = dict.fromkeys(PARTS, 0.0)
        self._trained, self._measured_for = Stopwatch(), Stopwatch()
        self._floor: float | None = None  # GiB
        self._peak = 0.0  # GiB
        self._training_mib: float | None = None
        self._records: list[dict[str, float]] = []
        self._iterations = 0
        self._ended = "iterations"

    @contextmanager
    def watching(self) -> Iterator[None]:
        """The training is what is done in this block."""
        with listening(self._hear):
            self._floor = release_memory()
            self._trained.start()
            yield

    def finished(self, network: PolicyNetwork, iteration: int, samples: int = 0) -> bool:
        """Measure if that is due, and say whether to stop; see `Monitor.finished`."""
        self._trained.stop()
        if self._iterations == 0:
            self._training_mib = self._above_floor()  # all iterations are alike, and nothing was measured yet
        self._iterations = iteration
        out_of_time = self._trained.seconds >= self._limit
        if out_of_time or iteration >= self._last or self._trained.seconds >= self._next:
            self._measured_for.start()
            super().finished(network, iteration, samples)
            self._measured_for.stop()
            self._note(self.history[-1])
        if self._ended != "quality" and out_of_time:
            self._ended = "time"
        self._trained.start()
        return self._ended != "iterations"

    def _hear(self, name: str, seconds: float) -> None:
        if self._trained.runs:  # measuring has forward passes too
            self._parts[name] += seconds

    def result(self) -> dict[str, Any]:
        """See `measure_training`."""
        seconds = self._trained.seconds
        return {
            "iterations": self._iterations,
            "seconds": seconds,
            "cpu_seconds": self._trained.cpu_seconds,
            "seconds_per_iteration": seconds / self._iterations,
            "parts": {**self._parts, "rest": seconds - sum(self._parts.values())},
            "reached": {f"{ratio:g}": self._reached(ratio) for ratio in RATIOS},
            "success": self._records[-1]["success"],
            "ratio": self._records[-1]["ratio"],
            "ended": self._ended,
            "training_mib": self._training_mib,
            "peak_mib": self._above_floor(),
            "measuring_seconds": self._measured_for.seconds,
            "measurements": len(self._records),
        }

    def _note(self, record: dict[str, float]) -> None:
        seconds = self._trained.seconds
        kept = {name: record[name] for name in ("success", "ratio", "iteration")}
        self._records.append({**kept, "seconds": seconds, "cpu_seconds": self._trained.cpu_seconds})
        # Measuring a bad policy in many scenes can take longer than an iteration.
        self._next = max(seconds * SPACING, seconds + self._measured_for.last)
        if self._reached(RATIOS[-1]) is not None:
            self._ended = "quality"

    def _reached(self, ratio: float) -> dict[str, float] | None:
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


class Stopwatch:
    """Time of something that is done bit by bit.

    Attributes:
        seconds: of all bits so far.
        cpu_seconds: likewise.
        last: seconds of the last bit.
        runs: whether a bit is being done.
    """

    def __init__(self) -> None:
        self.seconds = self.cpu_seconds = self.last = 0.0
        self.runs = False
        self._started = self._cpu_started = 0.0

    def start(self) -> None:
        """Go on."""
        self.runs = True
        self._started, self._cpu_started = time.perf_counter(), time.process_time()

    def stop(self) -> None:
        """Pause."""
        self.runs = False
        self.last = time.perf_counter() - self._started
        self.seconds += self.last
        self.cpu_seconds += time.process_time() - self._cpu_started


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
