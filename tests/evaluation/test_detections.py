"""Which pictures training may use is what the scene says, whatever their numbers."""

from __future__ import annotations

import dataclasses
import json
import shutil

import numpy as np
import pytest

from active_perceiver.agent.config import picture_folder
from active_perceiver.agent.perceiver import ActivePerceiver
from active_perceiver.errors import UserError
from active_perceiver.evaluation.config import EvaluateConfig
from active_perceiver.evaluation.detections import even_pictures
from active_perceiver.evaluation.object_measures import agent_detections, measure_agent
from active_perceiver.scenes import Scene, Target, save_scene
from active_perceiver.training import train as training
from helpers.toy import toy_scene


def target(trained: int, held_out: int) -> Target:
    return Target("mug", tuple(b"%d" % number for number in range(trained + held_out)), held_out=held_out)


@pytest.mark.parametrize(
    ("sizes", "trained", "rows"),
    [
        ([(2, 2), (2, 2)], 2, [[0, 1, 2, 3], [0, 1, 2, 3]]),
        ([(3, 1), (2, 4)], 2, [[0, 1, 3], [0, 1, 2]]),
        ([(4, 0), (2, 2)], 2, [[0, 1], [0, 1]]),
        ([(1, 0)], 1, [[0]]),
    ],
)
def test_no_picture_changes_sides(sizes, trained, rows):
    numbers, count = even_pictures([target(*size) for size in sizes])
    assert count == trained
    assert numbers.tolist() == rows


@pytest.fixture(scope="module")
def uneven() -> Scene:
    """One ball has two pictures more to train with, another one picture less that is held out."""
    scene = toy_scene(seed=4, side=3, targets=2)
    first, second = scene.targets
    extra = toy_scene(seed=4, side=1, targets=3).targets[2].pictures
    more = dataclasses.replace(first, pictures=(*extra[:2], *first.pictures))
    fewer = dataclasses.replace(second, held_out=1)
    return dataclasses.replace(scene, name="uneven", targets=(more, fewer))


@pytest.mark.usefixtures("short_searches")
def test_an_agent_of_scenes_with_other_numbers_of_pictures(uneven, settings, tmp_path):
    path = tmp_path / "uneven.h5"
    save_scene(uneven, path)
    both = dataclasses.replace(settings, scenes=(*settings.scenes, str(path)), recogniser_steps=5, policy_seconds=1.0)
    body = training.train(both, tmp_path / "agent").to_json()
    config = json.loads((tmp_path / "agent" / "config.json").read_text())
    assert config["training"]["held_out_pictures"]["uneven"] == {"ball0": 2, "ball1": 1}
    kept = [len(list(picture_folder(tmp_path / "agent", "uneven", f"ball{k}").iterdir())) for k in range(2)]
    assert kept == [3, 3]  # those that training used: equally many of each target
    assert len(body["unseen_pictures"]["per_target"]) == 5
    agent = ActivePerceiver.from_pretrained(tmp_path / "agent")
    toy, seen = agent_detections(agent)
    assert (toy.trained_pictures, toy.held_out_pictures) == ([0, 1], [2, 3])
    assert (seen.trained_pictures, seen.held_out_pictures) == ([0, 1, 2], [3])
    # The held-out column is each target's first held-out picture: 4 of one and 3 of the other.
    for row, number in enumerate((4, 3)):
        maps = agent.backbone.maps([uneven.targets[row].picture(number)])
        np.testing.assert_allclose(seen.target_embeddings[row, 3], agent.recogniser.encode_target(maps)[0], atol=0.02)

    # Had the split been moved since, what training saw would be measured as never seen.
    moved = tuple(dataclasses.replace(target, held_out=3) for target in uneven.targets)
    save_scene(dataclasses.replace(uneven, targets=moved), path, force=True)
    with pytest.raises(UserError, match="now holds out"):
        agent_detections(agent)


def test_scenes_that_hold_nothing_out_are_measured_without(agent_folder, scene, settings, tmp_path):
    everything = tuple(
        dataclasses.replace(target, pictures=target.pictures[:2], held_out=0) for target in scene.targets
    )
    path = tmp_path / "toy_0.h5"
    save_scene(dataclasses.replace(scene, targets=everything), path)
    copy = tmp_path / "agent"
    shutil.copytree(agent_folder, copy)
    config = json.loads((copy / "config.json").read_text())
    config["training"]["scenes"] = [str(path)]
    (copy / "config.json").write_text(json.dumps(config))
    agent = ActivePerceiver.from_pretrained(copy)
    body = measure_agent(agent, agent_detections(agent), EvaluateConfig(searches=5)).to_json()
    assert "unseen_pictures" not in body
    assert set(body["detection"]) == {"pictures_seen"}
