"""`scenes capture room`: a folder of photographs, its interruptions, and what it never replaces."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from active_perceiver.capture.rendered import capture_scene, photographs
from active_perceiver.capture.rendered.config import CaptureConfig, CaptureError
from active_perceiver.capture.rendered.photographs import PhotographConfig, take_photographs
from active_perceiver.cli.main import main
from active_perceiver.datasets.photos.reader import PhotoConfig, import_photos
from active_perceiver.parallel.run_store import RunStoreError
from active_perceiver.utils.files import OutputExistsError
from box_room import box_room
from indoor_rooms.renderer import compiled

SMALL = CaptureConfig(spacing=0.6, places=1, bake_rays=2, bounces=1, tilts=(-25.0, 0.0))
PHOTOGRAPHER = PhotographConfig(width=48)
SETUPS = 2


@pytest.fixture(scope="module", autouse=True)
def box_rooms(small_work: pytest.MonkeyPatch) -> None:
    """A room with a box, and few pictures of it."""
    small_work.setattr(compiled, "MAX_TRIANGLES", 300)
    small_work.setattr(photographs, "make_room", lambda layout, seed: box_room())
    small_work.setattr(capture_scene, "SETUPS", SETUPS)
    small_work.setattr(capture_scene, "HELD_OUT", 1)


def take(folder: Path, photographer: PhotographConfig = PHOTOGRAPHER, seed: int = 1, **options: Any) -> int:
    return take_photographs("kitchen", seed, folder, photographer, **{"settings": SMALL, **options})


def content(folder: Path) -> dict[str, bytes]:
    """All files in a folder."""
    return {str(path.relative_to(folder)): path.read_bytes() for path in folder.rglob("*") if path.is_file()}


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> dict[str, bytes]:
    """What is written if nothing interrupts it."""
    folder = tmp_path_factory.mktemp("whole") / "photos"
    assert take(folder) == 8
    assert [path.name for path in folder.parent.iterdir()] == ["photos"]
    return content(folder)


@pytest.fixture
def folder(tmp_path: Path, whole: dict[str, bytes]) -> Path:
    """The photographs in a folder that may be changed."""
    written = tmp_path / "photos"
    for name, data in whole.items():
        (written / name).parent.mkdir(parents=True, exist_ok=True)
        (written / name).write_bytes(data)
    return written


def interrupting(monkeypatch: pytest.MonkeyPatch, module: Any, name: str, after: int) -> list[int]:
    """Let a function of a module be interrupted the next time after so many calls; the list counts its calls."""
    calls: list[int] = []
    real = getattr(module, name)

    def interrupted(*arguments: Any, **options: Any) -> Any:
        calls.append(1)
        if len(calls) == after + 1:
            raise KeyboardInterrupt
        return real(*arguments, **options)

    monkeypatch.setattr(module, name, interrupted)
    return calls


def test_the_folder_is_what_is_imported(folder: Path, whole: dict[str, bytes]) -> None:
    names = {f"IMG_{number:04}.jpg" for number in range(1, 9)} | {"poses.csv", "annotations.json"}
    assert {name for name in whole if not name.startswith("targets")} == names
    imported = import_photos(folder, PhotoConfig(image_size=48))
    assert len(imported.scene) == 8
    assert imported.scene.target_names == tuple(box_room().targets)
    assert np.nanmax(imported.scene.areas) > 0


@pytest.mark.parametrize(
    ("module", "name", "after", "all_calls"),
    [
        (capture_scene, "bake", 0, 1),
        (photographs, "look", 5, 8),
        (capture_scene, "studio_pictures", 1, SETUPS),
        (photographs, "write_poses", 0, 1),
    ],
)
def test_interrupted_work_goes_on_to_the_same_files(
    module: Any, name: str, after: int, all_calls: int, whole: dict[str, bytes], tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:  # fmt: skip
    folder = tmp_path / "photos"
    calls = interrupting(monkeypatch, module, name, after)
    with pytest.raises(KeyboardInterrupt):
        take(folder)
    assert [path.name for path in tmp_path.iterdir()] == ["photos.part"]
    with pytest.raises(OutputExistsError, match="--resume goes on with it, --force begins anew"):
        take(folder)
    take(folder, resume=True)
    assert len(calls) == all_calls + 1  # only what was interrupted is done again
    assert content(folder) == whole
    assert [path.name for path in tmp_path.iterdir()] == ["photos"]


def test_work_begun_otherwise_is_not_gone_on_with(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    folder = tmp_path / "photos"
    interrupting(monkeypatch, photographs, "look", 3)
    with pytest.raises(KeyboardInterrupt):
        take(folder)
    before = content(tmp_path)
    others: list[dict[str, Any]] = [{"seed": 2}, {"settings": replace(SMALL, places=2)}]
    others += [{"photographer": replace(PHOTOGRAPHER, **change)} for change in ({"width": 64}, {"error_cm": 0.0})]
    for other in others:
        with pytest.raises(RunStoreError, match="begun with other settings"):
            take(folder, resume=True, **other)
        assert content(tmp_path) == before


def test_force_begins_interrupted_work_anew(
    whole: dict[str, bytes], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    folder = tmp_path / "photos"
    calls = interrupting(monkeypatch, photographs, "look", 3)
    with pytest.raises(KeyboardInterrupt):
        take(folder, seed=2)
    take(folder, force=True)
    assert len(calls) == 4 + 8
    assert content(folder) == whole


def test_force_replaces_an_earlier_folder_and_only_when_all_is_there(
    folder: Path, whole: dict[str, bytes], monkeypatch: pytest.MonkeyPatch
) -> None:
    with pytest.raises(OutputExistsError, match="--force to replace it"):
        take(folder, seed=2)
    with monkeypatch.context() as patch:
        interrupting(patch, photographs, "look", 3)
        with pytest.raises(KeyboardInterrupt):
            take(folder, seed=2, force=True)
    assert content(folder) == whole
    take(folder, seed=2, force=True, resume=True)
    assert content(folder).keys() == whole.keys()
    assert content(folder)["poses.csv"] != whole["poses.csv"]
    assert [path.name for path in folder.parent.iterdir()] == ["photos"]


@pytest.mark.parametrize(
    "foreign",
    ["notes.txt", "moves.csv", "IMG_0001.png", "IMG_mine.jpg", "sub/IMG_0001.jpg", "targets/list.txt",
     "targets/box/mine.jpg", "targets/box/01.png", ".git/config"],
)  # fmt: skip
@pytest.mark.parametrize("resume", [False, True])
def test_a_folder_with_anything_else_is_never_replaced(foreign: str, resume: bool, folder: Path) -> None:
    (folder / foreign).parent.mkdir(exist_ok=True)
    (folder / foreign).write_text("precious")
    before = content(folder.parent)
    with pytest.raises(OutputExistsError, match=r"photos holds other things than .*; give another name"):
        take(folder, force=True, resume=resume)
    assert content(folder.parent) == before


@pytest.mark.parametrize("boxes", [None, b"", b"[]", b"{}", b'{"info": {"description": "my room"}}'])
def test_photographs_that_somebody_took_are_never_replaced(boxes: bytes | None, folder: Path) -> None:
    """Cameras call their files the same; the boxes say who made the folder."""
    if boxes is None:
        (folder / "annotations.json").unlink()
    else:
        (folder / "annotations.json").write_bytes(boxes)
    before = content(folder.parent)
    with pytest.raises(OutputExistsError, match="give another name"):
        take(folder, force=True)
    assert content(folder.parent) == before


def test_files_and_links_are_never_replaced_but_an_empty_folder_is(
    folder: Path, whole: dict[str, bytes], tmp_path: Path
) -> None:
    file, link, empty = tmp_path / "file", tmp_path / "link", tmp_path / "empty"
    file.write_text("precious")
    link.symlink_to(folder)
    empty.mkdir()
    for path in (file, link):
        with pytest.raises(OutputExistsError, match="give another name"):
            take(path, force=True)
    assert file.read_text() == "precious"
    assert content(folder) == whole
    take(empty, force=True)
    assert content(empty) == whole


def test_another_folder_is_not_taken_for_interrupted_work(tmp_path: Path) -> None:
    part = tmp_path / "photos.part"
    part.mkdir()
    (part / "thesis.tex").write_text("precious")
    for options in ({}, {"force": True}, {"resume": True}):
        with pytest.raises(OutputExistsError, match="no interrupted run"):
            take(tmp_path / "photos", **options)
    assert content(tmp_path) == {"photos.part/thesis.tex": b"precious"}


def test_what_cannot_be_taken_is_refused_before_any_work(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(CaptureError, match="no target 'dragon'"):
        take(tmp_path / "photos", PhotographConfig(width=48, targets=("dragon",)))
    with pytest.raises(CaptureError, match="in the furniture; give a jitter_cm of at most 14"):
        take(tmp_path / "photos", PhotographConfig(width=48, jitter_cm=30.0))
    with pytest.raises(CaptureError, match="noise must be in"):
        PhotographConfig(noise=float("nan"))
    assert main(["scenes", "capture", "room", "kitchen", "--out", str(tmp_path / "photos"), "--width", "9"]) == 2
    assert "width must be in 32..4096 pixels, got 9" in capsys.readouterr().err
    assert list(tmp_path.iterdir()) == []
