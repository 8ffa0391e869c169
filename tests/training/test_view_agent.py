"""Agents that search for views of their scene, from the command line: trained, measured, searching, and refused."""

from __future__ import annotations

import dataclasses
import json
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from active_perceiver.agent.config import AgentConfig, AgentError
from active_perceiver.agent.perceiver import ActivePerceiver
from active_perceiver.agent.visit_memory import ALIKE
from active_perceiver.cli.main import main
from active_perceiver.deploy.export import export_agent
from active_perceiver.errors import UserError
from active_perceiver.evaluation.config import EvaluateConfig
from active_perceiver.evaluation.view_measures import agent_view_searches, measure_view_agent
from active_perceiver.evaluation.view_selection import VIEWS, ViewSearches, chosen_states
from active_perceiver.policies.policy import policy_table
from active_perceiver.scenes import save_scene
from active_perceiver.training import train as training
from active_perceiver.training.config import TrainConfig
from active_perceiver.training.policy_stage import learner_config
from helpers.toy import toy_scene

pytestmark = pytest.mark.xdist_group("view_agent")

STATES = (30, 101, 160)


@pytest.fixture(scope="module")
def view_settings(settings) -> TrainConfig:
    return dataclasses.replace(settings, task="view", recogniser_steps=None, targets=tuple(map(str, STATES)))


@pytest.fixture(scope="module")
def folder(scene_file, tmp_path_factory) -> Path:
    out = tmp_path_factory.mktemp("views") / "zhu"
    arguments = ["train", "--task", "view", "--scenes", str(scene_file), "--image-size", "96", "--out", str(out)]
    assert main([*arguments, "--targets", *map(str, STATES)]) == 0
    return out


@pytest.fixture(scope="module")
def agent(folder) -> ActivePerceiver:
    return ActivePerceiver.from_pretrained(folder)


def test_training_writes_an_agent_without_a_recogniser(folder, scene):
    assert {path.name for path in folder.iterdir()} == {
        "README.md", "config.json", "policy.onnx", "policy.safetensors", "result.json", "targets",
    }  # fmt: skip
    result = json.loads((folder / "result.json").read_text())
    assert [entry["target"] for entry in result["per_target"]] == [f"view_{state}" for state in STATES]
    assert result["settings"]["task"] == "view"
    assert "recogniser" not in result
    assert "detection" not in result
    card = (folder / "README.md").read_text()
    assert "where that picture was taken" in card
    assert "AUROC" not in card


def test_it_finds_every_view_on_nearly_the_shortest_way(folder):
    overall = json.loads((folder / "result.json").read_text())["overall"]
    assert overall["success"] > 0.99
    assert overall["ratio"] < 1.2


def test_its_own_word_is_true(folder):
    word = json.loads((folder / "result.json").read_text())["stop_evaluation"]["pictures_seen"]
    assert [entry["target"] for entry in word["per_target"]] == [f"view_{state}" for state in STATES]
    assert word["overall"]["true_found"] > 0.9
    assert word["overall"]["true_found"] == word["overall"]["at_goal"]


def test_saying_found_elsewhere_is_false(agent):
    hasty = ActivePerceiver(agent.folder, dataclasses.replace(agent.config, found_similarity=0.0), agent.backbone)
    measured = measure_view_agent(hasty, agent_view_searches(hasty), EvaluateConfig(searches=30))
    word = measured.stops["pictures_seen"].overall
    assert (word["true_found"], word["false_found"], word["not_found"]) == (0, 1, 0)
    assert measured.policy.overall.success > 0.99  # which does not depend on its word


def test_only_the_view_itself_is_alike_enough(agent):
    (searches,) = agent_view_searches(agent)
    found = searches.similarity >= agent.config.found_similarity
    assert found[searches.task.goals].all()
    assert (searches.similarity[found] > ALIKE).all()
    assert found.sum() < 3 * len(STATES)


def test_acting_on_one_image_is_what_the_tables_say(agent, scene):
    (searches,) = agent_view_searches(agent)
    table = policy_table(agent.policy, searches.observations, scene.name)
    found = searches.similarity >= agent.config.found_similarity
    for index, goal in enumerate(STATES):
        for state in (*range(0, len(scene), 37), *STATES):
            agent.reset(scene.view(goal), seed=0)
            step = agent.act(scene.view(state))
            assert step.detection is None
            assert step.found == found[state, index]
            np.testing.assert_allclose(step.probabilities, table[state, index], atol=0.02)


