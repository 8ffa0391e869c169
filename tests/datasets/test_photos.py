"""A folder of photographs becomes a scene; what is exported comes back; what is wrong is named and writes nothing."""

import dataclasses
import json
import shutil
import warnings

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from PIL import Image

from active_perceiver.cli.main import main
from active_perceiver.datasets.coco.writer import export_coco
from active_perceiver.datasets.photos.pose_snapping import LatticeConfig
from active_perceiver.datasets.photos.pose_table import read_moves, read_poses, write_moves
from active_perceiver.datasets.photos.reader import PhotoConfig, import_photos
from active_perceiver.errors import UserError
from active_perceiver.scenes import EIGHT_ACTIONS, TURTLEBOT_ACTIONS, Action, Scene, Target, load_scene
from active_perceiver.scenes.checking import scene_issues
from active_perceiver.scenes.image_files import upright
from active_perceiver.scenes.images import boxes_in_square, square_image
from active_perceiver.scenes.lattice import lattice_transitions
from active_perceiver.scenes.scene import LABELLED, PROPOSED, UNLABELLED
from active_perceiver.utils.files import OutputExistsError
from helpers.photographs import cut_boxes, photograph_scene
from helpers.toy import toy_scene

SMALL = PhotoConfig(image_size=48, held_out=2)


@pytest.fixture(scope="module")
def room() -> Scene:
    """Nine places, four headings, two tilts."""
    return toy_scene(side=3, tilts=(-25.0, 0.0), actions=TURTLEBOT_ACTIONS)


@pytest.fixture(scope="module")
def photographs(room, tmp_path_factory):
    """The room as somebody photographed it; not to be changed."""
    folder = tmp_path_factory.mktemp("photographs") / "my_room"
    photograph_scene(room, folder, size=(64, 48), turned=0.3)
    return folder


@pytest.fixture
def folder(photographs, tmp_path):
    """A copy that may be changed."""
    return shutil.copytree(photographs, tmp_path / "my_room")


def test_photographs_become_the_room_they_were_taken_in(room, photographs):
    imported = import_photos(photographs, SMALL)
    scene = imported.scene
    np.testing.assert_allclose(scene.poses[:, 2:], room.poses[:, 2:], atol=1e-3)
    np.testing.assert_array_equal(scene.transitions, room.transitions)
    assert scene.actions == TURTLEBOT_ACTIONS
    assert scene.labels is None
    assert [(target.name, target.pictures, target.held_out) for target in scene.targets] == [
        (target.name, target.pictures, 2) for target in room.targets
    ]
    assert scene.name == "my_room"
    assert any(note.startswith("lattice: 9 places") for note in imported.notes)


def test_views_are_upright_and_boxes_are_where_the_things_are(room, photographs):
    scene = import_photos(photographs, SMALL).scene
    turned = [state for state in range(len(scene)) if upright(photographs / f"IMG_{state:04d}.jpg").turned]
    assert len(turned) > 5
    for state in (*turned[:5], 1, 2):
        # The slow obvious path: the room's own view, cut to 64 x 48 and padded.
        whole = np.asarray(Image.fromarray(room.view(state)).resize((64, 64), Image.Resampling.BICUBIC))
        expected = square_image(whole[8:56], 48).astype(float)
        assert np.abs(scene.view(state).astype(float) - expected).mean() < 12
        boxes = {entry["category_id"]: entry["bbox"] for entry in cut_boxes(room, state, 64, 48, 0)}
        for target in range(3):
            if target not in boxes:
                assert np.isnan(scene.boxes[state, target]).all()
                continue
            x, y, width, height = boxes[target]
            expected_box = np.array([x + width / 2, y + height / 2 + 8, width, height]) / 64
            np.testing.assert_allclose(scene.boxes[state, target], expected_box, atol=1e-3)


