"""What training a policy costs in time and memory, as scenes get more and larger; the scenes are synthetic."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from collections.abc import Callable, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

from active_perceiver.benchmarks.config import ScaleConfig
from active_perceiver.benchmarks.outputs import check_outputs, write_outputs
from active_perceiver.benchmarks.scale.report import cost_curves, format_scale
from active_perceiver.benchmarks.scale.synthetic_scenes import FEATURES, PICTURES, VIEWS_PER_PLACE, synthetic_tasks
from active_perceiver.benchmarks.scale.worker import CHECK_LIMIT, RATIOS
from active_perceiver.errors import UserError
from active_perceiver.figures.scaling import scaling_figure
from active_perceiver.parallel.run_store import check_resume, kept_runs
from active_perceiver.policies.learners import LEARNERS, learner_named
from active_perceiver.utils.progress import ProgressCallback, progress_bar, quiet

Run = dict[str, Any]
Cell = tuple[str, int, int]
"""A learner, a number of scenes, and the states that each was asked to have."""


def scale_command(
    settings: ScaleConfig,
    out: Path | None = None,
    picture: Path | None = None,
    *,
    force: bool = False,
    resume: bool = False,
) -> dict[str, Any]:
    """Measure, print tables, write the result and the picture if they are asked for.

    With `out`, finished trainings are kept beside it until all are done, and `resume` goes on after them.

    Returns:
        The body of the result file, see `measure_scale`.

    Raises:
        OutputExistsError: if a file exists, or trainings are kept, and neither `force` nor `resume` says what to do.
        UserError: if the settings make no sense, or a training failed.
    """
    check_outputs(force, out, picture)
    check_settings(settings)
    check_resume(resume, out)
    with kept_runs(out, asdict(settings), force=force, resume=resume) as (done, keep):
        with progress_bar("trainings") as report:
            body = measure_scale(settings, done, keep, report)
        print(format_scale(body))
        write_outputs("benchmark scale", body, out, picture, lambda: scaling_figure(*cost_curves(body)))
    return body


def check_settings(settings: ScaleConfig) -> None:
    """Make sure that settings make sense, before anything is measured.

    Raises:
        UserError: if they do not; the message says why.
    """
    for label in ("scenes", "states", "learners"):
        values: tuple[Any, ...] = getattr(settings, label)
        if not values or len(set(values)) != len(values):
            raise UserError(f"name each of the {label} once, at least one; got {list(values)}")
    for name in settings.learners:
        learner_named(name)
    numbers = (*settings.scenes, settings.targets, settings.threads, settings.most_states)
    if min(numbers) < 1 or (settings.iterations is not None and settings.iterations < 1):
        raise UserError("numbers of scenes, states, targets, threads and iterations must be at least 1")
    if not settings.seconds > 0:
        raise UserError(f"a training needs some seconds, got {settings.seconds}")
    if not cells_of(settings):
        raise UserError(f"no scenes have at most {settings.most_states} states together; allow more --most-states")
    # Whether the targets fit shows in the smallest scenes.
    synthetic_tasks(1, min(settings.states), settings.targets, settings.seed)


def cells_of(settings: ScaleConfig) -> list[Cell]:
    """What is trained: small scenes first, since they are done soon."""
    return [
        (learner, scenes, states)
        for states in settings.states
        for scenes in settings.scenes
        if scenes * states <= settings.most_states
        for learner in settings.learners
    ]


def measure_scale(
    settings: ScaleConfig,
    done: Sequence[Run] = (),
    keep: Callable[[Run], None] = lambda run: None,
    progress: ProgressCallback = quiet,
) -> dict[str, Any]:
    """Train in every combination of scenes and states, each in a process of its own, one after the other.

    Args:
        settings: how many, how large, who, and for how long.
        done: runs that are finished already.
        keep: is called with each run that is finished.
        progress: called with the trainings done and to do.

    Returns:
        "protocol"; "runs": for each training what `scale_process.measure_training` says, and "asked_states".

    Raises:
        UserError: if a training failed.
    """
    runs: dict[Cell, Run] = {(run["learner"], run["scenes"], run["asked_states"]): run for run in done}
    cells = cells_of(settings)
    for number, cell in enumerate(cells):
        if cell not in runs:
            learner, scenes, states = cell
            progress(number, len(cells), f"{learner}, {scenes} x {states}")
            runs[cell] = {"asked_states": states, **_train(settings, cell)}
            keep(runs[cell])
    progress(len(cells), len(cells))
    protocol = {
        **asdict(settings),
        "views_per_place": VIEWS_PER_PLACE,
        "features": FEATURES,
        "pictures": PICTURES,
        "boxes": "ground truth",
        "ratios": RATIOS,
        "check_limit": CHECK_LIMIT,
        "clock": "training without measurements, after one iteration in another scene that does not count",
        "settings": {name: asdict(LEARNERS[name].config()) for name in settings.learners},
    }
    return {"protocol": protocol, "runs": [runs[cell] for cell in cells]}


def _train(settings: ScaleConfig, cell: Cell) -> Run:
    """What a fresh process prints; see `worker.py`.

    Raises:
        UserError: if it failed; what it says last is why.
    """
    learner, scenes, states = cell
    request = {
        "learner": learner,
        "scenes": scenes,
        "states": states,
        "targets": settings.targets,
        "seconds": settings.seconds,
        "iterations": settings.iterations,
        "threads": settings.threads,
        "seed": settings.seed,
    }
    threads = str(settings.threads)
    done = subprocess.run(
        [sys.executable, "-m", "active_perceiver.benchmarks.scale.worker", json.dumps(request)],
        env={**os.environ, "OMP_NUM_THREADS": threads, "OPENBLAS_NUM_THREADS": threads},
        capture_output=True, text=True, check=False,
    )  # fmt: skip
    if done.returncode != 0:
        said = done.stderr.strip().splitlines() or [f"exit code {done.returncode}"]
        raise UserError(f"training by {learner} in {scenes} scenes of {states} states failed: {said[-1]}")
    return json.loads(done.stdout)
