"""Looking at rooms before they are photographed."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from active_perceiver.cli import main
from active_perceiver.rooms import preview as preview_module
from active_perceiver.rooms.free_space import FreeSpaceError
from active_perceiver.rooms.layouts import LayoutError
from active_perceiver.rooms.preview import Look, look_at_rooms, preview, preview_sheet
from box_room import box_room


def look(name: str, problems: tuple[str, ...] = (), views: int = 2, size: int = 40) -> Look:
    return Look(name, list(problems), 20, 60, [np.full((size, size, 3), 90, np.uint8)] * views)


def test_pictures_are_taken_from_different_corners() -> None:
    pictures = preview(box_room(), 2, 32, rays=4)
    assert [picture.shape for picture in pictures] == [(32, 32, 3)] * 2
    assert np.abs(pictures[0].astype(int) - pictures[1]).mean() > 5
    np.testing.assert_array_equal(pictures[0], preview(box_room(), 1, 32, rays=4)[0])


def test_a_room_without_a_place_is_explained() -> None:
    room = box_room()
    block = np.array([[0.0, 0.0], [4.0, 0.0], [4.0, 3.0], [0.0, 3.0]])
    with pytest.raises(FreeSpaceError):
        preview(type(room)(**{**vars(room), "obstacles": (("block", block),)}), 1, 16, rays=1)


def test_generated_rooms_are_looked_at_in_their_order() -> None:
    looks = look_at_rooms(("kitchen",), (1, 2), workers=1)
    assert [item.name for item in looks] == ["kitchen_1", "kitchen_2"]
    assert all(item.problems == [] and item.places >= 30 and item.pictures == [] for item in looks)
    with pytest.raises(LayoutError, match="castle"):
        look_at_rooms(("castle",), (1,), workers=1)


def test_the_sheet_holds_all_rooms() -> None:
    sheet = preview_sheet([look(f"room_{number}") for number in range(4)], columns=3)
    assert sheet.width > 3 * 80
    assert sheet.height > 2 * 40
    assert (np.asarray(sheet) == 90).all(axis=2).sum() == 4 * 2 * 40 * 40


def test_the_command_says_what_is_wrong(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    looks = [look("kitchen_1"), look("kitchen_2", ("mug floats 20 mm above table",))]
    monkeypatch.setattr(preview_module, "look_at_rooms", lambda *_: looks)
    picture, out = tmp_path / "rooms.jpg", tmp_path / "rooms.json"
    arguments = ["scenes", "preview", "kitchen", "--count", "2", "--picture", str(picture), "--out", str(out)]
    assert main(arguments) == 1
    text = capsys.readouterr().out
    assert "mug floats 20 mm above table" in text
    assert "1 of 2 rooms are sound" in text
    assert Image.open(picture).format == "JPEG"
    assert [room["problems"] for room in json.loads(out.read_text())["rooms"]] == [[], looks[1].problems]
    assert main(arguments) == 2
    monkeypatch.setattr(preview_module, "look_at_rooms", lambda *_: looks[:1])
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
