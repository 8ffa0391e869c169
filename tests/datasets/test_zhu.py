"""Dumps of Zhu et al.: read, written, and what is refused."""

import shutil
import subprocess
import sys
import zlib

import h5py
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from active_perceiver.cli.main import main
from active_perceiver.datasets.zhu import writer as exporter
from active_perceiver.datasets.zhu.features import export_zhu, ten_crops
from active_perceiver.datasets.zhu.reader import PUBLISHED_TARGETS, ZHU_ACTIONS, import_zhu
from active_perceiver.scenes import Action, Scene, SceneError, load_scene, save_scene
from active_perceiver.scenes.checking import scene_issues
from active_perceiver.scenes.lattice import steps_to_goal
from active_perceiver.utils.files import OutputExistsError
from helpers.foreign import write_zhu, zhu_scene
from helpers.small import SIZE
from helpers.toy import toy_scene


@pytest.fixture(scope="module")
def scene() -> Scene:
    return zhu_scene()


@pytest.fixture(scope="module")
def dump(scene, tmp_path_factory):
    path = tmp_path_factory.mktemp("zhu") / "kitchen_02.h5"
    write_zhu(path, scene)
    return path


@pytest.fixture
def broken(dump, tmp_path):
    """A copy of the dump, and a function that changes it."""
    path = tmp_path / "broken.h5"
    shutil.copy(dump, path)

    def change(name, value=None, where=None):
        with h5py.File(path, "r+") as file:
            old = file[name][()] if name in file else None
            if name in file:
                del file[name]
            if where is not None:
                old = np.array(old)
                old[where] = value
                file[name] = old
            elif value is not None:
                file[name] = value(old) if callable(value) else value
        return path

    return change


def test_a_dump_becomes_a_scene_for_view_search(dump, scene):
    imported = import_zhu(dump)
    assert imported.notes == ()
    made = imported.scene
    assert (made.name, made.actions, made.targets, made.boxes.shape) == ("kitchen_02", ZHU_ACTIONS, (), (36, 0, 4))
    np.testing.assert_array_equal(made.poses, scene.poses)
    np.testing.assert_array_equal(made.transitions, scene.transitions)
    view = made.view(5)
    assert view.shape == (300, 300, 3)
    # 300 x 400 in a square of 300: the picture fills three quarters of the height, in the middle.
    with h5py.File(dump) as file:
        small = file["observation"][5][2::4, 2::4].astype(int)
    assert np.abs(view[37:262][1::3, 1::3].astype(int)[: len(small), : small.shape[1]] - small).mean() < 12
    assert [problem.text[:21] for problem in scene_issues(made)] == ["no objects are marked"]


def test_the_published_targets_are_named_where_they_fit(dump, scene, tmp_path):
    path = tmp_path / "bathroom_02.h5"
    big = zhu_scene(side=5)
    write_zhu(path, big)
    assert PUBLISHED_TARGETS["bathroom_02"] == (26, 37, 43, 53, 69)
    assert "--targets 26 37 43 53 69" in import_zhu(path, image_size=32).notes[0]


def test_such_a_scene_is_saved_shown_and_searched_for_views_only(dump, tmp_path, capsys):
    out = tmp_path / "scene.h5"
    assert main(["scenes", "import", "zhu", str(dump), "--out", str(out), "--image-size", "64"]) == 0
    assert "36 views, 4 actions, 0 targets" in capsys.readouterr().out
    assert load_scene(out).targets == ()
    assert main(["scenes", "info", str(out), "--picture", str(tmp_path / "sheet.png")]) == 0
    assert "train --task view" in capsys.readouterr().out
    assert main(["scenes", "check", str(out)]) == 0


