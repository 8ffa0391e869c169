"""Scenes of the Active Vision Dataset: the traps of the format, and what is refused."""

import json

import h5py
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from PIL import Image
from scipy.io import loadmat, savemat

from active_perceiver.cli.main import main
from active_perceiver.datasets.avd import poses as avd_poses
from active_perceiver.datasets.avd.matlab_records import as_records, records_as_json
from active_perceiver.datasets.avd.reader import import_avd
from active_perceiver.datasets.io import boxes_of_corners
from active_perceiver.datasets.target_pictures import crop_pictures
from active_perceiver.scenes import Action, Scene, SceneError, load_scene
from active_perceiver.scenes.image_files import ImageError
from helpers.foreign import AVD_ACTIONS, avd_name, avd_records, avd_scene, write_avd, write_records


@pytest.fixture(autouse=True)
def reading(monkeypatch):
    """MATLAB files are read in this process, which is quicker; gives the function that reads them in another."""
    real = avd_poses.read_records
    monkeypatch.setattr(avd_poses, "read_records", lambda path: as_records(records_as_json(path)))
    return real


@pytest.fixture
def in_a_process(reading, monkeypatch):
    monkeypatch.setattr(avd_poses, "read_records", reading)


@pytest.fixture(scope="module")
def scene() -> Scene:
    return avd_scene(side=2)


@pytest.fixture
def folder(scene, tmp_path):
    path = tmp_path / "Home_001_1"
    write_avd(path, scene)
    return path


def edit(folder, change, file="annotations.json"):
    content = json.loads((folder / file).read_text())
    replaced = change(content)
    (folder / file).write_text(json.dumps(content if replaced is None else replaced))


def columns(scene, made):
    return [scene.actions.index(action) for action in made.actions]


def test_a_folder_becomes_the_scene(scene, folder, in_a_process):
    imported = import_avd(folder)
    made = imported.scene
    assert (made.name, made.target_names, made.fov) == ("Home_001_1", scene.target_names, 84.1)
    assert made.actions == tuple(AVD_ACTIONS.values())
    np.testing.assert_allclose(made.poses, scene.poses, atol=1e-4)
    np.testing.assert_array_equal(made.transitions, scene.transitions[:, columns(scene, made)])
    assert len(np.unique(made.poses[:, 2].round())) == 12
    assert all("are cropped from the views" in note for note in imported.notes)
    assert made.view(0).shape == (300, 300, 3)


def test_boxes_and_views_are_padded_alike(scene, folder):
    """320 x 180 in a square of 320: what was a fraction of the height is 180 / 320 of that."""
    made = import_avd(folder, image_size=320).scene
    visible = ~np.isnan(made.boxes[..., 0])
    assert (visible <= (scene.areas > 0)).all()
    low, high = made.boxes[..., :2] - made.boxes[..., 2:] / 2, made.boxes[..., :2] + made.boxes[..., 2:] / 2
    state, target = np.argwhere(made.areas == made.areas.max())[0]
    expected = scene.boxes[state, target] * 180 / 320
    expected[:2] += [0.5 - 90 / 320, 0.5 - 90 / 320]
    np.testing.assert_allclose(made.boxes[state, target], expected, atol=1.5 / 320)
    x, y = ((low + high)[state, target] / 2 * 320).astype(int)
    before = scene.view(state)[tuple((scene.boxes[state, target, [1, 0]] * 96).astype(int))]
    assert np.abs(made.view(state)[y, x].astype(int) - before).max() < 40  # the ball's colour


@given(st.integers(1, 400), st.integers(1, 400), st.lists(st.floats(-50, 450), min_size=4, max_size=4))
def test_boxes_in_a_square_against_drawing_them(width, height, values):
    """A box filled into a mask, padded to a square, is the box that is computed."""
    left, right = sorted(round(value) for value in values[:2])
    top, bottom = sorted(round(value) for value in values[2:])
    side = max(width, height)
    mask = np.zeros((height, width), bool)
    mask[max(top, 0) : max(bottom, 0), max(left, 0) : max(right, 0)] = True
    corners = np.array([[[left, top, right, bottom]]], float)
    box = boxes_of_corners(corners, np.array([[width, height]]), side)[0, 0]
    if not mask.any():
        assert np.isnan(box).all()
        return
    rows, across = np.flatnonzero(mask.any(1)), np.flatnonzero(mask.any(0))
    x, y = (side - width) // 2, (side - height) // 2
    low, high = np.array([across[0] + x, rows[0] + y]), np.array([across[-1] + 1 + x, rows[-1] + 1 + y])
    np.testing.assert_allclose(box, np.concatenate([(low + high) / 2, high - low]) / side, atol=1e-5)