@given(
    side=st.integers(2, 3),
    tilts=st.sampled_from([(0.0,), (-20.0, 0.0), (-30.0, 0.0, 30.0)]),
    actions=st.sampled_from([EIGHT_ACTIONS, TURTLEBOT_ACTIONS, (Action.ROTATE_RIGHT, Action.MOVE_AHEAD)]),
    labelled=st.sampled_from(["all", "none", "some"]),
    moved=st.booleans(),
    seed=st.integers(0, 10**6),
)
@settings(max_examples=15, suppress_health_check=[HealthCheck.too_slow])
def test_what_is_exported_comes_back(tmp_path_factory, side, tilts, actions, labelled, moved, seed):
    rng = np.random.default_rng(seed)
    scene = toy_scene(seed % 7, side=side, tilts=tilts, actions=actions, image_size=32)
    if labelled != "all":
        labels = rng.integers(0, 3, len(scene)) if labelled == "some" else np.full(len(scene), UNLABELLED)
        boxes = np.where((labels == UNLABELLED)[:, None, None], np.nan, scene.boxes)
        scene = dataclasses.replace(scene, labels=labels.astype(np.uint8), boxes=boxes.astype(np.float32))
    if moved:  # places on no lattice, moves as it happens: then the tables alone say what is what
        poses = scene.poses + rng.uniform(-1, 1, scene.poses.shape).astype(np.float32) * [9, 9, 180, 20]
        transitions = rng.integers(0, len(scene), scene.transitions.shape).astype(np.int32)
        scene = dataclasses.replace(scene, poses=poses.astype(np.float32), transitions=transitions)
    folder = tmp_path_factory.mktemp("export") / "room"
    export_coco(scene, folder)
    settings = PhotoConfig(name=scene.name, image_size=32, fov=scene.fov, held_out=2)
    back = import_photos(folder, settings).scene
    assert back.content_hash == scene.content_hash
    assert back.actions == scene.actions
    assert back.name == scene.name
    np.testing.assert_array_equal(back.transitions, scene.transitions)
    turn = np.abs((back.poses - scene.poses + 180) % 360 - 180)
    assert turn[:, [0, 1, 3]].max() < 2e-4
    assert turn[:, 2].max() < 2e-4
    np.testing.assert_allclose(back.boxes, scene.boxes, atol=1e-4)
    assert back.targets == scene.targets
    states = [LABELLED] * len(scene) if scene.labels is None else scene.labels.tolist()
    assert states == ([LABELLED] * len(scene) if back.labels is None else back.labels.tolist())


def test_nothing_is_labelled_without_boxes(folder):
    (folder / "annotations.json").unlink()
    scene = import_photos(folder, SMALL).scene
    assert (scene.labels == UNLABELLED).all()
    assert np.isnan(scene.boxes).all()


def test_images_that_are_not_listed_are_not_labelled(folder):
    path = folder / "annotations.json"
    content = json.loads(path.read_text())
    content["images"] = content["images"][:10]
    content["annotations"] = [entry for entry in content["annotations"] if entry["image_id"] < 10]
    path.rename(folder / "other.json")
    (folder / "other.json").write_text(json.dumps(content))
    scene = import_photos(folder, dataclasses.replace(SMALL, boxes=folder / "other.json")).scene
    assert scene.labels.tolist() == [LABELLED] * 10 + [UNLABELLED] * (len(scene) - 10)


def test_moves_are_those_of_the_table(room, folder):
    names = [f"IMG_{state:04d}.jpg" for state in range(len(room))]
    transitions = room.transitions.copy()
    ahead = int(np.flatnonzero(transitions[:, 0] != np.arange(len(room)))[0])
    following = int(transitions[ahead, 0])
    transitions[following, 1] = following  # the way back is blocked
    write_moves(folder / "moves.csv", names, room.actions, transitions)
    imported = import_photos(folder, SMALL)
    np.testing.assert_array_equal(imported.scene.transitions, transitions)
    note = next(note for note in imported.notes if "no way back" in note)
    assert note == f"1 moves have no way back, as MoveAhead from {names[ahead]} to {names[following]}"


