"""One training of a policy in a process of its own, timed, and measured exactly; see `measure.py`."""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

from active_perceiver.evaluation.config import EvaluateConfig
from active_perceiver.evaluation.policy_metrics import evaluate_tables
from active_perceiver.policies.config import LearnerConfig
from active_perceiver.policies.evaluation import Evaluation
from active_perceiver.policies.learners import LEARNERS
from active_perceiver.policies.training_task import TrainingTask

FINE_RATIO = 1.02
"""Mean steps over the fewest possible; how long it takes to get there is measured too."""


@dataclass(frozen=True, eq=False)
class PolicyTraining:
    """A training to do.

    Attributes:
        setup: its name.
        training_tasks: what is trained on, one for each scene.
        unseen: the same searches, with pictures that training never sees; none if the scenes hold none out.
        learner: a name in `LEARNERS`.
        config: its settings.
    """

    setup: str
    training_tasks: Sequence[TrainingTask]
    unseen: Sequence[TrainingTask]
    learner: str
    config: LearnerConfig


def train_and_measure(limit: int, training: PolicyTraining) -> dict[str, Any]:
    """Train a policy and measure it over all starts.

    What happens once in a process, such as loading what the first step of an optimiser needs, is not the training's:
    a training of one iteration comes before the one that is timed.

    Args:
        limit: actions after which a search has failed.
        training: what is trained, and how.

    Returns:
        "setup", "learner" and "seed"; "seconds" and "cpu_seconds" of the training, "measuring_seconds": how many of
        the seconds its own measurements took; "iterations"; "seconds_to_fine_ratio": until it first measured
        `FINE_RATIO` and success, None if it never did; "arrives": whether every search does, up to rounding;
        "success", "mean_steps", "shortest_mean", "ratio" and "spl" over all starts and pictures trained with;
        "per_target": the same of each; "unseen_pictures": "success", "ratio" and "spl" with those, None if there are
        none.
    """
    # Inside, because the process that starts this one must not need torch to say what is wrong.
    from active_perceiver.policies.monitor import ALWAYS

    training_tasks, unseen, config = training.training_tasks, training.unseen, training.config
    train = LEARNERS[training.learner].train
    train(training_tasks, replace(config, iterations=1))
    started, cpu_started = time.perf_counter(), time.process_time()
    network, history = train(training_tasks, config)
    seconds, cpu_seconds = time.perf_counter() - started, time.process_time() - cpu_started
    seen = _evaluation(network, training_tasks, limit).as_dict()
    overall = {key: value for key, value in seen["overall"].items() if key not in ("scene", "target")}
    fine = (r["seconds"] for r in history if r["success"] >= ALWAYS and r["ratio"] <= FINE_RATIO)
    apart = _evaluation(network, unseen, limit).as_dict()["overall"] if unseen else None
    return {
        "setup": training.setup,
        "learner": training.learner,
        "seed": config.seed,
        "seconds": seconds,
        "cpu_seconds": cpu_seconds,
        "measuring_seconds": history[-1]["measuring"],
        "iterations": int(history[-1]["iteration"]),
        "seconds_to_fine_ratio": next(fine, None),
        "arrives": overall["success"] >= ALWAYS,
        **overall,
        "per_target": seen["per_target"],
        "unseen_pictures": apart and {name: apart[name] for name in ("success", "ratio", "spl")},
    }


def _evaluation(network: Any, training_tasks: Sequence[TrainingTask], limit: int) -> Evaluation:
    """Over all starts, with each picture in turn."""
    from active_perceiver.policies.network import task_table

    searches = [
        (
            training_task.task,
            [task_table(network, training_task, k)[0] for k in range(training_task.observations.pictures)],
        )
        for training_task in training_tasks
    ]
    return evaluate_tables(searches, EvaluateConfig(limit=limit))
