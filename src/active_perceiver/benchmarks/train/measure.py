"""How fast a policy gets good: this project's learners and stable-baselines3's, on the same search."""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from matplotlib.figure import Figure

from active_perceiver.agent.perceiver import ActivePerceiver
from active_perceiver.benchmarks.config import LearnerName, TrainSpeedConfig
from active_perceiver.benchmarks.runner import Benchmark, ResultBody
from active_perceiver.benchmarks.train.baselines import BASELINES, FINE_RATIO, RATIO, baseline_named
from active_perceiver.benchmarks.train.report import format_train_speed, learner_summary, trainings_of
from active_perceiver.benchmarks.train.worker import Training, train
from active_perceiver.envs.observations import Observations
from active_perceiver.envs.task import SearchTask
from active_perceiver.errors import UserError
from active_perceiver.evaluation.agent_scenes import features_of
from active_perceiver.evaluation.detections import even_pictures
from active_perceiver.evaluation.object_measures import agent_detections
from active_perceiver.figures.time_to_quality import time_to_quality
from active_perceiver.parallel.executor import Executor
from active_perceiver.parallel.fresh_process import FreshProcessExecutor
from active_perceiver.parallel.run_missing import records_of
from active_perceiver.parallel.run_store import RunStore
from active_perceiver.policies.training_task import TrainingTask
from active_perceiver.scenes import open_scene
from active_perceiver.training.target_selection import check_targets, searched_targets
from active_perceiver.utils.progress import ProgressCallback, progress_bar, quiet
from active_perceiver.vision.backbone import load_backbone

TRUTH = "truth"


@dataclass
class TrainBenchmark(Benchmark):
    """How long learners take to a good policy."""

    name = "train"
    settings: TrainSpeedConfig
    executor: Executor | None = None

    def prepare(self) -> Mapping[str, Any]:
        """See `Benchmark`."""
        check_settings(self.settings)
        return asdict(self.settings)

    def measure(self, store: RunStore) -> ResultBody:
        """See `measure_train_speed`."""
        training_task = search_training_task(self.settings)
        executor = self.executor or FreshProcessExecutor(threads_of(self.settings))
        with progress_bar("trainings") as report:
            return measure_train_speed(self.settings, training_task, store, executor, report)

    def report(self, body: ResultBody) -> str:
        """See `format_train_speed`."""
        return format_train_speed(body)

    def figure(self, body: ResultBody) -> Figure:
        """Time to quality by learner."""
        return time_to_quality(trainings_of(body), RATIO)


def threads_of(settings: TrainSpeedConfig) -> int:
    """CPU threads of each training."""
    return settings.threads or os.cpu_count() or 1


def check_settings(settings: TrainSpeedConfig) -> None:
    """Make sure that settings make sense, before anything is made or measured.

    Raises:
        UserError: if they do not; the message says why.
    """
    if not settings.learners or len(set(settings.learners)) != len(settings.learners):
        raise UserError(f"name each learner once, at least one; got {list(settings.learners)}")
    for name in settings.learners:
        baseline_named(name)
    if settings.seeds < 1 or (settings.threads is not None and settings.threads < 1):
        raise UserError(f"seeds and threads must be at least 1, got {settings.seeds} and {settings.threads}")
    if settings.seconds is not None and not settings.seconds > 0:
        raise UserError(f"a training needs some seconds, got {settings.seconds}")


def search_training_task(settings: TrainSpeedConfig) -> TrainingTask:
    """What all learners learn: the search, with the pictures that may be trained with.

    Raises:
        UserError: if the scene, a target or the agent is not there, or they do not go together.
    """
    scene = open_scene(settings.scene)
    check_targets([scene], settings.targets)
    names = searched_targets(scene, settings.targets)
    task = SearchTask.from_scene(scene, names)
    if settings.boxes == TRUTH:
        index = [scene.target_index(name) for name in names]
        features = features_of(scene, load_backbone(settings.backbone, image_size=settings.image_size))
        pictures, trained = even_pictures([scene.targets[number] for number in index])
        shown = features.target_features[[[number] for number in index], pictures[:, :trained]]
        return TrainingTask(task, Observations.from_boxes(features.view_features, shown, scene.boxes[:, index]))
    agent = ActivePerceiver.from_pretrained(settings.boxes)
    for seen in agent_detections(agent):
        if seen.scene.name == scene.name and seen.names == names:
            return TrainingTask(task, seen.observations(agent.recogniser.threshold, seen.trained_pictures))
    raise UserError(
        f"the agent {settings.boxes} was not trained to search {scene.name} for {', '.join(names)}; name its targets "
        "with --targets, in its order, or use --boxes truth"
    )


def measure_train_speed(
    settings: TrainSpeedConfig,
    training_task: TrainingTask,
    store: RunStore,
    executor: Executor,
    progress: ProgressCallback = quiet,
) -> ResultBody:
    """Train every learner with every seed, one after the other.

    Args:
        settings: who, and for how long.
        training_task: what they learn, see `search_training_task`.
        store: keeps the runs.
        executor: gives each training a process of its own.
        progress: called with the trainings done and to do, and how good the present one is.

    Returns:
        "protocol"; "learners": for each its summary, see `learner_summary`; "runs": for each training what
        `worker.train` gives.
    """
    threads = threads_of(settings)
    limits = {name: settings.seconds or BASELINES[name].seconds for name in settings.learners}
    # Seed by seed, so that a disturbance of the machine meets all learners, and what an interrupted run has is even.
    items = {
        f"{name}, seed {seed}": Training(name, seed, threads, limits[name])
        for seed in range(settings.seeds)
        for name in settings.learners
    }
    runs = records_of(executor, store, train, items, training_task, progress)
    ordered = [runs[f"{name}, seed {seed}"] for name in settings.learners for seed in range(settings.seeds)]
    return {
        "protocol": _protocol(settings, training_task, threads, limits),
        "learners": [
            {"learner": name, **learner_summary([run["points"] for run in ordered if run["learner"] == name])}
            for name in settings.learners
        ],
        "runs": ordered,
    }


def _protocol(
    settings: TrainSpeedConfig, training_task: TrainingTask, threads: int, limits: Mapping[LearnerName, float]
) -> dict[str, Any]:
    configs = {name: asdict(BASELINES[name].config) for name in settings.learners}
    filled_in = ("seed", "threads", "seconds", "patience")
    return {
        "scene": training_task.task.scene,
        "states": len(training_task.task),
        "targets": list(training_task.task.targets),
        "pictures": training_task.observations.pictures,
        "features": training_task.observations.view_features.shape[1],
        "boxes": "ground truth" if settings.boxes == TRUTH else f"recogniser of {Path(settings.boxes).name}",
        "seeds": settings.seeds,
        "threads": threads,
        "ratio": RATIO,
        "fine_ratio": FINE_RATIO,
        "clock": "training without measurements, after one iteration that does not count; a3c: whole",
        "seconds": limits,
        "takes_steps": {name: BASELINES[name].acts for name in settings.learners},
        "settings": {
            name: {key: value for key, value in config.items() if key not in filled_in}
            for name, config in configs.items()
        },
    }
