"""`benchmark scale` as a user runs it, tiny, and the synthetic scenes it trains in."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image

from active_perceiver.benchmarks.config import ScaleConfig
from active_perceiver.benchmarks.runner import OutputFiles, run_benchmark
from active_perceiver.benchmarks.scale.clock import PARTS, RATIOS, TrainingClock
from active_perceiver.benchmarks.scale.measure import ScaleBenchmark
from active_perceiver.benchmarks.scale.synthetic_scenes import (
    FEATURES,
    PICTURES,
    VIEWS_PER_PLACE,
    free_cells,
    synthetic_tasks,
)
from active_perceiver.benchmarks.scale.worker import data_bytes, measure_training
from active_perceiver.cli.main import main
from active_perceiver.errors import UserError
from active_perceiver.parallel.fresh_process import FreshProcessExecutor
from active_perceiver.policies.learners import LEARNERS
from active_perceiver.policies.training_task import TrainingTask
from active_perceiver.scenes import Action
from active_perceiver.utils.result import to_jsonable
from helpers.interrupted import InterruptedExecutor

OPPOSITE = {
    Action.MOVE_AHEAD: Action.MOVE_BACK,
    Action.MOVE_LEFT: Action.MOVE_RIGHT,
    Action.ROTATE_LEFT: Action.ROTATE_RIGHT,
    Action.LOOK_UP: Action.LOOK_DOWN,
}
TINY = ["--states", "48", "--targets", "2", "--learners", "distil", "--iterations", "2"]


def column(training_task: TrainingTask, action: Action) -> int:
    return training_task.task.actions.index(action.value)


@pytest.mark.parametrize(("states", "targets"), [(48, 2), (200, 4), (1000, 6)])
@pytest.mark.parametrize("seed", [0, 1])
def test_a_synthetic_scene_is_sound(states: int, targets: int, seed: int) -> None:
    for training_task in synthetic_tasks(2, states, targets, seed):
        task, seen = training_task.task, training_task.observations
        assert len(task) == round(states / VIEWS_PER_PLACE) * VIEWS_PER_PLACE
        assert (task.steps >= 0).all()  # from everywhere a way leads to every target
        every = np.arange(len(task))
        for there, back in OPPOSITE.items():
            moved = task.transitions[:, column(training_task, there)]
            goes = moved != every
            assert (task.transitions[moved[goes], column(training_task, back)] == every[goes]).all()
        assert seen.view_features.shape == (len(task), FEATURES)
        assert seen.target_features.shape == (targets, PICTURES, FEATURES)
        assert len(np.unique(seen.view_features, axis=0)) == len(task)
        visible = task.areas > 0
        assert (seen.masks.any(axis=-1) == visible[:, :, None]).all()
        assert 0 < visible.mean() < 0.5
        assert task.areas.max() < 1


def test_boxes_grow_as_one_comes_nearer() -> None:
    compared = 0
    for training_task in synthetic_tasks(3, 1000, 4):
        areas = training_task.task.areas
        ahead = training_task.task.transitions[:, column(training_task, Action.MOVE_AHEAD)]
        moved = ahead != np.arange(len(areas))
        before, after = areas[moved], areas[ahead[moved]]
        both = (before > 0) & (after > 0)
        assert (after[both] > before[both]).all()
        compared += both.sum()
    assert compared > 50


def test_features_are_smooth_and_other_in_every_scene() -> None:
    first, second = (training_task.observations.view_features for training_task in synthetic_tasks(2, 1000, 2))
    task = synthetic_tasks(1, 1000, 2)[0].task
    ahead = task.transitions[:, task.actions.index("MoveAhead")]
    goes = ahead != np.arange(len(ahead))
    near = np.linalg.norm(first[goes] - first[ahead[goes]], axis=1).mean()
    far = np.linalg.norm(first - np.roll(first, len(first) // 2, axis=0), axis=1).mean()
    assert near < 0.8 * far
    assert np.linalg.norm(first - second, axis=1).mean() > near


def test_a_seed_gives_the_same_scenes_however_many_they_are() -> None:
    (alone,), (first, second) = synthetic_tasks(1, 96, 2, seed=3), synthetic_tasks(2, 96, 2, seed=3)
    other = synthetic_tasks(1, 96, 2, seed=4)[0]
    assert (alone.observations.view_features == first.observations.view_features).all()
    assert (alone.task.areas == first.task.areas).all()
    for different in (second, other):
        assert (alone.observations.view_features != different.observations.view_features).any()


@pytest.mark.parametrize("places", [2, 17, 150])
def test_halls_have_obstacles_and_connected_places(places: int) -> None:
    free = free_cells(places, np.random.default_rng(places))
    assert free.sum() == places
    assert free[1:-1, 1:-1].sum() == places  # none on the rim
    cells = {tuple(cell) for cell in np.argwhere(free).tolist()}
    todo = [next(iter(cells))]
    while todo:
        x, z = todo.pop()
        cells.discard((x, z))
        todo += [near for near in ((x + 1, z), (x - 1, z), (x, z + 1), (x, z - 1)) if near in cells]
    assert not cells


def test_impossible_scenes_are_refused() -> None:
    for scenes, states, targets in ((0, 48, 1), (1, 48, 0), (1, 12, 1), (1, 24, 40)):
        with pytest.raises(UserError, match=r"do not fit|at least one"):
            synthetic_tasks(scenes, states, targets)


@pytest.mark.parametrize("learner", ["distil", "mirror-descent", "ppo"])
def test_the_clock_changes_nothing_but_when_it_is_measured(learner: str) -> None:
    training_tasks = synthetic_tasks(2, 96, 2)
    config = LEARNERS[learner].config(iterations=3, hidden=32, target_ratio=None)
    plain, history = LEARNERS[learner].train(training_tasks, config)
    clock = TrainingClock(training_tasks, config, 60.0)
    with clock.watching():
        watched, _ = LEARNERS[learner].train(training_tasks, config, monitor=clock)
    result = clock.result()
    assert result["iterations"] <= 3
    assert result["ended"] == ("iterations" if result["reached"]["1.02"] is None else "quality")
    if result["ended"] == "iterations":
        assert result["ratio"] == pytest.approx(history[-1]["ratio"])
        for one, other in zip(plain.parameters(), watched.parameters(), strict=True):
            assert (one == other).all()
    assert 0 < sum(result["parts"][part] for part in PARTS) < result["seconds"]
    assert sum(result["parts"].values()) == pytest.approx(result["seconds"])
    assert (result["parts"]["advantages"] > 0) == (learner == "mirror-descent")
    assert (result["parts"]["rollouts"] > 0) == (learner == "ppo")


def test_the_clock_ends_a_training_when_time_is_up() -> None:
    training_tasks = synthetic_tasks(1, 96, 2)
    config = LEARNERS["ppo"].config(iterations=50, hidden=8)
    clock = TrainingClock(training_tasks, config, 1e-6)
    with clock.watching():
        LEARNERS["ppo"].train(training_tasks, config, monitor=clock)
    result = clock.result()
    assert (result["ended"], result["iterations"], result["measurements"]) == ("time", 1, 1)
    assert result["reached"] == {"1.25": None, "1.02": None}


def check_run(run: dict[str, Any], scenes: int) -> None:
    assert (run["learner"], run["scenes"], run["states"], run["rows"]) == ("distil", scenes, 48, scenes * 48 * 2)
    assert run["iterations"] <= 2
    assert run["seconds_per_iteration"] == pytest.approx(run["seconds"] / run["iterations"], rel=1e-3)
    assert set(run["parts"]) == {*PARTS, "rest"}
    assert set(run["reached"]) == {f"{ratio:g}" for ratio in RATIOS}
    expected = sum(map(data_bytes, synthetic_tasks(scenes, 48, 2))) / 2**20
    assert run["data_mib"] == pytest.approx(expected, rel=1e-3)
    assert run["parameters"] > 1e6
    if run["training_mib"] is not None:
        # Weights, gradients and Adam's two means at least, but not the libraries.
        assert 4 * 4 * run["parameters"] / 2**20 < run["training_mib"] <= run["peak_mib"] < 200


def test_it_measures_and_goes_on_where_it_was_interrupted(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    out, picture = tmp_path / "scale.json", tmp_path / "scale.png"
    arguments = ["benchmark", "scale", *TINY, "--scenes", "1", "2", "--out", str(out), "--picture", str(picture)]
    settings = ScaleConfig((1, 2), (48,), learners=("distil",), targets=2, iterations=2)
    executor = InterruptedExecutor(FreshProcessExecutor(), 2)
    with pytest.raises(KeyboardInterrupt):
        run_benchmark(ScaleBenchmark(settings, executor), OutputFiles(out, picture))
    assert executor.done == [("distil", 1, 48)]
    assert not out.exists()
    kept = tmp_path / "scale.json.part" / "distil, 1 x 48.json"
    before = kept.stat().st_mtime_ns
    assert main(arguments) == 2
    assert "--resume goes on" in capsys.readouterr().err.replace("\n", " ")
    assert kept.stat().st_mtime_ns == before
    first = json.loads(kept.read_text())
    assert main([*arguments, "--resume"]) == 0
    result = json.loads(out.read_text())
    assert result["runs"][0] == to_jsonable(first)
    assert result["command"] == "benchmark scale"
    assert result["protocol"]["states"] == [48]
    assert result["protocol"]["settings"]["distil"]["batch_states"] > 0
    for run, scenes in zip(result["runs"], (1, 2), strict=True):
        check_run(run, scenes)
    text = capsys.readouterr().out
    assert "s/iteration" in text
    assert "where the time" in text
    assert Image.open(picture).format == "PNG"
    assert sorted(tmp_path.iterdir()) == [out, picture]


def test_a_process_that_fails_says_why(tmp_path: Path) -> None:
    with pytest.raises(UserError, match="at least one scene"):
        list(FreshProcessExecutor().map(measure_training, [("distil", 0, 48)], ScaleConfig()))


def test_help_has_examples(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as stopped:
        main(["benchmark", "scale", "--help"])
    assert stopped.value.code == 0
    assert "active-perceiver benchmark scale" in capsys.readouterr().out.split("Examples:")[1]


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--scenes", "0"], "must be at least 1"),
        (["--scenes", "1", "1"], "name each of the scenes once"),
        (["--iterations", "0"], "must be at least 1"),
        (["--seconds", "0"], "needs some seconds"),
        (["--states", "1000", "--most-states", "500"], "allow more --most-states"),
        (["--states", "24", "--targets", "50"], "do not fit"),
        (["--resume"], "name it with --out"),
    ],
)
def test_wrong_input_is_explained(arguments: list[str], message: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["benchmark", "scale", *arguments]) == 2
    error = capsys.readouterr().err.replace("\n", " ")
    assert message in error
    assert "Traceback" not in error


@pytest.mark.parametrize("option", ["--out", "--picture"])
def test_what_is_there_is_not_overwritten(option: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "precious"
    path.write_text("precious")
    assert main(["benchmark", "scale", option, str(path)]) == 2
    assert "--force" in capsys.readouterr().err
    assert path.read_text() == "precious"