@pytest.mark.parametrize(
    "command",
    [
        "train --image-size 96 --out agent --scenes",
        "benchmark act --scene",
        "benchmark train --scene",
        "benchmark recogniser --image-size 96 --scenes",
    ],
)
def test_commands_that_need_objects_say_so(command, scene, dump, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    save_scene(import_zhu(dump, image_size=32).scene, tmp_path / "scene.h5")
    assert main([*command.split(), "scene.h5"]) != 0
    assert "no objects to search for, only views: use --task view" in capsys.readouterr().err.replace("\n", " ")
    assert [path.name for path in tmp_path.iterdir()] == ["scene.h5"]


def test_an_agent_is_trained_to_find_views_in_it(dump, tmp_path):
    out = tmp_path / "scene.h5"
    assert main(["scenes", "import", "zhu", str(dump), "--out", str(out), "--image-size", "96"]) == 0
    command = ["train", "--task", "view", "--scenes", str(out), "--targets", "3", "17", "--image-size", "96"]
    assert main([*command, "--learner", "distil", "--policy-seconds", "1", "--out", str(tmp_path / "agent")]) == 0
    assert (tmp_path / "agent" / "policy.onnx").exists()


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (("graph",), "has no dataset 'graph'"),
        (("observation",), "has no dataset 'observation'"),
        (("graph", lambda old: old.astype(float)), "'graph' is of type float64, expected whole numbers"),
        (("graph", lambda old: old[:, :3]), "'graph' has shape"),
        (("graph", 99, (7, 2)), "'graph' leads to state 99 from state 7"),
        (("graph", -2, (0, 0)), "'graph' leads to state -2"),
        (("location", np.nan, (4, 1)), "1 numbers of 'location' are not finite, the first of them in row 4"),
        (("location", lambda old: old[:0]), "'location' is empty"),
        (("location", lambda old: old[:, :1]), "'location' has shape"),
        (("rotation", lambda old: old[:-1]), "'rotation' has shape"),
        (("rotation", lambda old: np.array([b"east"] * len(old))), "'rotation' is of type"),
        (("observation", lambda old: old.astype(np.int16)), "'observation' is of type int16"),
        (("observation", lambda old: old.astype(np.uint16)), "'observation' is of type uint16"),
        (("observation", lambda old: old[..., :1]), "'observation' has shape"),
        (("observation", lambda old: old[:, :0]), "should be an image"),
        (("resnet_feature", lambda old: old[:-1]), "'resnet_feature' has shape"),
        (("resnet_feature", lambda old: old[:, 0, 0]), "'resnet_feature' has shape"),
        (("shortest_path_distance", lambda old: old[:5]), "'shortest_path_distance' has shape"),
    ],
)
def test_malformed_dumps_get_a_sentence_with_the_field(broken, change, message):
    path = broken(*change)
    with pytest.raises(SceneError, match=r"broken\.h5") as caught:
        import_zhu(path, image_size=32)
    assert message in str(caught.value)


@pytest.mark.parametrize("features", [(36, 1, 2048), (36, 2048), (36, 10, 1024)])
def test_features_of_any_number_per_state_will_do(broken, features):
    path = broken("resnet_feature", np.zeros(features, np.float32))
    assert import_zhu(path, image_size=32).notes == ()


def test_what_does_not_agree_is_reported(broken):
    path = broken("graph", 11, (0, 0))
    (moves, distances) = import_zhu(path, image_size=32).notes
    assert moves.startswith("1 of ")
    assert "from state 0 by MoveAhead" in moves
    assert "'shortest_path_distance'" in distances
    path = broken("shortest_path_distance")
    assert any("there is no 'shortest_path_distance'" in note for note in import_zhu(path, image_size=32).notes)


@pytest.mark.parametrize(("offset", "mirrored"), [(90, False), (180, False), (0, True), (270, True)])
def test_a_frame_that_fits_the_moves_is_found(broken, scene, offset, mirrored):
    """Nobody wrote down where 0 degrees point: that the moves go there is what counts."""
    broken("rotation", lambda old: (old - offset) % 360)
    path = broken("location", lambda old: old * np.array([-1.0 if mirrored else 1.0, 1.0]))
    imported = import_zhu(path, image_size=32)
    assert len(imported.notes) == 1
    np.testing.assert_allclose(imported.scene.poses, scene.poses, atol=1e-6)