def test_headings_between_the_directions_of_the_grid_are_noted(room, folder):
    text = (folder / "poses.csv").read_text().splitlines()
    rows = [line.split(",") for line in text[1:]]
    # Every second place looks along the grid, the others in between.
    changed = [[*row[:3], f"{float(row[3]) + 45 * (state // 8 % 2)}", row[4]] for state, row in enumerate(rows)]
    (folder / "poses.csv").write_text("\n".join([text[0], *(",".join(row) for row in changed)]))
    imported = import_photos(folder, SMALL)
    note = next(note for note in imported.notes if note.startswith("no place lies ahead"))
    assert "headings 0, 45, 90" in note  # the places between see no neighbour that looks the same way
    assert set(np.unique(imported.scene.poses[:, 2])) == set(range(0, 360, 45))


def test_sideways_moves_are_asked_for(room, photographs):
    scene = import_photos(photographs, dataclasses.replace(SMALL, sideways=True)).scene
    assert scene.actions == EIGHT_ACTIONS
    np.testing.assert_array_equal(scene.transitions, lattice_transitions(room.poses, EIGHT_ACTIONS, 0.4))


def test_large_pictures_of_targets_are_made_smaller_and_upright(folder):
    exif = Image.Exif()
    exif[0x0112] = 6
    Image.new("RGB", (1200, 900), (10, 200, 30)).save(folder / "targets" / "ball0" / "00.jpg", exif=exif)
    (folder / "targets" / "ball0" / "notes.txt").write_text("not a picture")
    target = import_photos(folder, SMALL).scene.targets[0]
    assert target.picture(0).shape == (640, 480, 3)
    assert len(target.pictures) == 5


def test_photographs_without_a_pose_are_noted(folder):
    shutil.copy(folder / "IMG_0001.jpg", folder / "extra.jpg")
    notes = import_photos(folder, SMALL).notes
    assert "not in poses.csv, so left out: extra.jpg" in notes


@pytest.mark.parametrize(("width", "height", "size"), [(64, 48, 300), (48, 64, 300), (4000, 2250, 299), (31, 7, 48)])
def test_boxes_go_where_the_pixels_go(width, height, size):
    image = np.zeros((height, width, 3), np.uint8)
    left, right, top, bottom = width // 4, width // 2 + 1, height // 3, 2 * height // 3 + 1
    image[top:bottom, left:right] = 255
    box = np.array(
        [(left + right) / 2 / width, (top + bottom) / 2 / height, (right - left) / width, (bottom - top) / height]
    )
    bright = square_image(image, size)[..., 0] > 127
    rows, columns = np.flatnonzero(bright.any(1)), np.flatnonzero(bright.any(0))
    low, high = np.array([columns[0], rows[0]]), np.array([columns[-1] + 1, rows[-1] + 1])
    expected = np.concatenate([(low + high) / 2, high - low]) / size
    np.testing.assert_allclose(boxes_in_square(box, width, height, size), expected, atol=2.1 / size)


def test_corrupt_exif_is_nothing_to_talk_about(folder, tmp_path, capsys):
    """Pillow warns of it, in a line of its own code, and takes the photograph as it lies in the file."""
    path = folder / "IMG_0005.jpg"
    exif = Image.Exif()
    exif[0x010E] = "a description longer than four letters"
    data = bytearray(exif.tobytes())
    data[data.index(0x0E) + 4 : data.index(0x0E) + 8] = bytes([200, 200, 0, 0])  # its length
    Image.open(path).convert("RGB").save(path, exif=bytes(data))
    with pytest.warns(UserWarning, match="EXIF|Tag data larger"):
        upright(path)
    out = tmp_path / "out" / "scene.h5"
    with warnings.catch_warnings(record=True) as warned:
        warnings.simplefilter("always")
        assert main(["scenes", "import", "photos", str(folder), "--out", str(out), "--image-size", "48"]) == 0
    assert [str(warning.message) for warning in warned] == []
    assert "Warning" not in capsys.readouterr().err
    assert len(load_scene(out)) == 72


def replaced(path, old, new):
    text = path.read_text()
    assert old in text
    path.write_text(text.replace(old, new, 1))


def cut_short(folder):
    path = folder / "IMG_0003.jpg"
    path.write_bytes(path.read_bytes()[:-400])


