"""`benchmark train`: stable-baselines3 trains the very same network in the same searches, and the command holds."""

from __future__ import annotations

import json
import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import torch
from PIL import Image

from active_perceiver.benchmarks.config import TrainSpeedConfig
from active_perceiver.benchmarks.runner import OutputFiles, run_benchmark
from active_perceiver.benchmarks.train import measure as train_speed
from active_perceiver.benchmarks.train.baselines import BASELINES, Sb3Config, Sb3PpoConfig, baseline_named
from active_perceiver.benchmarks.train.measure import TrainBenchmark
from active_perceiver.benchmarks.train.report import (
    first_good,
    format_train_speed,
    learner_summary,
    times_faster,
    trainings_of,
)
from active_perceiver.benchmarks.train.worker import Training, measured, train
from active_perceiver.cli.main import main
from active_perceiver.envs import REWARDS, SearchVectorEnv
from active_perceiver.errors import UserError
from active_perceiver.parallel.executor import SerialExecutor
from active_perceiver.policies.monitor import Monitor
from active_perceiver.policies.network import PolicyNetwork, picture_tensors, seeded_network
from active_perceiver.policies.training_task import TrainingTask
from active_perceiver.utils.files import OutputExistsError
from helpers.interrupted import InterruptedExecutor
from helpers.problems import toy_task
from helpers.small import SIZE

pytest.importorskip("stable_baselines3")
sb3_peers = pytest.importorskip("active_perceiver.benchmarks.train.sb3_baselines")

SMALL = {"hidden": 32, "num_envs": 8, "num_steps": 16}
CONFIGS = [Sb3PpoConfig(**SMALL, batch_size=32), Sb3Config(**SMALL)]


def train_sb3(training_task: TrainingTask, config: Sb3Config) -> tuple[PolicyNetwork, list[dict[str, float]]]:
    monitor = Monitor([training_task], config)
    return sb3_peers.train_sb3([training_task], config, monitor), monitor.history


@pytest.fixture(scope="module")
def training_task() -> TrainingTask:
    return toy_task()


def test_until_an_episode_ends_the_adapter_is_the_vector_environment(training_task: TrainingTask) -> None:
    theirs = sb3_peers.SearchVecEnv(training_task, 5, "gain", 40)
    ours = SearchVectorEnv(
        5, task=training_task.task, observations=training_task.observations, reward="gain", max_steps=40
    )
    theirs.seed(3)
    mine, _ = ours.reset(seed=3)
    np.testing.assert_equal(theirs.reset(), mine)
    rng = np.random.default_rng(0)
    for step in range(1000):  # noqa: B007
        actions = rng.integers(len(training_task.task.actions), size=5)
        observations, rewards, terminated, truncated, _ = ours.step(actions)
        seen, paid, ended, _ = theirs.step(actions)
        np.testing.assert_array_equal(paid, rewards.astype(np.float32))
        np.testing.assert_array_equal(ended, terminated | truncated)
        if ended.any():
            break
        np.testing.assert_equal(seen, observations)
    assert 0 < step < 999, "an end was to be seen, but not at once"


def test_the_adapter_steps_as_the_tables_say_and_begins_anew_in_the_same_step(training_task: TrainingTask) -> None:
    task, most = training_task.task, 6
    env = sb3_peers.SearchVecEnv(training_task, 4, "gain", most)
    env.seed(0)
    env.reset()
    searches = env.env.searches
    records = [task.areas[state, target] for state, target in zip(searches.states, searches.targets, strict=True)]
    steps = [0] * 4
    rng = np.random.default_rng(1)
    endings = {True: 0, False: 0}
    for _ in range(60):
        before, targets, pictures = searches.states.copy(), searches.targets.copy(), env.env._pictures.copy()
        actions = rng.integers(len(task.actions), size=4)
        observations, rewards, dones, infos = env.step(actions)
        for row in range(4):
            after, target = task.transitions[before[row], actions[row]], targets[row]
            area, arrived = task.areas[after, target], task.goals[after, target]
            pay = REWARDS["gain"].function(area, records[row], arrived, task.goal_areas[target])
            assert rewards[row] == pytest.approx(float(pay), rel=1e-6)
            steps[row] += 1
            records[row] = max(records[row], area)
            assert dones[row] == (arrived or steps[row] == most)
            shown = {name: values[row] for name, values in observations.items()}
            if dones[row]:
                endings[bool(arrived)] += 1
                assert infos[row]["TimeLimit.truncated"] == (not arrived)
                last = env.env.tables.look(after, target, pictures[row])
                np.testing.assert_equal(infos[row]["terminal_observation"], last)
                steps[row], records[row] = 0, task.areas[searches.states[row], searches.targets[row]]
                assert task.steps[searches.states[row], searches.targets[row]] > 0
            else:
                assert infos[row] == {}
                assert (searches.states[row], searches.targets[row]) == (after, target)
            now = env.env.tables.look(searches.states[row], searches.targets[row], env.env._pictures[row])
            np.testing.assert_equal(shown, now)
    assert min(endings.values()) > 0, "both kinds of endings were to be seen"