def test_crowd_boxes_and_smaller_ones_of_the_same_are_left_out(scene, folder):
    target = 0
    state = int(scene.areas[:, target].argmax())

    def change(content):
        boxes = content[avd_name(state)]["bounding_boxes"]
        boxes.append([0, 0, 320, 180, target + 1, 5])  # a crowd, over all of the view
        boxes.append([0, 0, 3, 3, target + 1, 1])

    expected = import_avd(folder, image_size=64).scene.boxes
    edit(folder, change)
    imported = import_avd(folder, image_size=64)
    np.testing.assert_array_equal(imported.scene.boxes, expected)
    assert any("1 boxes of difficulty 5 and above" in note for note in imported.notes)
    assert any("1 boxes are of instances with a larger box" in note for note in imported.notes)


def test_empty_rotations_and_poses_follow_from_the_moves(scene, folder):
    records = avd_records(scene)
    empty = np.zeros((0, 0))
    for state in (0, 5, 13, 14, 30):  # interpolated ones: a direction, no rotation
        records[state]["R"] = empty
    for state in (6, 7):  # a rotation, no direction
        records[state]["direction"] = empty
    for state in (2, 20):  # nothing at all
        records[state].update(R=empty, direction=empty, world_pos=empty)
    for state in range(36, 48):  # all of a place
        records[state].update(R=empty, direction=empty, world_pos=empty)
    records[9]["direction"] = np.full((3, 1), np.nan)
    del records[40], records[3]
    write_records(folder / "image_structs.mat", records)
    imported = import_avd(folder, image_size=64)
    made = imported.scene
    assert any(note.startswith("15 views have no measured pose") for note in imported.notes)
    known = np.ones(len(scene), bool)
    known[36:] = False
    np.testing.assert_allclose(made.poses[known], scene.poses[known], atol=1e-4)
    # The last place is derived by moves that count as 0.3 m and here were 0.4; its headings are right.
    np.testing.assert_allclose(made.poses[36:, 2], scene.poses[36:, 2], atol=1e-4)
    assert np.abs(made.poses[36:, :2] - scene.poses[36:, :2]).max() < 0.15


def test_views_that_nothing_leads_to_are_left_out(scene, folder):
    """One place without poses, and without moves to the others."""
    records = avd_records(scene)[:36]
    write_records(folder / "image_structs.mat", records)
    lost = [avd_name(state) for state in range(36, 48)]

    def change(content):
        for name, entry in content.items():
            for key in ("forward", "backward", "left", "right"):
                if name in lost or entry[key] in lost:
                    entry[key] = ""

    edit(folder, change)
    imported = import_avd(folder, image_size=64)
    assert len(imported.scene) == 36
    assert any(note.startswith("12 views have no pose") for note in imported.notes)
    np.testing.assert_allclose(imported.scene.poses, scene.poses[:36], atol=1e-4)


def test_a_scale_of_nought_follows_from_the_moves(scene, folder):
    write_records(folder / "image_structs.mat", avd_records(scene))
    content = loadmat(folder / "image_structs.mat")
    savemat(folder / "image_structs.mat", {"image_structs": content["image_structs"], "scale": 0.0})
    imported = import_avd(folder, image_size=64)
    assert any("moves were taken to be 0.3 m long" in note for note in imported.notes)
    np.testing.assert_allclose(imported.scene.poses[:, :2], scene.poses[:, :2] * 0.3 / 0.4, atol=1e-4)


def test_measured_poses_that_are_a_little_off_make_one_place(scene, folder):
    rng = np.random.default_rng(0)
    records = avd_records(scene)
    for record in records:
        record["world_pos"] = record["world_pos"] + rng.normal(0, 0.05, (3, 1))  # 12 mm
    write_records(folder / "image_structs.mat", records)
    made = import_avd(folder, image_size=64).scene
    assert len(np.unique(made.positions)) == 4
    np.testing.assert_allclose(made.poses, scene.poses, atol=0.02)


def test_moves_that_lead_elsewhere_or_nowhere_are_reported(scene, folder):
    """A photograph that is missing, and a move forwards that goes back."""
    (folder / "jpg_rgb" / avd_name(17)).unlink()
    (folder / "jpg_rgb" / "notes.txt").write_text("x")
    forward = scene.transitions[:, scene.actions.index(Action.MOVE_AHEAD)]
    state = int(
        np.flatnonzero((forward != np.arange(len(scene))) & (np.arange(len(scene)) != 17) & (forward != 17))[0]
    )

    def change(content):
        entry = content[avd_name(state)]
        entry["forward"], entry["backward"] = entry["backward"], entry["forward"]

    edit(folder, change)
    imported = import_avd(folder, image_size=64)
    text = "\n".join(imported.notes)
    assert "1 photographs that annotations.json names are not in jpg_rgb" in text
    assert "1 files in jpg_rgb are not in annotations.json" in text
    assert (
        f"{int((scene.transitions == 17).sum() - (scene.transitions[17] == 17).sum())} moves lead to photographs"
        in text
    )
    assert "moves do not lead where the poses say" in text
    assert len(imported.scene) == len(scene) - 1


