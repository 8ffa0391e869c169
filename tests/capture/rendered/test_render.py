"""`scenes render`: what it refuses, and that an interruption costs nothing but the time until it."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from active_perceiver.capture.rendered import capture_scene as capture_module
from active_perceiver.capture.rendered import render as rendering
from active_perceiver.capture.rendered.config import CaptureConfig, CaptureError
from active_perceiver.capture.rendered.render import RoomChange, Timing, render_scene, render_scenes, room_fingerprint
from active_perceiver.cli.main import main
from active_perceiver.errors import UserError
from active_perceiver.parallel import run_store
from active_perceiver.parallel.run_store import RunStoreError
from active_perceiver.scenes import TURTLEBOT_ACTIONS, load_scene
from active_perceiver.utils.files import OutputExistsError
from box_room import box_room
from indoor_rooms.layouts import LayoutError
from indoor_rooms.renderer import compiled
from indoor_rooms.renderer.camera_faults import CameraFaults
from indoor_rooms.room import Room

SMALL = CaptureConfig(
    actions=TURTLEBOT_ACTIONS, spacing=0.5, places=3, image_size=32, bake_rays=4, bounces=1, tilts=(-25.0, 0.0),
    faults=CameraFaults(),
)  # fmt: skip


def make_box_room(layout: str, seed: int, hour: str | None = None, moved: int | None = None) -> Room:
    room = box_room()
    lamps = room.lamps if hour is None else tuple(replace(lamp, radiance=(0.2, 0.2, 0.3)) for lamp in room.lamps)
    return replace(room, name=f"{layout}_{seed}", lamps=lamps)


@pytest.fixture(scope="module", autouse=True)
def box_rooms(small_work: pytest.MonkeyPatch) -> None:
    """One setup of target pictures in rooms with a box."""
    small_work.setattr(capture_module, "SETUPS", 1)
    small_work.setattr(capture_module, "HELD_OUT", 1)
    small_work.setattr(rendering, "make_room", make_box_room)


@pytest.fixture(scope="module")
def whole(box_rooms: None, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A scene rendered without interruption."""
    path = tmp_path_factory.mktemp("whole") / "box.h5"
    render_scene("kitchen", 5, path, settings=SMALL)
    return path


def interrupt(patch: pytest.MonkeyPatch, name: str, after: int) -> list[int]:
    """From the call number `after` on, a function of the capture raises KeyboardInterrupt."""
    calls: list[int] = []
    function = getattr(capture_module, name)

    def limited(*arguments, **options):  # type: ignore[no-untyped-def]
        if len(calls) == after:
            raise KeyboardInterrupt
        calls.append(1)
        return function(*arguments, **options)

    patch.setattr(capture_module, name, limited)
    return calls


@pytest.fixture
def interrupted(tmp_path: Path) -> Path:
    """The scene file of a rendering that was interrupted after five views."""
    path = tmp_path / "box.h5"
    with pytest.MonkeyPatch.context() as patch:
        interrupt(patch, "render", 5)
        with pytest.raises(KeyboardInterrupt):
            render_scene("kitchen", 5, path, settings=SMALL)
    assert not path.exists()
    return path


def test_another_hour_is_the_same_lattice_in_another_light(whole: Path, tmp_path: Path) -> None:
    path = tmp_path / rendering.default_name("kitchen", 5, RoomChange("low sun"))
    assert path.name == "kitchen_5_hour_low_sun.h5"
    render_scene("kitchen", 5, path, settings=SMALL, change=RoomChange(hour="low sun"))
    scene, other = load_scene(whole), load_scene(path)
    np.testing.assert_array_equal(scene.poses, other.poses)
    np.testing.assert_array_equal(scene.transitions, other.transitions)
    np.testing.assert_array_equal(scene.boxes, other.boxes)
    assert scene.views != other.views
    assert other.source.endswith("; hour low sun")
    assert rendering.origin_of(scene) == rendering.origin_of(other) == ("kitchen", 5)


def test_names_of_files_tell_rooms_apart() -> None:
    changes = [(None, None), ("dusk", None), (None, 1), (None, 2), ("dusk", 1)]
    names = [rendering.default_name("kitchen", 1, RoomChange(*change)) for change in changes]
    assert names[0] == "kitchen_1.h5"
    assert len(set(names)) == len(names)