@pytest.mark.parametrize("config", CONFIGS, ids=["ppo", "a2c"])
def test_the_policy_is_the_network_and_says_what_it_says(training_task: TrainingTask, config: Sb3Config) -> None:
    network = seeded_network([training_task], config)
    model = sb3_peers.make_model(training_task, network, config)
    optimised = {id(weight) for group in model.policy.optimizer.param_groups for weight in group["params"]}
    assert optimised == {id(weight) for weight in network.parameters()}
    shapes = {name.removeprefix("network."): weight.shape for name, weight in model.policy.named_parameters()}
    assert shapes == {name: weight.shape for name, weight in network.named_parameters()}
    with torch.no_grad():
        for head in network.action_heads:
            head.weight.normal_(0, 0.5)  # so that the policy differs from place to place
        views, targets, masks = picture_tensors(training_task, 0)
        log_policy, values = network.table(views, targets, masks, training_task.task.scene)
        for target in range(len(targets)):
            seen = {"view": views, "target": targets[target].expand_as(views), "mask": masks[:, target]}
            distribution = model.policy.get_distribution(seen).distribution
            torch.testing.assert_close(distribution.logits, log_policy[:, target], rtol=1e-4, atol=1e-5)
            actions = distribution.probs.argmax(-1)
            value, logged, entropy = model.policy.evaluate_actions(seen, actions)
            torch.testing.assert_close(value[:, 0], values[:, target], rtol=1e-4, atol=1e-5)
            torch.testing.assert_close(logged, log_policy[:, target].amax(-1), rtol=1e-4, atol=1e-5)
            spread = -(log_policy[:, target].exp() * log_policy[:, target]).sum(-1)
            torch.testing.assert_close(entropy, spread, rtol=1e-4, atol=1e-5)
            done, robot_moved, logged_too = model.policy(seen, deterministic=True)
            assert (done == actions).all()
            torch.testing.assert_close(robot_moved, value)
            torch.testing.assert_close(logged_too, logged)
            torch.testing.assert_close(model.policy.predict_values(seen), value)


@pytest.mark.parametrize("config", CONFIGS, ids=["ppo", "a2c"])
def test_their_training_is_measured_as_ours_and_repeatable(training_task: TrainingTask, config: Sb3Config) -> None:
    config = replace(config, iterations=3, check_every=2)
    network, history = train_sb3(training_task, config)
    assert [(record["iteration"], record["samples"]) for record in history] == [(2, 256), (3, 384)]
    before, again = seeded_network([training_task], config), train_sb3(training_task, config)[0]
    changed = [not torch.equal(*pair) for pair in zip(network.parameters(), before.parameters(), strict=True)]
    assert all(changed)
    for first, second in zip(network.parameters(), again.parameters(), strict=True):
        torch.testing.assert_close(first, second, rtol=0, atol=0)


def test_their_training_stops_when_it_is_good_or_time_is_up(training_task: TrainingTask) -> None:
    _, history = train_sb3(training_task, replace(CONFIGS[0], iterations=50, seconds=0.0))
    assert len(history) == 1
    config = Sb3PpoConfig(hidden=64, num_envs=32, batch_size=256, target_ratio=2.0, check_every=5)
    _, history = train_sb3(training_task, config)
    assert history[-1]["success"] == pytest.approx(1)
    assert history[-1]["ratio"] <= 2
    assert history[-1]["iteration"] < config.iterations
    with pytest.raises(UserError, match="in one scene, got 2"):
        sb3_peers.train_sb3([training_task, toy_task(1)], config, Monitor([training_task], config))


def point(seconds: float, steps: int, success: float, ratio: float | None) -> dict[str, Any]:
    return {"seconds": seconds, "steps": steps, "success": success, "ratio": ratio}


