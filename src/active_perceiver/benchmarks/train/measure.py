"""How fast a policy gets good: this project's learners and stable-baselines3's, on the same search."""

from __future__ import annotations

import json
import os
import pickle
import subprocess
import sys
import tempfile
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import asdict
from pathlib import Path
from typing import Any

from active_perceiver.agent.perceiver import ActivePerceiver
from active_perceiver.benchmarks.config import LearnerName, TrainSpeedConfig
from active_perceiver.benchmarks.outputs import check_outputs, write_outputs
from active_perceiver.benchmarks.train.baselines import BASELINES, FINE_RATIO, RATIO, baseline_named
from active_perceiver.benchmarks.train.report import format_train_speed, learner_summary, trainings_of
from active_perceiver.envs.observations import Observations
from active_perceiver.envs.task import SearchTask
from active_perceiver.errors import UserError
from active_perceiver.evaluation.agent_scenes import features_of
from active_perceiver.evaluation.detections import even_pictures
from active_perceiver.evaluation.evaluate import agent_detections
from active_perceiver.figures.time_to_quality import time_to_quality
from active_perceiver.parallel.run_store import check_resume, kept_runs
from active_perceiver.policies.training_task import TrainingTask
from active_perceiver.scenes import open_scene
from active_perceiver.training.target_selection import check_targets, searched_targets
from active_perceiver.utils.progress import ProgressCallback, progress_bar, quiet
from active_perceiver.utils.result import format_number
from active_perceiver.vision.backbone import load_backbone

TRUTH = "truth"

Run = dict[str, Any]


def train_speed_command(
    settings: TrainSpeedConfig,
    out: Path | None = None,
    picture: Path | None = None,
    *,
    force: bool = False,
    resume: bool = False,
) -> dict[str, Any]:
    """Measure, print a table, write the result and the picture if they are asked for.

    With `out`, finished trainings are kept beside it until all are done, and `resume` goes on after them.

    Returns:
        The body of the result file, see `measure_train_speed`.

    Raises:
        OutputExistsError: if a file exists, or trainings are kept, and neither `force` nor `resume` says what to do.
        UserError: if the settings make no sense, something they name is not there, or a training failed.
    """
    check_outputs(force, out, picture)
    check_settings(settings)
    check_resume(resume, out)
    with kept_runs(out, asdict(settings), force=force, resume=resume) as (done, keep):
        training_task = search_training_task(settings)
        with progress_bar("trainings") as report:
            body = measure_train_speed(settings, training_task, done, keep, report)
        print(format_train_speed(body))
        figure = lambda: time_to_quality(trainings_of(body), RATIO)  # noqa: E731
        write_outputs("benchmark train", body, out, picture, figure)
    return body


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
    done: Sequence[Run] = (),
    keep: Callable[[Run], None] = lambda run: None,
    progress: ProgressCallback = quiet,
) -> dict[str, Any]:
    """Train every learner with every seed, each in a process of its own, one after the other.

    Args:
        settings: who, and for how long.
        training_task: what they learn, see `search_training_task`.
        done: runs that are finished already.
        keep: is called with each run that is finished.
        progress: called with the trainings done and to do, and how good the present one is.

    Returns:
        "protocol"; "learners": for each its summary, see `learner_summary`; "runs": for each training {"learner",
        "seed", "points": its measurements, see `train_process.measured`}.

    Raises:
        UserError: if a training failed.
    """
    threads = settings.threads or os.cpu_count() or 1
    limits = {name: settings.seconds or BASELINES[name].seconds for name in settings.learners}
    runs = {(run["learner"], run["seed"]): run for run in done}
    # Seed by seed, so that a disturbance of the machine meets all learners, and what an interrupted run has is even.
    jobs = [(name, seed) for seed in range(settings.seeds) for name in settings.learners]
    with _problem_file(training_task) as path:
        for number, (name, seed) in enumerate(jobs):
            if (name, seed) in runs:
                continue
            request = {"problem": path, "name": name, "seed": seed, "threads": threads, "seconds": limits[name]}
            points = []
            progress(number, len(jobs), f"{name}, seed {seed}")
            for point in _points(request):
                points.append(point)
                progress(number, len(jobs), f"{name}, seed {seed}: {_words(point)}")
            runs[name, seed] = {"learner": name, "seed": seed, "points": points}
            keep(runs[name, seed])
    progress(len(jobs), len(jobs))
    ordered = [runs[name, seed] for name in settings.learners for seed in range(settings.seeds)]
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


@contextmanager
def _problem_file(training_task: TrainingTask) -> Iterator[str]:
    with tempfile.TemporaryDirectory(prefix="active-perceiver-") as folder:
        path = Path(folder) / "problem"
        path.write_bytes(pickle.dumps(training_task))
        yield str(path)


def _points(request: dict[str, Any]) -> Iterator[dict[str, Any]]:
    """The measurements of a training in a fresh process, as they come.

    Raises:
        UserError: if it failed; what it says last is why.
    """
    threads = str(request["threads"])
    with tempfile.TemporaryFile("w+") as errors, subprocess.Popen(
        [sys.executable, "-m", "active_perceiver.benchmarks.train.worker", json.dumps(request)],
        env={**os.environ, "OMP_NUM_THREADS": threads, "OPENBLAS_NUM_THREADS": threads},
        stdout=subprocess.PIPE, stderr=errors, text=True,
    ) as process:  # fmt: skip
        try:
            assert process.stdout is not None
            for line in process.stdout:
                yield json.loads(line)
            if process.wait() != 0:
                errors.seek(0)
                said = errors.read().strip().splitlines() or [f"exit code {process.returncode}"]
                raise UserError(f"training by {request['name']} failed: {said[-1]}")
        finally:
            # Whatever ends this one early must not leave it running; it has nothing to lose.
            process.terminate()


def _words(point: dict[str, float]) -> str:
    return f"{point['seconds']:.0f} s, success {point['success']:.3f}, {format_number(point['ratio'], '.2f')} x"
