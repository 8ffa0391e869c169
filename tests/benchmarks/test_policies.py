"""`benchmark policies`: as a user runs it, tiny; its figures are those of the training it runs, and it goes on."""

from __future__ import annotations

import dataclasses
import json
import math
import os
import shutil
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image

from active_perceiver.agent.perceiver import ActivePerceiver
from active_perceiver.benchmarks.config import PolicyBenchmarkConfig
from active_perceiver.benchmarks.policies import measure as policies
from active_perceiver.benchmarks.policies.measure import PoliciesBenchmark
from active_perceiver.benchmarks.policies.report import format_policies, spread_rows, summary
from active_perceiver.benchmarks.policies.worker import PolicyTraining, train_and_measure
from active_perceiver.benchmarks.runner import OutputFiles, run_benchmark
from active_perceiver.cli.main import main
from active_perceiver.envs.task import SearchTask
from active_perceiver.errors import UserError
from active_perceiver.evaluation.object_measures import agent_detections
from active_perceiver.parallel.executor import SerialExecutor
from active_perceiver.policies.config import DistilConfig
from active_perceiver.policies.evaluation import exact_evaluation
from active_perceiver.policies.learners import LEARNERS
from active_perceiver.policies.training_task import TrainingTask
from active_perceiver.scenes import Scene, save_scene
from active_perceiver.training.policy_augmentation import changed_observations
from active_perceiver.utils.files import OutputExistsError
from helpers.interrupted import InterruptedExecutor
from helpers.toy import toy_scene

ABOUT = {"setup": "kitchen", "ratio_limit": 1.02, "seconds_limit": 15.0}


def train_here(setup: policies.PolicySetup, learner: str, config: Any, limit: int) -> dict[str, Any]:
    """What a fresh process gives, without its two seconds."""
    training = PolicyTraining(setup.name, setup.training_tasks, setup.unseen, learner, config)
    return train_and_measure(limit, training)


def run(seed: int, **changes: Any) -> dict[str, Any]:
    target = {"scene": "kitchen", "target": "mug", "success": 1.0, "ratio": 1.01 + seed / 100}
    return {
        "setup": "kitchen", "learner": "distil", "seed": seed, "seconds": 4.0 + seed, "cpu_seconds": 3.0 + seed,
        "iterations": 10, "seconds_to_fine_ratio": 2.0, "arrives": True, "success": 1.0, "ratio": 1.01, "spl": 0.99,
        "unseen_pictures": {"success": 1.0, "ratio": 1.1 + seed, "spl": 0.9}, "per_target": [target], **changes,
    }  # fmt: skip