def test_evaluate_measures_exactly_and_by_the_paper_s_episodes(folder, tmp_path, capsys):
    out = tmp_path / "result.json"
    assert main(["evaluate", str(folder), "--searches", "20", "--out", str(out)]) == 0
    text = capsys.readouterr().out
    assert "view_101" in text
    assert "AUROC" not in text
    exact = json.loads(out.read_text())
    assert exact["overall"] == json.loads((folder / "result.json").read_text())["overall"]
    assert main(["evaluate", str(folder), "--protocol", "paper", "--out", str(out), "--force"]) == 0
    paper = json.loads(out.read_text())
    assert paper["protocol"]["kind"] == "episodes"
    assert paper["overall"]["success"] == pytest.approx(exact["overall"]["success"], abs=0.1)


@pytest.mark.parametrize("kind", ["exported", "kept"])
def test_search_goes_where_the_picture_was_taken(folder, scene, scene_file, tmp_path, capsys, kind):
    picture = next((folder / "targets" / scene.name / "view_101").iterdir())
    if kind == "exported":
        picture = tmp_path / "view.png"
        Image.fromarray(scene.view(101)).save(picture)
    arguments = ["search", str(folder), "--picture", str(picture), "--robot", f"scene:{scene_file}", "--start", "3"]
    assert main([*arguments, "--seed", "1", "--out", str(tmp_path / "run")]) == 0
    assert "found after" in capsys.readouterr().out
    steps = json.loads((tmp_path / "run" / "search.json").read_text())["steps"]
    assert steps[-1]["pose"] == pytest.approx(scene.poses[101].tolist())
    assert all(step["box"] is None for step in steps)


def test_the_benchmark_of_robots_refuses_it(folder, capsys):
    assert main(["benchmark", "robot", str(folder), "--room", "kitchen_1"]) == 2
    assert "searches for views; this benchmark is of searches" in " ".join(capsys.readouterr().err.split())


def test_search_gives_up_on_a_picture_of_another_place(folder, scene_file, tmp_path, capsys):
    Image.fromarray(toy_scene(9, side=1).view(0)).save(tmp_path / "elsewhere.png")
    arguments = ["search", str(folder), "--picture", str(tmp_path / "elsewhere.png"), "--max-steps", "5"]
    assert main([*arguments, "--robot", f"scene:{scene_file}", "--seed", "0"]) == 1
    assert "gave up after 5 actions" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--targets", "mug"], "number of a state, such as 12; 'mug' is none"),
        (["--targets", "-3"], "'-3' is none"),
        (["--targets", "12.5"], "'12.5' is none"),
        (["--targets", "192"], "has no state 192; its states are 0 to 191"),
        (["--targets", "4", "toy_0/4"], "state 4 of 'toy_0' is given twice"),
        (["--targets", "attic/4"], "no scene 'attic' here"),
        (["--recogniser-steps", "5"], "leave --recogniser-steps out"),
        (["--rank", "3"], "leave --rank out"),
        (["--reward", "record"], "ppo"),
    ],
)
def test_bad_input_is_refused_and_leaves_nothing_behind(scene_file, tmp_path, capsys, arguments, message):
    out = tmp_path / "agent"
    assert main(["train", "--task", "view", "--scenes", str(scene_file), "--out", str(out), *arguments]) == 2
    error = " ".join(capsys.readouterr().err.split())
    assert message in error
    assert list(tmp_path.iterdir()) == []


def test_states_of_several_scenes_say_which(scene):
    attic = dataclasses.replace(scene, name="attic")
    assert chosen_states([scene, attic], ["attic/7", "toy_0/3", "attic/5"], 0) == [(3,), (7, 5)]
    with pytest.raises(UserError, match="of which scene 7 is a state: toy_0/7"):
        chosen_states([scene, attic], ["7"], 0)
    with pytest.raises(UserError, match="no view of scene 'attic'"):
        chosen_states([scene, attic], ["toy_0/3"], 0)


def test_views_are_drawn_by_the_seed_from_where_moves_lead(scene):
    first, again, other = (chosen_states([scene], (), seed) for seed in (0, 0, 1))
    assert first == again != other
    assert len(set(first[0])) == VIEWS
    nothing = np.repeat(np.arange(len(scene))[:, None], scene.transitions.shape[1], axis=1)
    nothing[0, 0] = 8
    assert chosen_states([dataclasses.replace(scene, transitions=nothing.astype(np.int32))], (), 0) == [(8,)]