def odd_size(folder):
    Image.new("RGB", (48, 64)).save(folder / "IMG_0003.jpg")


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda f: (f / "poses.csv").unlink(), r"there is no .*poses\.csv; write a table"),
        (lambda f: (f / "poses.csv").write_text(""), "column 'file' is missing"),
        (lambda f: (f / "poses.csv").write_text("file,x,z,heading,tilt\n"), "no lines below its head"),
        (lambda f: replaced(f / "poses.csv", "heading", "yaw"), "line 1: column 'heading' is missing"),
        (lambda f: replaced(f / "poses.csv", "IMG_0001.jpg,", "IMG_0001.jpg,?"), r"line 3: x is '\?"),
        (lambda f: replaced(f / "poses.csv", "IMG_0001.jpg,", "IMG_0001.jpg,nan,"), r"line 3: 6 values under 5"),
        (lambda f: replaced(f / "poses.csv", "IMG_0001.jpg,", "IMG_0001.jpg,9e9"), r"line 3: x is '9e9"),
        (lambda f: replaced(f / "poses.csv", "IMG_0001", "IMG_0000"), r"line 3: IMG_0000\.jpg is in line 2 already"),
        (lambda f: replaced(f / "poses.csv", "IMG_0001", "IMG_9999"), r"line 3: there is no photograph IMG_9999"),
        (lambda f: replaced(f / "poses.csv", "IMG_0001", "A" * 5000), "line 3: .* too long"),
        (lambda f: replaced(f / "poses.csv", "IMG_0001", "\0"), r"line 3: .* control character|not a sound table"),
        (lambda f: (f / "poses.csv").write_bytes(b"file,x\xff"), "not text in UTF-8"),
        (lambda f: replaced(f / "poses.csv", "IMG_0001", '"IMG_0001'), "not a sound table"),
        (odd_size, r"upright, 64 x 48 pixels, but not IMG_0003\.jpg \(48 x 64\)"),
        (lambda f: (f / "IMG_0003.jpg").write_bytes(b"no image"), r"IMG_0003\.jpg is not an image that is read"),
        (cut_short, r"IMG_0003\.jpg is broken"),
        (lambda f: shutil.rmtree(f / "targets"), "there is no folder .*targets; make it"),
        (lambda f: (f / "targets" / "nothing").mkdir(), "no picture in .*nothing"),
        (lambda f: (f / "targets" / "ball1" / "00.png").write_bytes(b"x"), r"00\.png is not an image"),
        (lambda f: (f / "annotations.json").write_text("{"), r"annotations\.json is not valid JSON"),
        (lambda f: (f / "moves.csv").write_text("file,action\n"), "column 'next_file' is missing"),
        (lambda f: (f / "moves.csv").write_text("file,action,next_file\n"), "no lines below its head"),
        (lambda f: (f / "moves.csv").write_text("file,action,next_file\na,MoveAhead,b\n"), "line 2: file 'a' is not"),
        (lambda f: (f / "moves.csv").write_text("file,action,next_file\nIMG_0000.jpg,Jump,\n"), "no action 'Jump'"),
        (
            lambda f: (f / "moves.csv").write_text(
                "file,action,next_file\nIMG_0000.jpg,LookUp,\nIMG_0000.jpg,LookUp,IMG_0001.jpg\n"
            ),
            r"line 3: LookUp from IMG_0000\.jpg leads to two",
        ),
    ],
)  # fmt: skip
def test_what_is_wrong_is_named_and_nothing_is_written(folder, tmp_path, capsys, change, message):
    change(folder)
    with pytest.raises(UserError, match=message):
        import_photos(folder, SMALL)
    out = tmp_path / "out" / "room.h5"
    assert main(["scenes", "import", "photos", str(folder), "--out", str(out), "--image-size", "48"]) == 2
    assert not out.parent.exists() or not list(out.parent.iterdir())
    assert "Traceback" not in capsys.readouterr().err


def test_a_target_with_too_few_pictures_to_hold_out(folder):
    with pytest.raises(UserError, match="holds out 4 of its 4 pictures"):
        import_photos(folder, dataclasses.replace(SMALL, held_out=4))


