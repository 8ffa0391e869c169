"""Scene files: what is written is read back; what is broken says how."""

import h5py
import numpy as np
import pytest

from active_perceiver.scenes import SceneError, load_scene, open_scene, save_scene
from active_perceiver.utils.files import replacing


@pytest.fixture
def file(scene, tmp_path):
    path = tmp_path / "toy.h5"
    save_scene(scene, path)
    return path


def test_a_scene_survives_the_file(scene, file):
    read = load_scene(file)
    for field in ("name", "actions", "views", "targets", "image_size", "fov", "source"):
        assert getattr(read, field) == getattr(scene, field), field
    for field in ("poses", "transitions", "boxes"):
        np.testing.assert_array_equal(getattr(read, field), getattr(scene, field))
        assert getattr(read, field).dtype == getattr(scene, field).dtype
    np.testing.assert_array_equal(read.floor_plan.outline, scene.floor_plan.outline)


def test_an_existing_file_is_kept_unless_forced(scene, file):
    before = file.read_bytes()
    with pytest.raises(FileExistsError, match="--force"):
        save_scene(scene, file)
    assert file.read_bytes() == before
    save_scene(scene, file, force=True)
    assert load_scene(file).content_hash == scene.content_hash


def test_a_crash_while_writing_leaves_the_old_file_and_no_rest(file):
    before = file.read_bytes()

    def write_half():
        with replacing(file, force=True) as temporary:
            temporary.write_bytes(b"half")
            raise RuntimeError("power cut")

    with pytest.raises(RuntimeError, match="power cut"):
        write_half()
    assert file.read_bytes() == before
    assert list(file.parent.iterdir()) == [file]


def edit(change):
    def apply(path):
        with h5py.File(path, "r+") as scene_file:
            change(scene_file)

    return apply


def overwrite(name, where, value):
    def change(scene_file):
        scene_file[name][where] = value

    return edit(change)


def drop(name):
    return edit(lambda scene_file: scene_file.__delitem__(name))


def set_attribute(name, value):
    return edit(lambda scene_file: scene_file.attrs.__setitem__(name, value))


def as_floats(scene_file):
    del scene_file["transitions"]
    scene_file["transitions"] = np.zeros((192, 8))


def hold_out(scene_file, value):
    scene_file["targets/ball1"].attrs["held_out"] = value


BREAKAGES = {
    "not HDF5": (lambda path: path.write_text("hello"), "not a readable HDF5 file"),
    "empty": (lambda path: path.write_bytes(b""), "not a readable HDF5 file"),
    "truncated": (lambda path: path.write_bytes(path.read_bytes()[:-5000]), "truncated"),
    "other format": (set_attribute("format", "something"), "not a scene file"),
    "newer version": (set_attribute("version", 2), "version 2"),
    "unknown action": (set_attribute("actions", '["Fly"]'), "unknown actions"),
    "actions are no JSON": (set_attribute("actions", "MoveAhead"), "damaged"),
    "NaN pose": (overwrite("poses", (0, 0), np.nan), "not finite"),
    "transition out of range": (overwrite("transitions", (0, 0), 9999), "lead outside"),
    "transitions not whole numbers": (edit(as_floats), "whole numbers"),
    "box in pixels": (overwrite("boxes", (0, 0), [100, 100, 20, 20]), "must lie in 0..1"),
    "no targets": (drop("targets"), "boxes has shape"),
    "no views": (drop("views"), "damaged"),
    "all pictures held out": (edit(lambda file: hold_out(file, 4)), "at least one"),
    "held out is half a picture": (edit(lambda file: hold_out(file, 0.5)), "expected a whole number"),
    "no pictures": (drop("targets/ball0/pictures"), "damaged"),
}


@pytest.mark.parametrize("name", BREAKAGES)
def test_broken_files_say_what_is_wrong(file, name):
    breakage, message = BREAKAGES[name]
    breakage(file)
    with pytest.raises(SceneError, match=message) as caught:
        load_scene(file)
    assert str(file) in str(caught.value)


def test_a_missing_file_and_an_unknown_name_point_to_the_remedy(tmp_path):
    with pytest.raises(SceneError, match="scenes list"):
        load_scene(tmp_path / "nowhere.h5")
    with pytest.raises(SceneError, match="neither a bundled scene"):
        open_scene("atlantis")


def test_files_without_a_split_hold_nothing_out(scene, file):
    with h5py.File(file, "r+") as old:
        assert [group.attrs["held_out"] for group in old["targets"].values()] == [2, 2, 2]
        for group in old["targets"].values():
            del group.attrs["held_out"]
    read = load_scene(file)
    assert [target.held_out for target in read.targets] == [0, 0, 0]
    assert [target.pictures for target in read.targets] == [target.pictures for target in scene.targets]