GOOD = [point(1, 100, 0, None), point(2, 200, 1, 3.0), point(3, 300, 0.9, 1.1), point(4, 400, 1, 1.2)]
SLOW = [point(10, 500, 0.5, 1.0), point(20, 1000, 1, 1.3)]


def test_a_training_is_good_when_all_searches_arrive_by_short_ways() -> None:
    assert first_good(GOOD, None) == GOOD[1]
    assert first_good(GOOD, 1.25) == GOOD[3]
    assert first_good(GOOD, 1.02) is None
    assert first_good(SLOW, 1.25) is None


def test_trainings_that_never_get_there_count_as_the_slowest() -> None:
    summary = learner_summary([GOOD, SLOW, GOOD])
    assert summary["success"] == {"reached": 3, "median": 2, "least": 2, "most": 20}
    assert summary["ratio"] == {"reached": 2, "median": 4, "least": 4, "most": None}
    assert summary["fine_ratio"] == {"reached": 0, "median": None, "least": None, "most": None}
    assert (summary["steps"], summary["per_second"], summary["longest"]) == (400, 100, 20)
    # Half of them is not enough for a median.
    assert learner_summary([GOOD, SLOW])["ratio"]["median"] is None


def test_a_record_becomes_a_point_without_the_time_of_measuring() -> None:
    record = {"seconds": 5.0, "measuring": 2.0, "samples": 7, "success": 1 - 1e-9, "ratio": 1.5}
    assert measured(record, BASELINES["ppo"]) == point(3, 7, 1, 1.5)
    assert measured(record, BASELINES["a3c"]) == point(5, 7, 1, 1.5)  # its workers do not wait
    assert measured({**record, "success": 0.0, "ratio": math.nan}, BASELINES["ppo"]) == point(3, 7, 0, None)


def test_the_process_trains_by_its_baseline_with_the_given_seed(training_task: TrainingTask) -> None:
    run = train(training_task, Training("distil", 0, 1, 0.0))
    assert (run["learner"], run["seed"], len(run["points"])) == ("distil", 0, 1)
    assert run["points"][0]["seconds"] > 0
    assert run["points"][0]["steps"] == 0


def fake_run(training_task: TrainingTask, training: Training) -> dict[str, Any]:
    theirs = [point(100 + training.seed, 10**6, 1, 1.2)]
    points = {"distil": GOOD, "sb3-ppo": theirs}.get(training.name, SLOW)
    return {"learner": training.name, "seed": training.seed, "points": points}


def arguments_for(scene_file: Path, *more: str) -> list[str]:
    names = ["benchmark", "train", "--scene", str(scene_file), "--targets", "ball0", "ball1"]
    return [*names, "--image-size", str(SIZE), "--threads", "1", *more]


