"""The package as it is met: its public names, its README, and the command `python -m indoor_rooms`."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

import indoor_rooms
from indoor_rooms import __main__ as command
from indoor_rooms.preview import Look

ROOT = Path(__file__).parents[1]


@pytest.fixture
def looked(monkeypatch: pytest.MonkeyPatch) -> list[tuple]:
    """Rooms that are made at once, and what was asked for; every second one is not sound."""
    asked: list[tuple] = []

    def look_at_rooms(layouts, seeds, views, image_size, progress):
        asked.append((layouts, tuple(seeds), views, image_size))
        names = [f"{layout}_{seed}" for layout in layouts for seed in seeds]
        grey = np.full((image_size, image_size, 3), 90, np.uint8)
        progress(len(names), len(names))
        return [
            Look(name, ["mug floats 20 mm above table"] * (number % 2), 20, 60, [grey] * views)
            for number, name in enumerate(names)
        ]

    monkeypatch.setattr(command, "look_at_rooms", look_at_rooms)
    return asked


def test_importing_it_needs_neither_embree_nor_anything_of_the_robot() -> None:
    code = (
        "import sys, indoor_rooms; indoor_rooms.make_room; "
        "print([name for name in ('embreex', 'mitsuba_oidn', 'active_perceiver') if name in sys.modules])"
    )
    assert subprocess.run([sys.executable, "-c", code], capture_output=True, text=True).stdout == "[]\n"


def test_every_public_name_is_there() -> None:
    assert set(indoor_rooms.__all__) <= set(dir(indoor_rooms))
    for name in indoor_rooms.__all__:
        assert getattr(indoor_rooms, name) is not None
    with pytest.raises(AttributeError, match="castle"):
        indoor_rooms.castle  # noqa: B018
    assert "kitchen" in indoor_rooms.LAYOUTS
    assert "mug" in indoor_rooms.OBJECTS
    version = re.search(r'^version = "(.*)"', (ROOT / "pyproject.toml").read_text(), re.MULTILINE)
    assert version is not None
    assert version[1] == indoor_rooms.__version__


def test_the_readme_runs(capsys: pytest.CaptureFixture[str]) -> None:
    text = (ROOT / "README.md").read_text()
    (code,) = re.findall(r"^```python\n(.*?)^```$", text, re.DOTALL | re.MULTILINE)
    exec(compile(code, "README.md", "exec"), {})
    shapes, seen, targets = capsys.readouterr().out.splitlines()
    assert shapes == "(300, 300, 3) (300, 300) (300, 300)"
    assert "floor" in seen
    assert "mug" in targets
    for link in re.findall(r"\]\(([^)#]+)\)", text):
        assert (ROOT / link).exists(), link
    for line in re.findall(r"^python -m indoor_rooms (.*)$", text, re.MULTILINE):
        command._parser().parse_args(line.split())


def test_a_preview_is_written_and_not_overwritten(
    looked: list[tuple], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "rooms.jpg"
    arguments = ["preview", "kitchen", "--seed", "3", "--image-size", "40", "--out", str(out)]
    assert command.main(arguments) == 0
    assert looked == [(("kitchen",), (3,), 2, 40)]
    assert Image.open(out).format == "JPEG"
    assert "kitchen_3: 60 places, 20 targets" in capsys.readouterr().out
    out.write_bytes(b"mine")
    assert command.main(arguments) == 2
    assert out.read_bytes() == b"mine"
    assert "--force" in capsys.readouterr().err
    assert len(looked) == 1
    assert command.main([*arguments, "--force"]) == 0
    assert Image.open(out).format == "JPEG"
    assert list(tmp_path.iterdir()) == [out]


def test_rooms_that_are_not_sound_are_told(
    looked: list[tuple], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert command.main(["preview", "--count", "2", "--out", str(tmp_path / "rooms.png")]) == 1
    assert looked[0][:2] == (tuple(indoor_rooms.LAYOUTS), (1, 2))
    assert capsys.readouterr().out.count("mug floats 20 mm above table") == 3


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (["castle"], "no room layout 'castle'"),
        (["--seed", "0"], "--seed is at least 1"),
        (["--count", "0"], "--count is at least 1"),
        (["--views", "5"], "--views is 1 to 4"),
        (["--views", "0"], "--views is 1 to 4"),
        (["--image-size", "0"], "--image-size is at least 16"),
        (["--out", "rooms.txt"], "is no picture"),
        (["--out", "nowhere/rooms.jpg"], "no folder nowhere"),
    ],
    ids=str,
)
def test_what_cannot_be_had_is_refused_at_once(
    looked: list[tuple], options: list[str], message: str, capsys: pytest.CaptureFixture[str],
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch,
) -> None:  # fmt: skip
    monkeypatch.chdir(tmp_path)
    assert command.main(["preview", *options]) == 2
    assert message in capsys.readouterr().err
    assert looked == []
    assert list(tmp_path.iterdir()) == []


def test_the_help_has_examples_that_parse(capsys: pytest.CaptureFixture[str]) -> None:
    for arguments in (["--help"], ["preview", "--help"]):
        with pytest.raises(SystemExit) as ended:
            command.main(arguments)
        assert ended.value.code == 0
        text = capsys.readouterr().out
        lines = re.findall(r"python -m indoor_rooms (preview ?.*)$", text.split("examples:")[1], re.MULTILINE)
        assert len(lines) == 3
        for line in lines:
            command._parser().parse_args(line.split())
