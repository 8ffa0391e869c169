"""`scenes preview`: rooms are looked at before they are photographed."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from active_perceiver.cli.main import main
from indoor_rooms import preview as preview_module
from indoor_rooms.preview import Look


def look(name: str, problems: tuple[str, ...] = (), views: int = 2, size: int = 40) -> Look:
    return Look(name, list(problems), 20, 60, [np.full((size, size, 3), 90, np.uint8)] * views)


def test_the_command_says_what_is_wrong(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    looks = [look("kitchen_1"), look("kitchen_2", ("mug floats 20 mm above table",))]
    monkeypatch.setattr(preview_module, "look_at_rooms", lambda *_, **__: looks)
    picture, out = tmp_path / "rooms.jpg", tmp_path / "rooms.json"
    arguments = ["scenes", "preview", "kitchen", "--count", "2", "--picture", str(picture), "--out", str(out)]
    assert main(arguments) == 1
    text = capsys.readouterr().out
    assert "mug floats 20 mm above table" in text
    assert "1 of 2 rooms are sound" in text
    assert Image.open(picture).format == "JPEG"
    assert [room["problems"] for room in json.loads(out.read_text())["rooms"]] == [[], looks[1].problems]
    assert main(arguments) == 2
    monkeypatch.setattr(preview_module, "look_at_rooms", lambda *_, **__: looks[:1])
    assert main([*arguments, "--force"]) == 0


@pytest.mark.parametrize("wrong", [["--count", "0"], ["--views", "5"], ["--views", "0"]])
def test_wrong_numbers_are_explained(wrong: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["scenes", "preview", "kitchen", *wrong]) == 2
    assert "--count is at least 1" in capsys.readouterr().err.replace("\n", " ")


def test_a_benchmark_does_not_overwrite(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    out = tmp_path / "render.json"
    out.write_text("precious")
    assert main(["benchmark", "render", "kitchen", "--out", str(out)]) == 2
    assert out.read_text() == "precious"