def test_it_goes_on_where_it_was_interrupted(
    scene_file: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(train_speed, "train", fake_run)
    out, picture = tmp_path / "train.json", tmp_path / "train.png"
    learners = ("distil", "a3c", "sb3-ppo")
    settings = TrainSpeedConfig(learners, 2, str(scene_file), ("ball0", "ball1"), threads=1, image_size=SIZE)
    first, second = (InterruptedExecutor(SerialExecutor(), at) for at in (4, 0))
    files = OutputFiles(out, picture)
    with pytest.raises(KeyboardInterrupt):
        run_benchmark(TrainBenchmark(settings, first), files)
    assert not out.exists()
    with pytest.raises(OutputExistsError, match="--resume goes on"):
        run_benchmark(TrainBenchmark(settings, second), files)
    with pytest.raises(UserError, match=r"begun with other settings \(seconds\)"):
        run_benchmark(TrainBenchmark(replace(settings, seconds=5.0), second), replace(files, resume=True))
    benchmark = TrainBenchmark(settings, second)
    text = benchmark.report(run_benchmark(benchmark, replace(files, resume=True)))
    assert [(one.name, one.seed) for one in first.done] == [("distil", 0), ("a3c", 0), ("sb3-ppo", 0)]
    assert [(one.name, one.seed) for one in second.done] == [("distil", 1), ("a3c", 1), ("sb3-ppo", 1)]
    result = json.loads(out.read_text())
    assert result["command"] == "benchmark train"
    assert [(run["learner"], run["seed"]) for run in result["runs"]] == [
        (name, seed) for name in ("distil", "a3c", "sb3-ppo") for seed in range(2)
    ]
    assert result["runs"][0]["points"] == GOOD
    assert list(tmp_path.iterdir()) in ([out, picture], [picture, out])
    assert Image.open(picture).format == "PNG"
    assert capsys.readouterr().out == ""  # it is the command that prints
    assert format_train_speed(result) == text
    rows = {line.split()[0]: line for line in text.splitlines() if line.strip()}
    assert "2/2" in rows["distil"]
    assert rows["distil"].split()[-1] == "25.2"  # 101 s, the upper median, over 4 s
    assert "not in 20 s" in rows["a3c"]
    assert rows["a3c"].split()[-1] == "-"
    assert rows["sb3-ppo"].split()[-1] == "1.0"
    assert times_faster(result, result["learners"][0]) == 101 / 4
    assert len(trainings_of(result)["distil"]) == 2


def test_a_tiny_run_trains_for_real(scene_file: Path, tmp_path: Path) -> None:
    out = tmp_path / "train.json"
    arguments = arguments_for(scene_file, "--learners", "distil", "sb3-a2c", "--seeds", "1", "--seconds", "0.5")
    assert main([*arguments, "--out", str(out)]) == 0
    result = json.loads(out.read_text())
    ours, theirs = result["runs"]
    assert ours["points"][-1]["steps"] == 0
    config = BASELINES["sb3-a2c"].config
    assert isinstance(config, Sb3Config)
    assert theirs["points"][-1]["steps"] % (config.num_envs * config.num_steps) == 0
    assert theirs["points"][-1]["steps"] > 0
    assert result["protocol"]["targets"] == ["ball0", "ball1"]
    assert result["protocol"]["settings"]["sb3-a2c"]["num_envs"] == config.num_envs


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--scene", "atlantis"], "neither a bundled scene"),
        (["--learners", "distil", "distil"], "each learner once"),
        (["--seeds", "0"], "must be at least 1"),
        (["--threads", "0"], "must be at least 1"),
        (["--seconds", "0"], "needs some seconds"),
        (["--targets", "unicorn"], "no scene has the target unicorn"),
        (["--boxes", "nowhere"], "is not an agent"),
        (["--resume"], "name it with --out"),
    ],
)
def test_wrong_input_is_explained(arguments: list[str], message: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["benchmark", "train", *arguments]) == 2
    error = capsys.readouterr().err.replace("\n", " ")
    assert message in error
    assert "Traceback" not in error


def test_a_missing_rival_is_named_with_the_remedy(monkeypatch: pytest.MonkeyPatch) -> None:
    from active_perceiver.benchmarks.train import baselines

    monkeypatch.setattr(baselines, "find_spec", lambda _: None)
    assert baseline_named("distil").learner.name == "distil"
    with pytest.raises(UserError, match=r"needs stable-baselines3: pip install 'active-perceiver\[dev\]'"):
        baseline_named("sb3-ppo")
    with pytest.raises(UserError, match="choose one of mirror-descent"):
        baseline_named("dqn")


def test_help_has_examples_and_what_is_there_stays(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit):
        main(["benchmark", "train", "--help"])
    assert "active-perceiver benchmark train" in capsys.readouterr().out.split("Examples:")[1]
    path = tmp_path / "precious"
    path.write_text("precious")
    for option in ("--out", "--picture"):
        assert main(["benchmark", "train", option, str(path)]) == 2
        assert "--force" in capsys.readouterr().err
    assert path.read_text() == "precious"


def test_boxes_may_be_those_of_an_agent(scene_file: Path, agent_folder: Path) -> None:
    settings = train_speed.TrainSpeedConfig(scene=str(scene_file), targets=(), boxes=str(agent_folder))
    seen = train_speed.search_training_task(settings)
    exact = train_speed.search_training_task(replace(settings, boxes="truth", image_size=SIZE))
    assert seen.task.targets == exact.task.targets
    np.testing.assert_allclose(
        seen.observations.view_features, exact.observations.view_features, rtol=1e-5, atol=1e-5
    )
    np.testing.assert_array_equal(seen.observations.target_features, exact.observations.target_features)
    assert (seen.observations.masks != exact.observations.masks).any(), "its recogniser is not perfect"
    with pytest.raises(UserError, match="was not trained to search toy_0 for ball1"):
        train_speed.search_training_task(replace(settings, targets=("ball1",)))