@pytest.mark.parametrize("bad", [{"image_size": 3}, {"fov": 0.0}, {"fov": float("nan")}])
def test_wrong_settings_are_refused(bad):
    with pytest.raises(UserError):
        PhotoConfig(**bad)


def test_a_table_from_a_spreadsheet_is_read(tmp_path):
    path = tmp_path / "poses.csv"
    path.write_bytes("﻿File;X;Z;Heading\r\nbild ä.jpg;0,5;-1,25;90\r\n\r\n".encode())
    table = read_poses(path)
    assert table.files == ("bild ä.jpg",)
    assert table.poses.tolist() == [[0.5, -1.25, 90.0, 0.0]]


def test_moves_that_are_not_in_the_table_are_blocked(tmp_path):
    path = tmp_path / "moves.csv"
    path.write_text("file,action,next_file\nb,lookup,a\na,MoveAhead,b\na,LookUp,\n")
    actions, transitions = read_moves(path, ["a", "b"])
    assert actions == (Action.LOOK_UP, Action.MOVE_AHEAD)
    assert transitions.tolist() == [[0, 1], [0, 1]]


def test_commands(room, tmp_path, capsys):
    """Export, import, check, label: as somebody would type it."""
    from active_perceiver.scenes import save_scene

    save_scene(room, tmp_path / "room.h5")
    assert main(["scenes", "export", "coco", str(tmp_path / "room.h5"), str(tmp_path / "out")]) == 0
    back = capsys.readouterr().out.split("back to a scene: active-perceiver ")[1].splitlines()[0].split()
    back[-1] = str(tmp_path / "back.h5")
    assert main([*back, "--tilts", "-25", "0"]) == 0
    out = capsys.readouterr().out
    assert "note  lattice: 9 places 0.4 m apart, headings every 90 degrees, tilts -25, 0" in out
    assert "no problems found" in out
    np.testing.assert_array_equal(load_scene(tmp_path / "back.h5").transitions, room.transitions)
    assert not [problem for problem in scene_issues(load_scene(tmp_path / "back.h5")) if problem.fatal]
    assert main([*back]) == 2  # it exists


def test_an_exported_folder_is_whole_or_not_there(room, tmp_path, monkeypatch):
    (tmp_path / "full").mkdir()
    (tmp_path / "full" / "mine.txt").write_text("keep")
    with pytest.raises(OutputExistsError, match="exists"):
        export_coco(room, tmp_path / "full")
    monkeypatch.setattr("active_perceiver.datasets.coco.writer.write_moves", lambda *_: 1 / 0)
    with pytest.raises(ZeroDivisionError):
        export_coco(room, tmp_path / "new")
    assert sorted(path.name for path in tmp_path.iterdir()) == ["full"]
    odd = dataclasses.replace(room, targets=tuple(Target(f"..{n}", t.pictures) for n, t in enumerate(room.targets)))
    with pytest.raises(UserError, match="name of a folder"):
        export_coco(odd, tmp_path / "new")


def test_proposals_stay_proposals_until_a_tool_has_seen_them(room, tmp_path):
    labels = np.full(len(room), LABELLED, np.uint8)
    labels[:5] = PROPOSED
    export_coco(dataclasses.replace(room, labels=labels), tmp_path / "out")
    assert import_photos(tmp_path / "out", SMALL).scene.labels.tolist() == labels.tolist()
    path = tmp_path / "out" / "annotations.json"
    content = json.loads(path.read_text())
    for image in content["images"]:
        image.pop("proposed", None)  # what a labelling tool does not know it does not write
    path.write_text(json.dumps(content))
    assert import_photos(tmp_path / "out", SMALL).scene.labels is None


def test_the_lattice_may_be_given(folder):
    lattice = LatticeConfig(spacing=0.4, heading_step=90.0, tilts=(-25.0, 0.0))
    scene = import_photos(folder, dataclasses.replace(SMALL, lattice=lattice)).scene
    assert np.unique(scene.positions).size == 9
