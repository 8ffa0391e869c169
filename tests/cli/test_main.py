"""The command line, as a user types it."""

import dataclasses
import json
import re
import subprocess
import sys

import pytest
from PIL import Image

from active_perceiver.cli.main import main
from active_perceiver.evaluation.config import EvaluateConfig
from active_perceiver.live.config import SessionConfig
from active_perceiver.scenes import save_scene
from active_perceiver.training.config import TrainConfig

COMMANDS = [
    [], ["demo"], ["train"], ["evaluate"], ["search"], ["report"], ["info"], ["scenes"], ["scenes", "list"],
    ["scenes", "info"], ["scenes", "check"], ["scenes", "render"], ["scenes", "label"],
    ["scenes", "capture", "robot"], ["scenes", "capture", "grid"], ["bridge"],
    *(["benchmark", name] for name in ("render", "env", "act", "export", "robustness", "robot", "train", "scale",
                                       "policies", "recogniser")),
]  # fmt: skip


@pytest.mark.parametrize("command", COMMANDS, ids=" ".join)
def test_help_shows_what_a_command_does_with_examples(command, capsys):
    with pytest.raises(SystemExit) as stopped:
        main([*command, "--help"])
    assert stopped.value.code == 0
    text = capsys.readouterr().out
    assert "usage: active-perceiver" in text
    if command and command != ["scenes"]:
        assert f"active-perceiver {' '.join(command)}" in text.split("Examples:")[1]


@pytest.mark.parametrize(
    ("command", "settings"), [("train", TrainConfig), ("evaluate", EvaluateConfig), ("search", SessionConfig)]
)
def test_every_setting_is_an_option_with_a_help_text(command, settings, capsys):
    with pytest.raises(SystemExit):
        main([command, "--help"])
    table = capsys.readouterr().out.split("settings options")[1].replace("│", " ")
    for field in dataclasses.fields(settings):
        # What is on by default is switched off by --no-...
        entry = re.split(rf"--(?:no-)?{field.name.replace('_', '-')} ", table)[1].split("(default")[0]
        assert len(re.findall(r"[a-z]{2,}", entry)) > 4, f"{field.name} has no help text"


def test_an_unknown_command_is_refused(capsys):
    with pytest.raises(SystemExit) as stopped:
        main(["dance"])
    assert stopped.value.code == 2


def test_brackets_in_an_error_are_shown(capsys, monkeypatch):
    from active_perceiver.cli.info import Info
    from active_perceiver.errors import UserError

    def fail(self):
        raise UserError("pip install 'active-perceiver[train]'")

    monkeypatch.setattr(Info, "run", fail)
    assert main(["info"]) == 2
    assert "active-perceiver[train]" in capsys.readouterr().err


def test_info_is_json(capsys):
    assert main(["info"]) == 0
    facts = json.loads(capsys.readouterr().out)
    assert facts["packages"]["numpy"]
    assert "kitchen_1" in facts["scenes"]


def test_scenes_list_names_the_bundled_kitchen(capsys):
    assert main(["scenes", "list"]) == 0
    assert "kitchen_1" in capsys.readouterr().out


def test_scenes_info_prints_and_draws(scene_file, tmp_path, capsys):
    picture = tmp_path / "sheet.png"
    assert main(["scenes", "info", str(scene_file), "--picture", str(picture)]) == 0
    text = capsys.readouterr().out
    assert "16 places, 12 views at each, 3 tilt(s)" in text
    assert "ball2" in text
    assert Image.open(picture).width > 1000
    assert main(["scenes", "info", str(scene_file), "--picture", str(picture)]) == 2
    assert main(["scenes", "info", str(scene_file), "--picture", str(picture), "--force"]) == 0


def test_scenes_check_tells_sound_from_unsound(scene, scene_file, tmp_path, capsys):
    assert main(["scenes", "check", str(scene_file)]) == 0
    broken = dataclasses.replace(scene, views=(b"broken", *scene.views[1:]))
    save_scene(broken, tmp_path / "broken.h5")
    assert main(["scenes", "check", str(tmp_path / "broken.h5")]) == 1
    assert "ERROR 1 views cannot be decoded" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["scenes", "info", "atlantis"], "neither a bundled scene"),
        (["scenes", "check", __file__], "not a readable HDF5 file"),
        (["evaluate", "nowhere"], "is not an agent"),
        (["train", "--out", "x", "--scenes", "atlantis"], "neither a bundled scene"),
    ],
)
def test_errors_are_sentences_without_traceback(arguments, message, capsys, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert main(arguments) == 2
    error = capsys.readouterr().err.replace("\n", " ")
    assert message in error
    assert "Traceback" not in error


def test_evaluate_measures_and_writes(agent_folder, tmp_path, capsys):
    out = tmp_path / "result.json"
    arguments = ["evaluate", str(agent_folder), "--out", str(out), "--searches", "20"]
    assert main(arguments) == 0
    assert "ball1" in capsys.readouterr().out
    exact = json.loads(out.read_text())
    assert exact["protocol"]["kind"] == "exact"
    assert 0.5 < exact["detection"]["pictures_seen"]["auroc"] <= 1
    assert set(exact["detection"]["pictures_seen"]["per_target"]) == {f"toy_0/ball{k}" for k in range(3)}
    assert main(arguments) == 2
    assert main([*arguments, "--protocol", "paper", "--episodes", "40", "--force"]) == 0
    paper = json.loads(out.read_text())
    assert paper["protocol"]["kind"] == "episodes"
    assert paper["overall"]["success"] == pytest.approx(exact["overall"]["success"], abs=0.1)


def test_search_prints_its_steps_and_writes_what_it_saw(agent_folder, scene, scene_file, tmp_path, capsys):
    picture = tmp_path / "ball.png"
    Image.fromarray(scene.targets[0].picture(0)).save(picture)
    out = tmp_path / "search"
    arguments = [
        "search", str(agent_folder), "--picture", str(picture), "--robot", f"scene:{scene_file}", "--seed", "4",
        "--max-steps", "40", "--out", str(out),
    ]  # fmt: skip
    code = main(arguments)
    text = capsys.readouterr().out
    record = json.loads((out / "search.json").read_text())
    assert code == (0 if record["found"] else 1)
    assert ("found after" in text) == record["found"]
    assert len(record["steps"]) == record["actions"] + 1
    written = {"search.mp4", "report.html", "path.png", "final.png", "search.json"}
    assert {path.name for path in out.iterdir()} == written
    assert main(arguments) == 2  # what is there is not overwritten


@pytest.mark.parametrize(("robot", "message"), [("moon:1", "is no robot"), ("scene:atlantis", "neither a bundled")])
def test_search_refuses_robots_it_cannot_drive(agent_folder, scene, tmp_path, capsys, robot, message):
    picture = tmp_path / "ball.png"
    Image.fromarray(scene.targets[0].picture(0)).save(picture)
    assert main(["search", str(agent_folder), "--picture", str(picture), "--robot", robot]) == 2
    assert message in capsys.readouterr().err.replace("\n", " ")


def test_python_dash_m_works():
    done = subprocess.run(
        [sys.executable, "-m", "active_perceiver", "scenes", "list"], capture_output=True, text=True, check=False
    )
    assert done.returncode == 0
    assert "kitchen_1" in done.stdout
