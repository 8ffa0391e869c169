"""docs/robot.md is true: its code runs, its settings can be read, and it names all that there is to set."""

import dataclasses
import re
import shutil
from pathlib import Path

import pytest

from active_perceiver.robots import Robot
from active_perceiver.robots.base import Limits
from active_perceiver.robots.ros_settings import Camera, Connection, RosSettings
from active_perceiver.robots.ros_settings_file import load_settings, presets
from toy import toy_scene

PAGE = Path(__file__).parents[2] / "docs" / "robot.md"
TEXT = PAGE.read_text()


def blocks(language):
    return re.findall(rf"^```{language}\n(.*?)^```$", TEXT, re.DOTALL | re.MULTILINE)


@pytest.mark.xdist_group("agent")
@pytest.mark.parametrize(("answer", "moved"), [("", True), ("blocked", False)])
def test_the_robot_of_the_page_searches(answer, moved, agent_folder, tmp_path, monkeypatch, capsys):
    scene = toy_scene()
    (code,) = blocks("python")
    asked = []
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("builtins.input", lambda text: asked.append(text) or answer)
    shutil.copytree(agent_folder, "agent")
    Path("mug.jpg").write_bytes(scene.targets[1].pictures[0])
    # Another object, at which the search does not end.
    Path("frame.jpg").write_bytes(scene.targets[0].pictures[0])
    code = code.replace("TURTLEBOT_ACTIONS", "EIGHT_ACTIONS")  # as the toy scene has
    page = {"__name__": "page"}
    exec(compile(code, f"{PAGE}, python", "exec"), page)
    record = page["record"]
    assert isinstance(page["robot"], Robot)
    assert len(asked) == record.actions > 0
    assert all(glimpse.moved is moved for glimpse in record.glimpses[1:])
    said = capsys.readouterr().out.splitlines()
    assert said[-1] == f"{record.ending} after {record.actions} actions"
    assert said.count("stand still") == 2  # the search's end, and the robot's


def test_it_is_a_robot_in_few_lines():
    (code,) = blocks("python")
    assert len(code[code.index("class") : code.index("with ")].split("\n")) <= 25


def test_the_settings_of_the_page_can_be_read(tmp_path):
    (text,) = blocks("yaml")
    (tmp_path / "robot.yaml").write_text(text)
    settings = load_settings(tmp_path / "robot.yaml")
    assert settings.tilts == (-25.0, 0.0)
    assert settings.limits.speed == 0.1


def test_the_page_names_every_key_and_preset():
    table = TEXT[TEXT.index("| key |") : TEXT.index("Unknown keys")]
    keys = {name for kind in (RosSettings, Camera, Connection, Limits) for name in names_of(kind)} - {"camera"}
    assert keys == {name for name in keys if re.search(rf"`(camera)?\.?{name}`", table)}
    assert {name for name in presets() if f"| `{name}` |" in TEXT} == set(presets())


def names_of(kind):
    return [field.name for field in dataclasses.fields(kind)]