def test_the_word_found_is_calibrated_to_the_nearest_view_that_differs(scene):
    features = np.eye(len(scene), dtype=np.float32)
    features[1] = [1.0, 0.01, *[0.0] * (len(scene) - 2)]  # practically view 0
    features[2] = [0.9, 0.0, np.sqrt(1 - 0.81), *[0.0] * (len(scene) - 3)]
    assert ViewSearches(scene, (0,), features).found_similarity() == pytest.approx(0.91)


@pytest.mark.parametrize("learner", ["mirror-descent", "ppo"])
def test_arriving_is_paid_for_unless_another_reward_is_given(view_settings, learner):
    chosen = dataclasses.replace(view_settings, learner=learner)
    assert learner_config(chosen).reward == "goal"
    assert learner_config(dataclasses.replace(chosen, reward="arrival")).reward == "arrival"
    assert learner_config(dataclasses.replace(chosen, task="object")).reward != "goal"


def test_ppo_learns_it_in_two_scenes(view_settings, tmp_path):
    save_scene(toy_scene(3, side=2), tmp_path / "toy_3.h5")
    both = dataclasses.replace(
        view_settings, scenes=(*view_settings.scenes, str(tmp_path / "toy_3.h5")),
        targets=("toy_0/30", "toy_3/5"), learner="ppo", policy_seconds=3.0,
    )  # fmt: skip
    per_target = training.train(both, tmp_path / "agent").evaluation.policy.per_target
    assert [(result.scene, result.target) for result in per_target] == [
        ("toy_0", "view_30"), ("toy_3", "view_5"),
    ]  # fmt: skip
    assert per_target[1].success > 0.5


def test_a_scene_that_has_changed_is_not_measured(folder, tmp_path):
    shutil.copytree(folder, tmp_path / "agent")
    config = AgentConfig.load(folder)
    changed = dataclasses.replace(toy_scene(1), name=config.targets[0].scene)
    save_scene(changed, tmp_path / "changed.h5")
    dataclasses.replace(
        config, training=dataclasses.replace(config.training, scenes=(str(tmp_path / "changed.h5"),))
    ).save(tmp_path / "agent")
    with pytest.raises(UserError, match="'view_30' is not the view of scene 'toy_0'"):
        agent_view_searches(ActivePerceiver.from_pretrained(tmp_path / "agent"))


def test_it_has_nothing_that_knows_objects(agent):
    for name in ("recogniser", "gallery", "criterion"):
        with pytest.raises(AgentError, match="searches for views"):
            getattr(agent, name)


def test_agents_of_before_search_for_objects(folder, tmp_path):
    path = tmp_path / "config.json"
    data = json.loads((folder / "config.json").read_text())
    path.write_text(json.dumps({key: data[key] for key in data.keys() - {"task", "found_similarity"}}))
    assert AgentConfig.load(tmp_path).task == "object"
    path.write_text(json.dumps({**data, "task": "song"}))
    with pytest.raises(AgentError, match="one of object, view, not 'song'"):
        AgentConfig.load(tmp_path)


RUN = """
import sys
from active_perceiver.agent.perceiver import ActivePerceiver
from active_perceiver.scenes import open_scene

agent = ActivePerceiver.from_pretrained(sys.argv[1])
view = open_scene(sys.argv[2]).view(101)
agent.reset(view, seed=0)
print(agent.act(view).found, "torch" in sys.modules)
"""


def test_running_it_does_not_import_torch(folder, scene_file):
    done = subprocess.run(
        [sys.executable, "-c", RUN, str(folder), str(scene_file)], capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
    assert done.stdout.strip() == "True False"


def test_it_is_exported_without_a_recogniser(folder, agent, scene, tmp_path):
    for int8 in (False, True):
        export_agent(folder, tmp_path / f"robot_{int8}", int8=int8)
    assert {path.name for path in (tmp_path / "robot_False").iterdir()} == {
        "README.md", "backbone.onnx", "checksums.json", "config.json", "policy.onnx", "targets",
    }  # fmt: skip
    assert "for the views view_30, view_101, view_160." in (tmp_path / "robot_True" / "README.md").read_text()
    robot, small = (ActivePerceiver.from_pretrained(tmp_path / f"robot_{int8}") for int8 in (False, True))
    for one in (agent, robot, small):
        one.reset(scene.view(STATES[1]), seed=0)
    for state in (5, 60, 101):
        expected = agent.act(scene.view(state))
        np.testing.assert_array_equal(robot.act(scene.view(state)).probabilities, expected.probabilities)
        assert small.act(scene.view(state)).found == expected.found == (state == STATES[1])