def test_keys_of_moves_may_be_missing(scene, folder):
    def change(content):
        for entry in content.values():
            del entry["left"], entry["right"]

    edit(folder, change)
    made = import_avd(folder, image_size=64).scene
    assert Action.MOVE_LEFT not in made.actions
    np.testing.assert_array_equal(made.transitions, scene.transitions[:, columns(scene, made)])


def test_pictures_from_a_folder_where_one_name_begins_another(scene, folder, tmp_path):
    (folder.parent / "instance_id_map.txt").write_text("cup 1\ncup_red 2\nred_bull 3\n\n")
    pictures = tmp_path / "pictures"
    (pictures / "target_0").mkdir(parents=True)
    for name in ("cup_0.jpg", "cup_1.jpg", "cup_red_0.jpg", "cup_NP1_0.jpg", "red_bull.png", "cupboard_0.jpg"):
        Image.new("RGB", (50, 40), "red").save(pictures / "target_0" / name)
    made = import_avd(folder, pictures=pictures, image_size=64, targets=["cup_red", "cup"])
    counted = {target.name: (len(target.pictures), target.held_out) for target in made.scene.targets}
    assert counted == {"cup": (3, 0), "cup_red": (1, 0)}
    assert made.notes == ()
    with pytest.raises(SceneError, match="no boxes of 'mug'; there are cup, cup_red, red_bull"):
        import_avd(folder, targets=["mug"])


def test_without_names_instances_are_called_by_their_number(folder):
    (folder.parent / "instance_id_map.txt").unlink()
    imported = import_avd(folder, image_size=64)
    assert imported.scene.target_names == ("instance_1", "instance_2", "instance_3")
    assert any("there is no instance_id_map.txt" in note for note in imported.notes)


def test_without_boxes_it_is_a_scene_for_view_search(folder):
    edit(folder, lambda content: [entry["bounding_boxes"].clear() for entry in content.values()] and None)
    made = import_avd(folder, image_size=64).scene
    assert made.targets == ()
    assert made.boxes.shape == (48, 0, 4)


def test_crops_are_of_the_largest_clean_boxes():
    """Cut off at the edge, too small, and two that will do."""
    corners = np.array(
        [[[0, 10, 90, 90]], [[20, 20, 40, 40]], [[10, 10, 60, 60]], [[10, 10, 90, 90]], [[np.nan] * 4]]
    )
    views = [np.full((100, 100, 3), state, np.uint8) for state in range(5)]
    asked = []
    crops = crop_pictures(
        ["cup"], corners, np.full((5, 2), 100), lambda state: (asked.append(state), views[state])[1]
    )
    assert asked == [3, 2]
    assert len(crops["cup"]) == 2
    assert crop_pictures(["cup"], corners[:2], np.full((2, 2), 100), lambda state: views[state]) == {}


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda c: [1], "annotations.json should be a JSON object"),
        (lambda c: c.clear(), "annotations.json should be a JSON object"),
        (lambda c: c.update({avd_name(0): 3}), f"'{avd_name(0)}' should be a JSON object, got 3"),
        (lambda c: c[avd_name(4)].update(forward=7), f"{avd_name(4)}: 'forward' should be a text, got 7"),
        (lambda c: c[avd_name(4)].pop("bounding_boxes"), f"{avd_name(4)}: 'bounding_boxes' should be a list"),
        (
            lambda c: c[avd_name(4)].update(bounding_boxes=[[1, 2, 3, 4]]),
            "bounding_boxes 0 should be a list of 6 numbers",
        ),
        (lambda c: c[avd_name(4)].update(bounding_boxes=[[1, 2, 3, float("nan"), 1, 1]]), "finite numbers"),
        (lambda c: c[avd_name(4)].update(bounding_boxes=[[9, 2, 3, 4, 1, 1]]), "do not fit together"),
        (lambda c: [e.update(dict.fromkeys(AVD_ACTIONS, "")) for e in c.values()] and None, "no move from one"),
        (lambda c: {f"x{key}": value for key, value in c.items()}, "has none of the 48 photographs"),
    ],
)
def test_malformed_annotations_get_a_sentence_with_file_and_field(folder, change, message):
    def kept(content):
        result = change(content)
        return result if result == [1] or (isinstance(result, dict) and "xx" in f"x{min(result)}") else None

    edit(folder, kept)
    with pytest.raises(SceneError) as caught:
        import_avd(folder, image_size=32)
    assert message in str(caught.value)
    assert "annotations.json" in str(caught.value)


