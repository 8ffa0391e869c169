"""`scenes elsewhere`: photographs of a scene's targets in other rooms."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from active_perceiver.capture.rendered import elsewhere, other_rooms
from active_perceiver.capture.rendered import render as rendering
from active_perceiver.capture.rendered.config import CaptureError
from active_perceiver.capture.rendered.elsewhere import render_elsewhere
from active_perceiver.capture.rendered.other_rooms import OtherRoom, shared_out
from active_perceiver.capture.rendered.vantage import LEAST_AREA, ROUGH_MARGIN, Eye, poses_towards, rough_mask
from active_perceiver.cli.main import main
from active_perceiver.parallel.run_store import RunStoreError
from active_perceiver.scenes import Scene, SceneError, load_scene, save_scene
from active_perceiver.scenes.checking import scene_issues
from active_perceiver.utils.files import OutputExistsError
from box_room import DEPTH, TABLE, WIDTH, box_room
from helpers.toy import toy_scene
from indoor_rooms.free_space import clearance
from indoor_rooms.layouts.contents import Contents
from indoor_rooms.layouts.placement import stream
from indoor_rooms.objects import OBJECTS
from indoor_rooms.renderer.compiled import compile_room
from indoor_rooms.room import Room

EYE = Eye(height=1.1, fov=70.0, radius=0.2)


def furnished(layout: str, seed: int, contents: Contents) -> Room:
    """A room with the box, and with a vase (its table) only where the seed is even."""
    room = replace(box_room(), name=f"{layout}_{seed}")
    if seed % 2 or "table" not in contents.optional:
        return room
    return replace(room, targets={**room.targets, "table": "table"})


@pytest.fixture(scope="module", autouse=True)
def box_rooms(small_work: pytest.MonkeyPatch) -> None:
    """Little light in rooms with a box."""
    small_work.setattr(elsewhere, "BAKE_RAYS", 4)
    small_work.setattr(other_rooms, "make_room", furnished)


@pytest.fixture(scope="module")
def searched() -> Scene:
    """As if rendered from a conference room: a box, a table, and something that no other room has."""
    toy = toy_scene(image_size=40, side=1)
    names = ("box", "table", "unicorn")
    targets = tuple(replace(target, name=name) for target, name in zip(toy.targets, names, strict=True))
    return replace(toy, targets=targets, source="active-perceiver room conference_room_4, rendered with Embree")


@pytest.fixture(scope="module")
def whole(searched: Scene, tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("elsewhere") / "photographs.h5"
    taken = render_elsewhere(searched, path, pictures=5, targets=["box", "table"], rooms=3)
    assert taken.taken == {"box": 5, "table": 5}
    assert taken.seen["box"] >= 5
    assert taken.seen["unicorn"] == 0
    return path


def test_each_target_is_photographed_as_often_as_asked(whole: Path, searched: Scene) -> None:
    scene = load_scene(whole)
    assert scene.name == "photographs"
    assert len(scene) == 10
    assert scene.target_names == searched.target_names
    assert [target.pictures for target in scene.targets] == [target.pictures for target in searched.targets]
    assert [target.held_out for target in scene.targets] == [2, 2, 2]
    assert (scene.image_size, scene.fov) == (searched.image_size, searched.fov)
    assert (scene.areas[:, 0] >= LEAST_AREA).sum() >= 5
    rooms = (scene.poses[:, 0] // elsewhere.APART).astype(int)
    assert np.bincount(rooms).sum() == 10
    assert np.isnan(scene.boxes[rooms != 1, 1]).all()  # seed 9002 alone has a table among its targets
    assert (scene.areas[rooms == 1, 1] >= LEAST_AREA).sum() >= 5
    assert len(set(scene.views)) == 10
    assert any(problem.fatal and "could not move at all" in problem.text for problem in scene_issues(scene))
    assert not rendering.RENDERED_HERE.fullmatch(scene.source)
    assert not list(whole.parent.glob("*.part"))


def test_an_interruption_changes_nothing(
    whole: Path, searched: Scene, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    out, calls, real = tmp_path / "photographs.h5", [], elsewhere.photograph

    def interrupted(*arguments, **options):  # type: ignore[no-untyped-def]
        calls.append(1)
        if len(calls) == 4:
            raise KeyboardInterrupt
        return real(*arguments, **options)

    monkeypatch.setattr(elsewhere, "photograph", interrupted)
    asked = {"pictures": 5, "targets": ["box", "table"], "rooms": 3}
    with pytest.raises(KeyboardInterrupt):
        render_elsewhere(searched, out, **asked)
    assert not out.exists()
    with pytest.raises(OutputExistsError, match="--resume"):
        render_elsewhere(searched, out, **asked)
    with pytest.raises(RunStoreError, match="other settings"):
        render_elsewhere(searched, out, resume=True, **{**asked, "pictures": 6})
    calls[:] = [1] * 4
    render_elsewhere(searched, out, resume=True, **asked)
    assert len(calls) == 4 + 7
    again, first = load_scene(out), load_scene(whole)
    assert again.views == first.views
    np.testing.assert_array_equal(again.boxes, first.boxes)
    np.testing.assert_array_equal(again.poses, first.poses)


@pytest.mark.parametrize(
    ("change", "error", "message"),
    [
        ({"targets": ["dragon"]}, SceneError, "no target 'dragon'"),
        ({}, CaptureError, "has a place for table, unicorn; ask for more --rooms"),
        ({"pictures": 0}, CaptureError, "at least 1 picture"),
        ({"rooms": 0}, CaptureError, "1 room"),
        ({"out": "photographs.png"}, CaptureError, "does not end in .h5"),
        ({"scene": {"source": "a camera"}}, CaptureError, "was not rendered by this software"),
    ],
)
def test_what_cannot_be_done_is_refused(searched, tmp_path, change, error, message) -> None:  # type: ignore[no-untyped-def]
    options = {"pictures": 1, "rooms": 1, **change}
    scene = replace(searched, **options.pop("scene", {}))
    with pytest.raises(error, match=message):
        render_elsewhere(scene, tmp_path / options.pop("out", "photographs.h5"), **options)
    assert list(tmp_path.iterdir()) == []


def test_a_target_that_is_nowhere_seen_is_an_error(searched, tmp_path, monkeypatch) -> None:  # type: ignore[no-untyped-def]
    monkeypatch.setattr(elsewhere, "poses_towards", lambda *_: np.zeros((0, 4)))
    with pytest.raises(CaptureError, match="'box' cannot be seen well"):
        render_elsewhere(searched, tmp_path / "photographs.h5", targets=["box"], pictures=1, rooms=1)


def test_fewer_photographs_are_noted(searched, tmp_path, monkeypatch, caplog) -> None:  # type: ignore[no-untyped-def]
    monkeypatch.setattr(elsewhere, "poses_towards", lambda *asked: poses_towards(*asked)[:1])
    taken = render_elsewhere(searched, tmp_path / "photographs.h5", targets=["box"], pictures=4, rooms=2)
    assert taken.taken == {"box": 2}
    assert "only 2 photographs of box" in caplog.text


@pytest.mark.parametrize(
    ("wanted", "available", "shares"),
    [
        (9, [9, 9, 9], [3, 3, 3]),
        (10, [9, 9, 9], [3, 3, 4]),
        (10, [9, 1, 0], [9, 1, 0]),
        (12, [2, 20, 20], [2, 5, 5]),
        (30, [2, 3, 4], [2, 3, 4]),
        (1, [5, 5], [0, 1]),
    ],
)
def test_rooms_share_evenly(wanted: int, available: list[int], shares: list[int]) -> None:
    assert shared_out(wanted, available) == shares


def test_poses_are_free_and_see_the_target() -> None:
    room = box_room()
    surfaces = compile_room(room)
    poses = poses_towards(room, surfaces, "box", EYE, 20, np.random.default_rng(0))
    assert poses.shape == (20, 4)
    assert clearance(poses[:, :2], poses[:, :2], [TABLE]).min() >= EYE.radius
    assert (poses[:, :2] >= EYE.radius).all()
    assert (poses[:, :2] <= (WIDTH - EYE.radius, DEPTH - EYE.radius)).all()
    assert np.ptp(np.linalg.norm(poses[:, :2] - (3.1, 1.5), axis=1)) > 0.8
    number = surfaces.object_names.index("box")
    for pose in poses:
        rows, columns = np.nonzero(rough_mask(surfaces, pose, EYE) == number)
        assert np.ptp(rows) * np.ptp(columns) >= 0.5 * ROUGH_MARGIN * LEAST_AREA * 100**2
    again = poses_towards(room, surfaces, "box", EYE, 20, np.random.default_rng(0))
    np.testing.assert_array_equal(poses, again)
    # Glass cases: what no place sees gives no pose, and no endless search.
    hidden = replace(EYE, fov=1.0)
    assert len(poses_towards(room, surfaces, "box", replace(hidden, height=30.0), 2, np.random.default_rng(0))) == 0


def test_the_objects_are_the_very_ones_of_the_scene(monkeypatch: pytest.MonkeyPatch) -> None:
    from indoor_rooms.layouts import make_room

    monkeypatch.setattr(other_rooms, "make_room", make_room)
    names = ("mug", "bag")
    room = OtherRoom(0, Contents((), names, seed=4), {}).furnished()
    assert set(room.targets) == set(names)
    for name in names:
        there = [part for part in room.parts if part.object_name == name]
        pieces = OBJECTS[name](stream(4, name))
        assert len(there) == len(pieces)
        for part, (mesh, material) in zip(there, pieces, strict=True):
            assert part.material.colour == material.colour
            spread = [np.linalg.norm(each.vertices - each.vertices.mean(0), axis=1) for each in (part.mesh, mesh)]
            np.testing.assert_allclose(*spread, atol=1e-5)


def test_the_command(searched: Scene, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path, out = tmp_path / "room.h5", tmp_path / "photographs.h5"
    save_scene(searched, path)
    asked = ["scenes", "elsewhere", str(path), "--out", str(out), "--pictures", "2", "--targets", "box"]
    assert main(asked) == 0
    printed = capsys.readouterr().out
    assert f"scene: {out}" in printed
    assert "box" in printed
    assert len(load_scene(out)) == 2
    assert main(asked) != 0
    assert "--force" in capsys.readouterr().err
    assert main([*asked, "--force"]) == 0


def test_what_is_noted_is_plain_data(searched: Scene) -> None:
    settings = elsewhere.layout_config("conference_room")
    json.dumps(elsewhere._noted(searched, ("box",), 3, settings, ["abc"]))
