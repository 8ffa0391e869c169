"""Files that earlier versions wrote are read as they were then; `data/VERSION/README.md` says how they were made."""

import json
import shutil
from pathlib import Path

import numpy as np
import pytest
import yaml

from active_perceiver.cli.main import main
from active_perceiver.robots.ros.config_file import load_config, save_config
from active_perceiver.scenes import load_scene
from active_perceiver.scenes.box_labels import label_states
from active_perceiver.scenes.scene import LABELLED, PROPOSED, UNLABELLED

OLD = Path(__file__).parent / "data" / "v0.1"
SCENE = OLD / "toy_0.h5"
SEARCHES = [
    ("agent", "recording", "ball1/01.png"),
    ("view_agent", "view_recording", "view_7/00.png"),
]


def steps(recording: Path) -> list[dict]:
    return [json.loads(line) for line in (recording / "steps.jsonl").read_text().splitlines()]


def test_a_scene_is_read_and_sound(capsys):
    assert main(["scenes", "info", str(SCENE)]) == 0
    text = capsys.readouterr().out
    assert "9 places, 12 views at each, 3 tilt(s)" in text
    assert "ball1" in text
    assert main(["scenes", "check", str(SCENE)]) == 0


@pytest.mark.parametrize(("agent", "recording", "picture"), SEARCHES)
def test_an_agent_acts_as_it_did(agent, recording, picture, tmp_path):
    """The same search, look by look."""
    code = main(
        ["search", str(OLD / agent), "--picture", str(OLD / agent / "targets" / "toy_0" / picture), "--robot",
         f"scene:{SCENE}", "--seed", "3", "--threads", "1", "--record", str(tmp_path / "again")]
    )  # fmt: skip
    assert code == 0
    *then, end = steps(OLD / recording)
    *now, end_now = steps(tmp_path / "again")
    assert len(now) == len(then) >= 4
    for old, new in zip(then, now, strict=True):
        assert (new["action"], new["found"], new["pose"]) == (old["action"], old["found"], old["pose"])
        assert new["probabilities"] == pytest.approx(old["probabilities"], abs=0.02)
        assert new["score"] == pytest.approx(old["score"], abs=0.02)
    assert (end_now["found"], end_now["reason"]) == (end["found"], end["reason"]) == (True, "found")


@pytest.mark.parametrize("agent", ["agent", "view_agent"])
def test_an_agent_is_measured_as_it_was(agent, tmp_path):
    """Which takes all that its configuration says of its training."""
    shutil.copytree(OLD / agent, tmp_path / "agent")
    config = tmp_path / "agent" / "config.json"
    config.write_text(config.read_text().replace("/data/toy_0.h5", str(SCENE)))
    out = tmp_path / "result.json"
    assert main(["evaluate", str(tmp_path / "agent"), "--searches", "2", "--out", str(out)]) == 0
    then, now = (json.loads(path.read_text()) for path in (OLD / agent / "result.json", out))
    assert [row["target"] for row in now["per_target"]] == [row["target"] for row in then["per_target"]]
    for name in ("success", "mean_steps", "shortest_mean"):
        assert now["overall"][name] == pytest.approx(then["overall"][name], rel=0.01)


@pytest.mark.parametrize(("agent", "recording", "picture"), SEARCHES)
def test_a_recording_is_reported(agent, recording, picture, tmp_path, capsys):
    out = tmp_path / "report"
    assert main(["report", str(OLD / recording), "--out", str(out)]) == 0
    *looks, _ = steps(OLD / recording)
    assert f"found after {len(looks) - 1} actions" in capsys.readouterr().out
    made = json.loads((out / "search.json").read_text())
    assert [step["action"] for step in made["steps"]] == [look["action"] for look in looks]
    assert (made["found"], made["scene"]) == (True, "toy_0")
    assert (out / "path.png").exists(), "the poses, or the floor, are lost"


def test_settings_of_a_robot_are_read_whole(tmp_path):
    """Keys may have other names by now, but no value is lost."""
    save_config(load_config(OLD / "robot.yaml"), tmp_path / "again.yaml")
    then, now = (yaml.safe_load(path.read_text()) for path in (OLD / "robot.yaml", tmp_path / "again.yaml"))
    assert leaves(now) == leaves(then)


def leaves(value):
    """The values in nested dictionaries, in their order."""
    return [leaf for item in value.values() for leaf in leaves(item)] if isinstance(value, dict) else [value]


def test_a_journal_is_saved_into_its_scene(tmp_path, capsys):
    for name in ("toy_0.h5", "toy_0.h5.labels.jsonl"):
        shutil.copyfile(OLD / name, tmp_path / name)
    before = load_scene(SCENE)
    assert main(["scenes", "label", str(tmp_path / "toy_0.h5"), "--propose", str(OLD / "agent")]) == 0
    assert "an earlier command left in its journal: 2" in capsys.readouterr().out
    after = load_scene(tmp_path / "toy_0.h5")
    # View 3 as its last change has it; view 5 was emptied there, and has been filled by the agent since.
    np.testing.assert_array_equal(after.boxes[3], [[0.5, 0.5, 0.25, 0.25], [np.nan] * 4])
    states = label_states(after)
    assert (states[3], states[5], UNLABELLED in states) == (PROPOSED, PROPOSED, False)
    others = np.delete(np.arange(len(before)), [3, 5])
    assert (states[others] == LABELLED).all()
    np.testing.assert_array_equal(after.boxes[others], before.boxes[others])
    assert not (tmp_path / "toy_0.h5.labels.jsonl").exists()