def test_a_truncated_file_and_one_that_is_none(dump, tmp_path):
    data = dump.read_bytes()
    for length in (0, 100, len(data) // 3, len(data) - 1000):
        path = tmp_path / f"{length}.h5"
        path.write_bytes(data[:length])
        with pytest.raises(SceneError, match=f"{length}.h5"):
            import_zhu(path)
    with pytest.raises(SceneError, match="there is no file"):
        import_zhu(tmp_path / "none.h5")
    with pytest.raises(SceneError, match="image size"):
        import_zhu(dump, image_size=0)


@settings(max_examples=40)
@given(st.data())
def test_any_flipped_byte_gives_a_sentence_or_a_sound_scene(dump, tmp_path_factory, data):
    content = bytearray(dump.read_bytes())
    # The pixels and features are nearly all of the file; the other 40 kB are what matters.
    place = data.draw(st.one_of(st.integers(0, 8000), st.integers(len(content) - 40_000, len(content) - 1)))
    content[place] ^= data.draw(st.integers(1, 255))
    path = tmp_path_factory.mktemp("flipped") / "flipped.h5"
    path.write_bytes(content)
    try:
        made = import_zhu(path, image_size=16)
    except SceneError as error:
        if "flipped.h5" not in str(error):
            raise
    else:
        assert len(made.scene) == 36
    finally:
        path.unlink()


def write_repeated(file, name, shape, dtype):
    """A dataset of a few different rows over and over, each compressed once: gigabytes take no time to write."""
    values = np.random.default_rng(0).integers(0, 255, (4, 100)).astype(dtype)
    rows = [zlib.compress(np.resize(value, shape[1:]).tobytes(), 1) for value in values]
    made = file.create_dataset(name, shape, dtype, chunks=(1, *shape[1:]), compression="gzip")
    for row in range(shape[0]):
        made.id.write_direct_chunk((row, *(0 for _ in shape[1:])), rows[row % len(rows)])
    return made.nbytes


def test_a_large_dump_is_read_in_bounded_memory(tmp_path):
    """Over 2 GB of observations and 300 MB of features, of which a few dozen MB are in memory at a time."""
    path = tmp_path / "large.h5"
    states = 620
    with h5py.File(path, "w") as file:
        assert write_repeated(file, "observation", (states, 900, 1200, 3), np.uint8) > 2e9
        assert write_repeated(file, "resnet_feature", (states, 60, 2048), np.float32) > 3e8
        file["location"] = np.column_stack([np.arange(states), np.zeros(states)])
        file["rotation"] = np.full(states, 90)
        graph = np.full((states, 4), -1)
        graph[:-1, 0], graph[1:, 3] = np.arange(1, states), np.arange(states - 1)
        file["graph"] = graph
    code = (
        "import pathlib\n"
        "from active_perceiver.utils.memory import peak_memory\n"
        "from active_perceiver.datasets.zhu.reader import import_zhu\n"
        "before = peak_memory()\n"
        f"imported = import_zhu(pathlib.Path({str(path)!r}), image_size=32)\n"
        "print(len(imported.scene), (peak_memory() - before) * 1024)\n"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    states_read, megabytes = done.stdout.split()
    assert int(states_read) == states
    assert float(megabytes) < 160


# ---- writing


def test_what_is_exported_comes_back(tmp_path):
    scene = toy_scene(side=3, image_size=24)
    out = tmp_path / "toy.h5"
    export_zhu(scene, out, image_size=SIZE)
    level = scene.poses[:, 3] == 0
    imported = import_zhu(out, image_size=32)
    assert imported.notes == ()
    np.testing.assert_array_equal(imported.scene.poses, scene.poses[level])
    dump = exporter.zhu_dump(scene)
    np.testing.assert_array_equal(imported.scene.transitions, dump.transitions)
    for column, action in enumerate(ZHU_ACTIONS):
        after = scene.transitions[level, scene.actions.index(action)]
        np.testing.assert_array_equal(dump.states[imported.scene.transitions[:, column]], after)


def test_a_dump_is_as_the_agents_read_it(tmp_path):
    """As their `scene_loader.py` does: whole arrays, single rows of observations and features."""
    scene = toy_scene(side=2, image_size=24)
    notes = export_zhu(scene, tmp_path / "toy.h5", crops=10, image_size=SIZE)
    assert any("672 pooled features of efficientnet_lite0" in note for note in notes)
    assert any("tilted otherwise" in note for note in notes)
    with h5py.File(tmp_path / "toy.h5") as file:
        states = file["location"][()].shape[0]
        assert states == 16
        assert set(file["rotation"][()].tolist()) == {0, 90, 180, 270}
        assert file["observation"][3].shape == (300, 400, 3)
        assert file["observation"].dtype == np.uint8
        feature = file["resnet_feature"][3][7][:, np.newaxis]
        assert feature.shape == (2048, 1)
        assert (feature[:672] != 0).any()
        assert (feature[672:] == 0).all()
        graph, distance = file["graph"][()], file["shortest_path_distance"][()]
        assert graph.min() == -1
        moves = np.where(graph < 0, np.arange(states)[:, None], graph)
        for goal in range(states):
            expected = steps_to_goal(moves, np.arange(states) == goal)
            np.testing.assert_array_equal(distance[:, goal], expected)


def test_moves_that_one_side_does_not_know(tmp_path):
    scene = toy_scene(side=2, image_size=24, tilts=(-20.0, 10.0), actions=(Action.ROTATE_LEFT, Action.MOVE_LEFT))
    dump = exporter.zhu_dump(scene)
    assert (scene.poses[dump.states, 3] == 10).all()  # the nearest to level
    assert (dump.graph[:, [0, 1, 3]] == -1).all()
    assert (dump.graph[:, 2] >= 0).all()
    assert any("no MoveBack; in the dump it collides everywhere" in note for note in dump.notes)
    assert any("the format has no MoveLeft" in note for note in dump.notes)
    with pytest.raises(SceneError, match="nothing to export"):
        exporter.zhu_dump(toy_scene(side=2, image_size=24, actions=(Action.MOVE_LEFT,)))
    slanted = toy_scene(side=2, image_size=24, headings=tuple(range(0, 360, 30)))
    assert any("headings are none of 0, 90" in note for note in exporter.zhu_dump(slanted).notes)


def test_exporting_refuses_and_leaves_nothing(tmp_path, capsys):
    scene_file, out = tmp_path / "toy.h5", tmp_path / "out.h5"
    save_scene(toy_scene(side=2, image_size=24), scene_file)
    assert main(["scenes", "export", "zhu", str(scene_file), str(out), "--crops", "3"]) != 0
    assert main(["scenes", "export", "zhu", str(scene_file), str(out), "--backbone", "vgg"]) != 0
    assert list(tmp_path.iterdir()) == [scene_file]
    assert "there is no backbone 'vgg'" in capsys.readouterr().err.replace("\n", " ")
    out.write_bytes(b"precious")
    with pytest.raises(OutputExistsError):
        export_zhu(load_scene(scene_file), out)
    assert out.read_bytes() == b"precious"


def test_the_ten_crops_are_corners_middle_and_their_mirror_images():
    across = np.tile(np.arange(64, dtype=np.uint8)[None, :, None], (64, 1, 3))
    crops = ten_crops(across)
    assert {crop.shape for crop in crops} == {(64, 64, 3)}
    assert [int(crop[32, 0, 0]) for crop in crops[:5]] == [0, 8, 0, 8, 4]
    assert all((mirrored == crop[:, ::-1]).all() for crop, mirrored in zip(crops[:5], crops[5:], strict=True))