def test_help_has_examples(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as stopped:
        main(["benchmark", "policies", "--help"])
    assert stopped.value.code == 0
    assert "active-perceiver benchmark policies" in capsys.readouterr().out.split("Examples:")[1]


def test_a_run_in_fresh_processes(
    agent_folder: Path, scene: Scene, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out, picture = tmp_path / "p.json", tmp_path / "p.png"
    arguments = ["benchmark", "policies", str(agent_folder), "--learners", "distil", "--seeds", "1"]
    before = dict(os.environ)
    assert main([*arguments, "--iterations", "3", "--out", str(out), "--picture", str(picture)]) == 0
    assert dict(os.environ) == before
    result = json.loads(out.read_text())
    assert result["command"] == "benchmark policies"
    assert result["protocol"]["settings"]["distil"]["iterations"] == 3
    (about,) = result["setups"]
    assert (about["setup"], about["states"], about["unseen_pictures"]) == ("toy_0", [len(scene)], 2)
    (only,) = result["runs"]
    assert only["seconds_to_fine_ratio"] is None or 0 < only["seconds_to_fine_ratio"] <= only["seconds"]
    assert 0 < only["measuring_seconds"] < only["seconds"]
    assert 1 <= only["iterations"] <= 3
    assert 0 < only["unseen_pictures"]["success"] <= 1
    assert {result["target"] for result in only["per_target"]} == set(scene.target_names)
    assert format_policies(result) in capsys.readouterr().out  # the table says what the file does
    assert Image.open(picture).format == "PNG"
    assert [path.name for path in tmp_path.iterdir() if path.suffix == ".part"] == []


def test_the_problem_is_the_one_that_training_has_and_the_figures_are_plain_ones(agent_folder: Path) -> None:
    (setup,) = policies.open_setups([agent_folder])
    agent = ActivePerceiver.from_pretrained(agent_folder)
    (seen,) = agent_detections(agent)
    task = SearchTask.from_scene(seen.scene, seen.names)
    threshold, copies = agent.recogniser.threshold, agent.config.training.view_augmentation
    degrees = agent.config.training.viewpoint_jitter_degrees
    changed = changed_observations(seen, agent.backbone, agent.recogniser, threshold, copies, degrees, 0)
    trained = TrainingTask(task, seen.observations(threshold, seen.trained_pictures), changed)
    (training_task,) = setup.training_tasks
    for name in ("view_features", "target_features", "masks"):
        np.testing.assert_array_equal(getattr(training_task.observations, name), getattr(trained.observations, name))
    # The scene's own boxes are larger or elsewhere: what the policy is shown is not the truth.
    assert not np.array_equal(training_task.observations.masks.any(axis=-1)[:, :, 0], task.areas > 0)
    config = DistilConfig(iterations=4, seed=3)
    measured = train_here(setup, "distil", config, 500)

    from active_perceiver.policies.network import task_table

    network, history = LEARNERS["distil"].train([trained], config)
    pictures = range(trained.observations.pictures)
    each = [exact_evaluation(task_table(network, trained, k)[0], task, 500) for k in pictures]
    steps = sum(one.overall.mean_steps * one.overall.success for one in each)
    fewest = sum(one.overall.shortest_mean * one.overall.success for one in each)
    assert measured["ratio"] == pytest.approx(steps / fewest, rel=1e-5)
    assert measured["success"] == pytest.approx(np.mean([one.overall.success for one in each]))
    assert measured["iterations"] == history[-1]["iteration"]


def test_a_policy_of_several_scenes_has_other_limits(agent_folder: Path) -> None:
    (one,) = policies.open_setups([agent_folder])
    (training_task,) = one.training_tasks
    other = TrainingTask(dataclasses.replace(training_task.task, scene="toy_1"), training_task.observations)
    both = dataclasses.replace(one, training_tasks=(training_task, other), unseen=())
    about = both.described()
    assert (both.name, one.name) == ("2 scenes", "toy_0")
    assert about["targets"] == [f"{scene}/ball{k}" for scene in ("toy_0", "toy_1") for k in range(3)]
    assert (about["ratio_limit"], about["seconds_limit"]) == policies.MANY_SCENES
    assert (one.described()["ratio_limit"], one.described()["seconds_limit"]) == policies.ONE_SCENE
    measured = train_here(both, "distil", DistilConfig(iterations=1), 200)
    assert [result["scene"] for result in measured["per_target"]] == ["toy_0"] * 3 + ["toy_1"] * 3
    assert measured["unseen_pictures"] is None


def test_an_interrupted_run_goes_on(agent_folder: Path, tmp_path: Path) -> None:
    files = OutputFiles(tmp_path / "p.json")
    resumed = dataclasses.replace(files, resume=True)
    settings = PolicyBenchmarkConfig(("distil",), 2, iterations=2)
    first, second = (InterruptedExecutor(SerialExecutor(), at) for at in (2, 0))
    with pytest.raises(KeyboardInterrupt):
        run_benchmark(PoliciesBenchmark([agent_folder], settings, first), files)
    with pytest.raises(OutputExistsError, match="--resume"):
        run_benchmark(PoliciesBenchmark([agent_folder], settings, second), files)
    with pytest.raises(UserError, match="learners, iterations"):
        run_benchmark(PoliciesBenchmark([agent_folder], dataclasses.replace(settings, iterations=3), second), resumed)
    body = run_benchmark(PoliciesBenchmark([agent_folder], settings, second), resumed)
    assert [[one.config.seed for one in some.done] for some in (first, second)] == [[0], [1]]
    assert [one["seed"] for one in body["runs"]] == [0, 1]
    assert json.loads(files.out.read_text())["runs"] == body["runs"]


@pytest.mark.parametrize(
    ("changes", "kept"),
    [
        ({}, True),
        ({"ratio": 1.03}, False),
        ({"seconds": 15.1}, False),
        ({"arrives": False, "success": 0.9999}, False),
        ({"arrives": False, "success": 0.0, "ratio": None}, False),
    ],
)
def test_one_seed_that_breaks_a_limit_breaks_it(changes: dict[str, Any], kept: bool) -> None:
    row = summary(ABOUT, "distil", [run(0), run(1, **changes), run(2)])
    assert row["kept"] is kept
    assert row["success"] == changes.get("success", 1.0)
    assert row["ratio"] == {"median": 1.01, "worst": changes.get("ratio", 1.01)}
    assert row["seconds"]["worst"] == max(6.0, changes.get("seconds", 0))
    assert row["unseen_pictures"] == {"success": 1.0, "ratio": 3.1}


def test_what_never_happens_has_no_figure_and_the_missed_target_is_the_worst() -> None:
    missed = {"scene": "kitchen", "target": "bread", "success": 0.9, "ratio": 1.001}
    never = run(1, seconds_to_fine_ratio=None, unseen_pictures=None)
    never["per_target"] = [*never["per_target"], missed]
    row = summary(ABOUT, "distil", [run(0), never])
    assert row["seconds_to_fine_ratio"] is None
    assert row["unseen_pictures"] is None
    assert row["worst_target"] == {"target": "kitchen/bread", "success": 0.9, "ratio": 1.001, "seed": 1}
    assert summary(ABOUT, "distil", [run(0), run(2)])["worst_target"]["seed"] == 2
    body = {
        "protocol": {"seeds": 2, "threads": 1, "fine_ratio": 1.02, "settings": {"distil": {}}},
        "setups": [{**ABOUT, "scenes": ["kitchen"]}],
        "summary": [row],
        "runs": [run(0), never],
    }
    text = format_policies(body)
    assert "bread 1.001" in text
    assert math.isclose(spread_rows(body)[0].dots["distil"][1].seconds, 5.0)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"seeds": 0}, "at least 1"),
        ({"limit": 0}, "at least 1"),
        ({"threads": 0}, "at least 1"),
        ({"learners": ()}, "at least one"),
        ({"learners": ("ppo", "ppo")}, "each learner once"),
        ({"learners": ("guessing",)}, "no learner 'guessing'"),
        ({"iterations": 0}, "at least 1"),
    ],
)
def test_wrong_settings_are_refused(change: dict[str, Any], message: str, agent_folder: Path) -> None:
    with pytest.raises(UserError, match=message):
        PoliciesBenchmark([agent_folder], PolicyBenchmarkConfig(**change)).prepare()


