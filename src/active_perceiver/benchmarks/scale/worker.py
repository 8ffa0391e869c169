"""A process of its own that trains one policy on synthetic scenes, and says what it took in time and memory.

Being fresh, its memory is that of this training. Measuring the policy is not part of the training's time.
Run by `measure.py`.
"""

from __future__ import annotations

from typing import Any

from active_perceiver.benchmarks.config import ScaleConfig
from active_perceiver.benchmarks.scale.synthetic_scenes import synthetic_tasks
from active_perceiver.policies.learners import LEARNERS
from active_perceiver.policies.training_task import TrainingTask

CHECK_LIMIT = 1000
"""Steps after which a search has failed."""


def measure_training(settings: ScaleConfig, cell: tuple[str, int, int]) -> dict[str, Any]:
    """Train until the searches are as short as the last of `RATIOS` says, or time is up.

    Args:
        settings: for how long, with how many threads, and which targets.
        cell: a learner, a number of scenes, and the states of each.

    Returns:
        "asked_states"; "learner"; "scenes", "states" of each, "rows": pairs of a state and a target; "data_mib": of
        tables and features; "parameters" of the network; "iterations", "seconds", "cpu_seconds" and
        "seconds_per_iteration" of the training; "parts": seconds in each of `PARTS` and the "rest"; "reached": for
        each of `RATIOS` {"seconds", "cpu_seconds", "iterations", "after_seconds": of the measurement before} or None;
        "success" and "ratio" at the end; "ended" by "quality", "time" or "iterations"; "training_mib": peak memory
        above what there was before, in an iteration, and "peak_mib" with the measurements, None where the system does
        not tell; "measuring_seconds" and "measurements".
    """
    # Inside, because the process that starts this one must not need torch to say what is wrong.
    from active_perceiver.benchmarks.scale.clock import TrainingClock

    learner, scenes, states = cell
    chosen = LEARNERS[learner]
    fixed: dict[str, Any] = {
        "seed": settings.seed,
        "threads": settings.threads,
        "target_ratio": None,
        "patience": None,
        "check_limit": CHECK_LIMIT,
    }
    # What the libraries do once is done here.
    chosen.train(synthetic_tasks(1, 96, 1), chosen.config(**{**fixed, "iterations": 1}))
    training_tasks = synthetic_tasks(scenes, states, settings.targets, settings.seed)
    given = {} if settings.iterations is None else {"iterations": settings.iterations}
    config = chosen.config(**fixed, **given)
    clock = TrainingClock(training_tasks, config, settings.seconds)
    with clock.watching():
        network, _ = chosen.train(training_tasks, config, monitor=clock)
    return {
        "asked_states": states,
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
