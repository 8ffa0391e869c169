"""A process of its own that trains one policy and prints how good it is, as it goes; run by `measure.py`."""

from __future__ import annotations

import json
import math
import pickle
import sys
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

from active_perceiver.benchmarks.train.baselines import Baseline, baseline_named
from active_perceiver.policies.monitor import ALWAYS
from active_perceiver.policies.training_task import TrainingTask


def train(
    training_task: TrainingTask, name: str, seed: int, threads: int, seconds: float, tell: Callable[[Any], None]
) -> None:
    """Train once.

    What happens once in a process, such as compiling or loading what the first step of an optimiser needs, is not the
    learner's: a training of one iteration comes before the one that counts.

    Args:
        training_task: the search.
        name: of the baseline.
        seed: of everything random.
        threads: of torch.
        seconds: longest it may take.
        tell: is called with each measurement, see `measured`.
    """
    baseline = baseline_named(name)
    config = replace(baseline.config, seed=seed, threads=threads)
    baseline.learner.train([training_task], replace(config, iterations=1))
    baseline.learner.train(
        [training_task], replace(config, seconds=seconds), lambda record: tell(measured(record, baseline))
    )


def measured(record: dict[str, float], baseline: Baseline) -> dict[str, float | None]:
    """What counts of a record of a history.

    Returns:
        "seconds" of training until then, "steps" in the environment, "success", and "ratio", None if no search
        arrives.
    """
    pause = 0.0 if baseline.goes_on else record["measuring"]
    return {
        "seconds": record["seconds"] - pause,
        "steps": record["samples"],
        # Rounding keeps an exact success from being 1.
        "success": 1.0 if record["success"] >= ALWAYS else record["success"],
        "ratio": None if math.isnan(record["ratio"]) else record["ratio"],
    }


if __name__ == "__main__":
    request = json.loads(sys.argv[1])
    # Written by the process that started this one, a moment ago.
    with Path(request.pop("problem")).open("rb") as file:
        search = pickle.load(file)
    train(search, **request, tell=lambda point: print(json.dumps(point), flush=True))