def test_malformed_poses(scene, folder, in_a_process):
    path = folder / "image_structs.mat"
    records = avd_records(scene)
    records[4]["world_pos"] = np.zeros((2, 1))
    write_records(path, records)
    with pytest.raises(SceneError, match=rf"image_structs.mat, {avd_name(4)}: 'world_pos' should be 3 numbers"):
        records_as_json(path)
    records = avd_records(scene)
    records[4]["R"], records[4]["direction"] = np.eye(2), np.zeros((0, 0))
    write_records(path, records)
    with pytest.raises(SceneError, match="'R' should be 3 x 3 numbers"):
        records_as_json(path)
    write_records(path, [{"name": "a"}, {"name": "b"}])
    with pytest.raises(SceneError, match="record 0 of 'image_structs' has no 'image_name'"):
        records_as_json(path)
    write_records(path, [{**record, "image_name": "other.jpg"} for record in avd_records(scene)])
    with pytest.raises(SceneError, match="has a pose of none of the 48 photographs"):
        import_avd(folder)
    savemat(path, {"structs": 1})
    with pytest.raises(SceneError, match="has no variable 'image_structs'"):
        records_as_json(path)
    path.unlink()
    with h5py.File(path, "w", userblock_size=512) as file:  # version 7.3 is HDF5 behind a header
        file["image_structs"] = 1
    head = b"MATLAB 7.3 MAT-file, Platform: GLNXA64".ljust(124) + b"\x00\x02IM"
    with path.open("r+b") as file:
        file.write(head)
    with pytest.raises(SceneError, match=r"of version 7\.3, which cannot be read here"):
        records_as_json(path)
    path.write_bytes(b"not MATLAB at all" * 50)
    with pytest.raises(SceneError, match=r"image_structs\.mat is not a readable MATLAB file"):
        records_as_json(path)
    with pytest.raises(SceneError, match=r"image_structs\.mat is not a readable MATLAB file"):
        import_avd(folder)
    path.unlink()
    with pytest.raises(SceneError, match=r"there is no image_structs.mat in .*Home_001_1"):
        import_avd(folder)


def test_broken_photographs_and_name_lists(folder):
    path = folder / "jpg_rgb" / avd_name(11)
    path.write_bytes(path.read_bytes()[:200])
    with pytest.raises(ImageError, match=avd_name(11)):
        import_avd(folder)
    names = folder.parent / "instance_id_map.txt"
    for text, message in (("cup one\n", "line 1"), ("cup 1 2\n", "line 1"), ("cup 1\ncup 2\n", "the same name")):
        names.write_text(text)
        with pytest.raises(SceneError, match=f"instance_id_map.txt.*{message}"):
            import_avd(folder)
    names.write_bytes(b"\xff\xfe\x00")
    with pytest.raises(SceneError, match="is not a text file"):
        import_avd(folder)


def test_the_command_writes_the_scene(folder, tmp_path, capsys):
    out = tmp_path / "scene.h5"
    assert main(["scenes", "import", "avd", str(folder), "--out", str(out), "--image-size", "64"]) == 0
    assert "48 views, 6 actions, 3 targets" in capsys.readouterr().out
    assert load_scene(out).image_size == 64
    assert main(["scenes", "import", "avd", str(tmp_path / "none"), "--out", str(tmp_path / "no.h5")]) != 0
    assert not (tmp_path / "no.h5").exists()


@pytest.fixture(scope="module")
def small(tmp_path_factory):
    path = tmp_path_factory.mktemp("small") / "Home_002_1"
    write_avd(path, avd_scene(side=1, image_size=24, targets=1, headings=(0, 90, 180, 270)), 64, 36)
    return path


@pytest.mark.parametrize(("place", "flip"), [(2244, 131), (4433, 13), (1320, 163), (3000, 1)])
def test_bytes_that_crash_the_reader_of_matlab_files_are_a_sentence_too(small, in_a_process, place, flip):
    """SciPy 1.17 ends with a segmentation fault on the first three."""
    _imported_or_refused(small, small / "image_structs.mat", place, flip)


def test_any_flipped_byte_of_the_annotations_gives_a_sentence_or_a_scene(small):
    path = small / "annotations.json"
    for seed in range(80):
        rng = np.random.default_rng(seed)
        _imported_or_refused(small, path, int(rng.integers(path.stat().st_size)), int(rng.integers(1, 256)))


def _imported_or_refused(folder, path, place, flip):
    before = path.read_bytes()
    content = bytearray(before)
    content[place] ^= flip
    path.write_bytes(content)
    try:
        import_avd(folder, image_size=16)
    except SceneError as error:
        if path.name not in str(error) and "jpg_rgb" not in str(error):
            raise
    finally:
        path.write_bytes(before)