def test_agents_and_scenes_must_go_together(agent_folder: Path, tmp_path: Path) -> None:
    for folders, scenes, message in (
        ([], (), "at least one agent"),
        ([tmp_path / "nowhere"], (), "is not an agent"),
        ([agent_folder, agent_folder], (), "agent of its own"),
        ([agent_folder], ("kitchen_1",), "no agent was trained in kitchen_1"),
    ):
        with pytest.raises(UserError, match=message):
            policies.open_setups(folders, scenes)
    with pytest.raises(UserError, match="--out"):
        run_benchmark(PoliciesBenchmark([agent_folder], PolicyBenchmarkConfig()), OutputFiles(resume=True))


def test_a_scene_that_was_moved_can_be_named(agent_folder: Path, scene: Scene, tmp_path: Path) -> None:
    moved = tmp_path / "agent"
    shutil.copytree(agent_folder, moved)
    config = json.loads((moved / "config.json").read_text())
    config["training"]["scenes"] = ["/nowhere/toy_0.h5"]
    (moved / "config.json").write_text(json.dumps(config))
    with pytest.raises(UserError, match="nowhere"):
        policies.open_setups([moved])
    save_scene(scene, tmp_path / "here.h5")
    (setup,) = policies.open_setups([moved], [str(tmp_path / "here.h5")])
    assert setup.fingerprint == policies.open_setups([agent_folder])[0].fingerprint
    save_scene(toy_scene(seed=5), tmp_path / "other.h5")
    with pytest.raises(UserError, match="no agent was trained in toy_5"):
        policies.open_setups([moved], [str(tmp_path / "other.h5")])


@pytest.mark.parametrize("option", ["--out", "--picture"])
def test_what_is_there_is_not_overwritten(
    option: str, agent_folder: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "precious"
    path.write_text("precious")
    assert main(["benchmark", "policies", str(agent_folder), option, str(path)]) == 2
    assert "--force" in capsys.readouterr().err
    assert path.read_text() == "precious"