def test_a_scene_of_somebody_else_has_no_origin(whole: Path) -> None:
    with pytest.raises(CaptureError, match="was not rendered by this software"):
        rendering.origin_of(replace(load_scene(whole), source="photographs"))


def test_the_scene_is_a_turtlebot_s(whole: Path) -> None:
    scene = load_scene(whole)
    assert scene.name == "box"
    assert scene.actions == TURTLEBOT_ACTIONS
    assert len(scene) == 3 * 4 * 2
    assert [(target.name, target.category, target.held_out) for target in scene.targets] == [("box", "carton", 1)]
    assert [path.name for path in whole.parent.iterdir()] == ["box.h5"]


def test_the_camera_s_faults_are_in_the_views_and_not_in_the_boxes(whole: Path, tmp_path: Path) -> None:
    render_scene("kitchen", 5, tmp_path / "box.h5", settings=replace(SMALL, faults=None))
    perfect, real = load_scene(tmp_path / "box.h5"), load_scene(whole)
    np.testing.assert_array_equal(perfect.boxes, real.boxes)
    difference = [(real.view(s).astype(float) - perfect.view(s)).mean() for s in range(len(real))]
    assert np.std(difference) > 3  # brighter and darker ones
    assert np.abs(difference).max() < 60
    assert perfect.targets == real.targets


@pytest.mark.parametrize(("name", "after"), [("bake", 0), ("render", 0), ("render", 7), ("studio_pictures", 0)])
def test_resumed_and_uninterrupted_give_the_same_bytes(
    whole: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, name: str, after: int
) -> None:
    path = tmp_path / "box.h5"
    with monkeypatch.context() as patch:
        interrupt(patch, name, after)
        with pytest.raises(KeyboardInterrupt):
            render_scene("kitchen", 5, path, settings=SMALL)
    with monkeypatch.context() as patch:
        calls = interrupt(patch, name, 1000)
        render_scene("kitchen", 5, path, settings=SMALL, resume=True)
    assert len(calls) == {"bake": 1, "render": 24, "studio_pictures": 1}[name] - after
    assert path.read_bytes() == whole.read_bytes()
    assert [entry.name for entry in tmp_path.iterdir()] == ["box.h5"]


@pytest.mark.parametrize("cut", [0, 10, -1])
@pytest.mark.parametrize("piece", ["view-00002.npz", "light.npz"])
def test_damaged_pieces_are_made_again(whole: Path, interrupted: Path, piece: str, cut: int) -> None:
    broken = interrupted.with_name("box.h5.part") / piece
    broken.write_bytes(broken.read_bytes()[:cut])
    broken.with_name(".view-00003.npz.abc.part.npz").write_bytes(b"left by a kill")
    render_scene("kitchen", 5, interrupted, settings=SMALL, resume=True)
    assert interrupted.read_bytes() == whole.read_bytes()


