"""Training as a whole: what it writes, what it refuses, that it goes on where it stopped."""

import dataclasses
import json

import pytest

from active_perceiver.errors import UserError
from active_perceiver.scenes import save_scene
from active_perceiver.training import recogniser_stage
from active_perceiver.training import train as training
from active_perceiver.utils.files import OutputExistsError
from helpers.toy import toy_scene

pytestmark = pytest.mark.xdist_group("training")


def test_the_folder_is_complete_and_the_result_says_how_good_it_is(trained_folder, scene):
    names = {path.name for path in trained_folder.iterdir()}
    assert names == {
        "README.md", "config.json", "known_pictures.npz", "maps", "policy.onnx", "policy.safetensors",
        "recogniser.json", "recogniser.onnx",
        "recogniser.safetensors", "result.json", "targets",
    }  # fmt: skip
    result = json.loads((trained_folder / "result.json").read_text())
    assert result["command"] == "train"
    assert {entry["target"] for entry in result["per_target"]} == set(scene.target_names)
    assert result["overall"]["success"] > 0.95
    assert result["machine"]["cores"] >= 1
    assert (trained_folder / "README.md").read_text().startswith("---\nlibrary_name: active-perceiver")
    assert not trained_folder.with_name("toy.part").exists()


def test_an_agent_that_is_there_is_not_overwritten(settings, trained_folder):
    before = (trained_folder / "config.json").read_bytes()
    with pytest.raises(OutputExistsError, match="--force"):
        training.train(settings, trained_folder)
    assert (trained_folder / "config.json").read_bytes() == before


def test_an_interrupted_training_goes_on_and_gives_the_same_agent(settings, trained_folder, tmp_path, monkeypatch):
    out = tmp_path / "agent"

    def interrupted(*_):
        raise KeyboardInterrupt

    with monkeypatch.context() as patch:
        patch.setattr(training, "train_policy", interrupted)
        with pytest.raises(KeyboardInterrupt):
            training.train(settings, out)
    assert not out.exists()
    with pytest.raises(OutputExistsError, match="--resume"):
        training.train(settings, out)
    with pytest.raises(UserError, match="other settings"):
        training.train(dataclasses.replace(settings, seed=9), out, resume=True)

    with monkeypatch.context() as patch:
        patch.setattr(recogniser_stage, "train_scene_recogniser", interrupted)  # it is there already
        training.train(settings, out, resume=True)
    assert (out / "recogniser.onnx").read_bytes() == (trained_folder / "recogniser.onnx").read_bytes()
    again, first = (json.loads((folder / "result.json").read_text()) for folder in (out, trained_folder))
    assert again["overall"] == first["overall"]
    assert again["stop_evaluation"] == first["stop_evaluation"]


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"targets": ("unicorn",)}, "no scene has the target unicorn"),
        ({"scenes": ()}, "at least one"),
        ({"scenes": ("nowhere",)}, "neither a bundled scene"),
        ({"backbone": "alexnet"}, "no backbone 'alexnet'"),
        ({"entropy_weight": 0.1}, "has no entropy_weight"),
        ({"reward": "record"}, "ppo"),
    ],
)
def test_wrong_settings_are_refused_before_anything_long(settings, tmp_path, change, message):
    with pytest.raises(UserError, match=message):
        training.train(dataclasses.replace(settings, **change), tmp_path / "agent")
    assert list(tmp_path.iterdir()) == []  # so that the corrected command is not taken for a second one


@pytest.mark.parametrize("name", ["agent", "agent.part"])
def test_force_does_not_replace_what_is_no_agent(settings, tmp_path, name):
    (tmp_path / name).mkdir()
    (tmp_path / name / "diary.txt").write_text("dear diary")
    with pytest.raises(OutputExistsError, match="will not be replaced"):
        training.train(settings, tmp_path / "agent", force=True)
    assert (tmp_path / name / "diary.txt").read_text() == "dear diary"


def test_the_same_scene_twice_is_refused(settings, tmp_path):
    twice = dataclasses.replace(settings, scenes=settings.scenes * 2)
    with pytest.raises(UserError, match="different names"):
        training.train(twice, tmp_path / "agent")


@pytest.mark.usefixtures("short_searches")
def test_ppo_trains_for_the_paper_s_reward(settings, tmp_path):
    record = dataclasses.replace(
        settings, learner="ppo", reward="record", entropy_weight=0.01, recogniser_steps=5, policy_seconds=2.0
    )
    body = training.train(record, tmp_path / "agent").to_json()
    assert 0 <= body["overall"]["success"] <= 1
    assert body["settings"]["reward"] == "record"


@pytest.fixture(scope="module")
def elsewhere(tmp_path_factory):
    """Another room with the same balls."""
    path = tmp_path_factory.mktemp("elsewhere") / "photographs.h5"
    save_scene(toy_scene(5, side=3), path)
    return path


@pytest.mark.usefixtures("short_searches")
def test_the_recogniser_may_be_trained_elsewhere(settings, scene, elsewhere, tmp_path):
    apart = dataclasses.replace(settings, recogniser_scenes=(str(elsewhere),), recogniser_steps=5, policy_seconds=1.0)
    body = training.train(apart, tmp_path / "agent").to_json()
    config = json.loads((tmp_path / "agent" / "config.json").read_text())
    assert list(config["branches"]) == [scene.name]
    assert config["training"]["scenes"] == list(settings.scenes)
    assert config["training"]["recogniser_scenes"] == [str(elsewhere)]
    # No view of the scene was trained on, so all of them tell how well it recognises.
    assert config["training"]["held_out_views"] == {scene.name: list(range(len(scene)))}
    assert body["settings"]["recogniser_scenes"] == (str(elsewhere),)


@pytest.mark.usefixtures("short_searches")
def test_a_recogniser_trained_there_and_elsewhere_holds_out_its_own_views(settings, scene, elsewhere, tmp_path):
    both = dataclasses.replace(
        settings, recogniser_scenes=(*settings.scenes, str(elsewhere)), recogniser_steps=2, policy_seconds=1.0
    )
    training.train(both, tmp_path / "agent")
    views = json.loads((tmp_path / "agent" / "config.json").read_text())["training"]["held_out_views"]
    assert list(views) == [scene.name]
    assert 0 < len(views[scene.name]) < len(scene) / 2


def test_scenes_of_the_recogniser_must_keep_the_split(settings, scene, tmp_path):
    everything = tuple(dataclasses.replace(target, held_out=0) for target in scene.targets)
    careless = tmp_path / "photographs.h5"
    save_scene(dataclasses.replace(toy_scene(5), targets=everything), careless)
    apart = dataclasses.replace(settings, recogniser_scenes=(str(careless),))
    with pytest.raises(UserError, match="'ball0' that scene 'toy_0' holds out"):
        training.train(apart, tmp_path / "agent")
    assert not (tmp_path / "agent.part").exists()


def test_the_same_scene_twice_for_the_recogniser_is_refused(settings, tmp_path):
    twice = dataclasses.replace(settings, recogniser_scenes=settings.scenes * 2)
    with pytest.raises(UserError, match="different names"):
        training.train(twice, tmp_path / "agent")