def test_an_interrupted_rendering_is_neither_lost_nor_mixed(
    whole: Path, interrupted: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    with pytest.raises(OutputExistsError, match=r"--resume .* --force"):
        render_scene("kitchen", 5, interrupted, settings=SMALL)
    with pytest.raises(RunStoreError, match="other settings"):
        render_scene("kitchen", 6, interrupted, settings=SMALL, resume=True)
    with pytest.raises(RunStoreError, match="other settings"):
        render_scene("kitchen", 5, interrupted, settings=replace(SMALL, fov=80.0), resume=True)
    with monkeypatch.context() as patch:
        patch.setattr(run_store, "__version__", "99")
        with pytest.raises(RunStoreError, match="other settings"):
            render_scene("kitchen", 5, interrupted, settings=SMALL, resume=True)
    with monkeypatch.context() as patch:
        other = replace(box_room(), name="kitchen_5", sky=(0.0, 0.1, 0.0))
        patch.setattr(rendering, "make_room", lambda *_, **__: other)
        with pytest.raises(RunStoreError, match="other settings"):
            render_scene("kitchen", 5, interrupted, settings=SMALL, resume=True)
    part = interrupted.with_name("box.h5.part")
    assert len(list(part.glob("view-*"))) == 5
    (part / "settings.json").write_text("{")
    with pytest.raises(RunStoreError, match="other settings"):
        render_scene("kitchen", 5, interrupted, settings=SMALL, resume=True)
    render_scene("kitchen", 5, interrupted, settings=SMALL, force=True)
    assert interrupted.read_bytes() == whole.read_bytes()


def test_light_of_another_mesh_is_refused(interrupted: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(compiled, "MAX_TRIANGLES", 3000)
    with pytest.raises(CaptureError, match="not the light of room"):
        render_scene("kitchen", 5, interrupted, settings=SMALL, resume=True)


def test_what_is_no_rendering_is_not_touched(tmp_path: Path) -> None:
    part = tmp_path / "box.h5.part"
    part.mkdir()
    (part / "diary.txt").write_text("dear diary")
    for options in ({}, {"force": True}, {"resume": True}):
        with pytest.raises(OutputExistsError, match="will not be replaced"):
            render_scene("kitchen", 5, tmp_path / "box.h5", settings=SMALL, **options)
    assert (part / "diary.txt").read_text() == "dear diary"


def test_refused_before_anything_is_rendered(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    there = tmp_path / "there.h5"
    there.write_bytes(b"precious")
    for out, message in ((there, "--force"), (tmp_path / "folder", "--count"), (tmp_path / "room.png", r"\.h5")):
        with pytest.raises(UserError, match=message):
            render_scene("kitchen", 5, out, settings=SMALL)
    assert there.read_bytes() == b"precious"
    monkeypatch.undo()
    monkeypatch.setattr(rendering, "make_room", lambda *_, **__: (_ for _ in ()).throw(LayoutError("no castle")))
    with pytest.raises(LayoutError):
        render_scene("castle", 1, tmp_path / "castle.h5")
    assert [path.name for path in tmp_path.iterdir()] == ["there.h5"]


def test_several_rooms_skip_what_is_done(whole: Path, tmp_path: Path) -> None:
    (tmp_path / "kitchen_5.h5").write_bytes(whole.read_bytes())
    with pytest.raises(OutputExistsError, match="--resume keeps"):
        list(render_scenes("kitchen", range(4, 6), tmp_path, settings=SMALL))
    rendered = dict(render_scenes("kitchen", range(4, 6), tmp_path, settings=SMALL, resume=True))
    assert [timing is None for timing in rendered.values()] == [False, True]
    assert [load_scene(path).name for path in rendered] == ["kitchen_4", "box"]


def test_fingerprints_tell_rooms_apart() -> None:
    room = box_room()
    assert room_fingerprint(room) == room_fingerprint(box_room())
    moved = replace(room.parts[-1], mesh=replace(room.parts[-1].mesh, vertices=room.parts[-1].mesh.vertices + 0.01))
    for change in ({"sky": (0.0, 0.0, 1.0)}, {"parts": (*room.parts[:-1], moved)}, {"obstacles": ()}):
        assert room_fingerprint(replace(room, **change)) != room_fingerprint(room)


def test_the_time_says_how_fast_it_was() -> None:
    timing = Timing(workers=2, seconds={"light": 5.0, "views": 10.0, "target pictures": 5.0}, done={"views": 40})
    assert "20.0 s: light 5.0 s" in timing.text()
    assert "4.00 views/s while rendering them (2.00 per process), 2.00 over all (1.00 per process)" in timing.text()
    assert "views/s" not in Timing(workers=2, seconds={"views": 0.1}).text()  # all were there


def test_the_command_renders_and_goes_on(
    whole: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    command = [
        "scenes",
        "render",
        "kitchen",
        "--seed",
        "5",
        "--spacing",
        "0.8",
        "--places",
        "2",
        "--image-size",
        "32",
    ]
    with monkeypatch.context() as patch:
        interrupt(patch, "render", 3)
        assert main(command) == 130
    assert "--resume" in capsys.readouterr().err
    assert main(command) == 2
    assert main([*command, "--resume"]) == 0
    assert "views/s" in capsys.readouterr().out
    assert len(load_scene("kitchen_5.h5")) == 2 * 4 * 3
    assert main([*command, "--count", "2", "--resume"]) == 0
    assert sorted(path.name for path in tmp_path.iterdir()) == ["kitchen_5.h5", "kitchen_6.h5"]
    assert "was there" in capsys.readouterr().out
    assert main([*command, "--count", "0"]) == 2
    assert main([*command, "--force", "--places", "9999"]) == 2
    assert "positions" in capsys.readouterr().err
