"""Folders of offline AI2-THOR data: the traps of the format, and what is refused."""

import json

import h5py
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from PIL import Image

from active_perceiver.cli.main import main
from active_perceiver.datasets.io import ALL_ACTIONS, actions_between
from active_perceiver.datasets.savn.reader import import_savn, parsed_state, read_graph
from active_perceiver.scenes import Action, Scene, SceneError, load_scene
from helpers.foreign import SAVN_ACTIONS, savn_node, savn_scene, write_savn


@pytest.fixture(scope="module")
def scene() -> Scene:
    return savn_scene(side=2, image_size=96)


@pytest.fixture
def folder(scene, tmp_path):
    path = tmp_path / "FloorPlan1_physics"
    write_savn(path, scene)
    return path


@pytest.fixture
def with_boxes(scene, tmp_path):
    path = tmp_path / "FloorPlan201_physics"
    write_savn(path, scene, boxes=True)
    return path


def edit(path, change):
    content = json.loads(path.read_text())
    replaced = change(content)
    path.write_text(json.dumps(content if replaced is None else replaced))


@pytest.mark.parametrize("key", ["links", "edges"])
def test_a_folder_of_either_networkx_becomes_the_scene(scene, tmp_path, key):
    write_savn(tmp_path / "FloorPlan2_physics", scene, key=key)
    made = import_savn(tmp_path / "FloorPlan2_physics").scene
    assert (made.name, made.actions, made.targets) == ("FloorPlan2", SAVN_ACTIONS, ())
    np.testing.assert_array_equal(made.poses, scene.poses.round(2))
    np.testing.assert_array_equal(made.transitions, scene.transitions)
    assert made.view(0).shape == (300, 300, 3)


def test_moves_at_45_degrees_go_one_cell_along_both_axes(scene, folder):
    """The first place, looking to the opposite corner."""
    made = import_savn(folder).scene
    poses = made.poses
    start = int(
        np.flatnonzero((poses[:, :2] == poses[:, :2].min(0)).all(1) & (poses[:, 2] == 45) & (poses[:, 3] == 0))[0]
    )
    end = made.transitions[start, made.actions.index(Action.MOVE_AHEAD)]
    np.testing.assert_allclose(poses[end] - poses[start], [0.4, 0.4, 0, 0], atol=1e-6)


def test_horizons_count_downwards(scene, folder):
    made = import_savn(folder).scene
    assert set(made.poses[:, 3].tolist()) == {0.0, -30.0}
    level = int(np.flatnonzero(made.poses[:, 3] == 0)[0])
    down = made.transitions[level, made.actions.index(Action.LOOK_DOWN)]
    assert made.poses[down, 3] == -30
    assert made.transitions[level, made.actions.index(Action.LOOK_UP)] == level
    assert parsed_state("-0.00|1.25|405|330") == (0.0, 1.25, 45.0, 30.0)


@pytest.mark.parametrize("there", ["FloorPlan301", "FloorPlan301_physics"])
@pytest.mark.parametrize("asked", ["FloorPlan301", "FloorPlan301_physics"])
def test_the_suffix_may_be_missing_on_either_side(scene, tmp_path, there, asked):
    write_savn(tmp_path / there, scene)
    assert import_savn(tmp_path / asked, image_size=32).scene.name == "FloorPlan301"
    with pytest.raises(SceneError, match="nor FloorPlan9 or FloorPlan9_physics"):
        import_savn(tmp_path / "FloorPlan9")


def test_edges_of_networkx_1_name_nodes_by_number(scene, folder):
    graph = json.loads((folder / "graph.json").read_text())
    number = {node["id"]: index for index, node in enumerate(graph["nodes"])}
    nodes, edges = read_graph(folder / "graph.json")
    for link in graph["links"]:
        link |= {"source": number[link["source"]], "target": number[link["target"]]}
    (folder / "graph.json").write_text(json.dumps(graph))
    assert read_graph(folder / "graph.json") == (nodes, edges)


def test_an_undirected_graph_leads_both_ways(folder):
    """`to_directed`, which the project's own loader calls, makes two edges of each."""
    graph = {"directed": False, "nodes": [{"id": "a"}, {"id": "b"}], "links": [{"source": "a", "target": "b"}]}
    (folder / "graph.json").write_text(json.dumps(graph))
    assert read_graph(folder / "graph.json")[1] == [("a", "b"), ("b", "a")]


def test_without_boxes_it_is_a_scene_for_view_search_that_says_which_views(scene, folder):
    imported = import_savn(folder, targets=["Ball1"], image_size=32)
    boxes, views = imported.notes
    assert "there are no boxes" in boxes
    name, state = views.rsplit(": ", 1)[1].split()
    assert name == "Ball1"
    assert scene.areas[int(state), 1] > 0
    assert imported.scene.boxes.shape == (len(scene), 0, 4)


def test_with_boxes_its_objects_are_targets(scene, with_boxes):
    imported = import_savn(with_boxes)
    made = imported.scene
    kept = [scene.target_names.index(name.lower()) for name in made.target_names]
    assert kept
    assert [target.category for target in made.targets] == list(made.target_names)
    expected = scene.boxes[:, kept]
    # Corners were rounded to pixels; what is smaller than one is not visible.
    visible = ~np.isnan(made.boxes[..., 0])
    assert (visible <= ~np.isnan(expected[..., 0])).all()
    assert visible.sum() > 0.8 * (~np.isnan(expected[..., 0])).sum()
    assert np.abs(made.boxes - expected)[visible].max() <= 0.5 / 96 + 1e-6
    assert any("are cropped from the views" in note for note in imported.notes)
    for target in made.targets:
        assert target.picture().shape == (320, 320, 3)


def test_pictures_may_come_from_a_folder(scene, with_boxes, tmp_path):
    pictures = tmp_path / "pictures"
    (pictures / "Ball0").mkdir(parents=True)
    for path in ("Ball0/any name.png", "Ball1_1.jpg", "Ball1_2.jpg", "Other_1.jpg", "Ball1_notes.txt"):
        Image.new("RGB", (40, 60), "red").save(pictures / path) if path[-3:] != "txt" else (pictures / path).touch()
    made = import_savn(with_boxes, pictures=pictures, image_size=32).scene
    assert [len(target.pictures) for target in made.targets[:2]] == [1, 2]
    with pytest.raises(SceneError, match="no folder of pictures"):
        import_savn(with_boxes, pictures=tmp_path / "none", image_size=32)


def test_objects_of_one_type_are_numbered(scene, with_boxes):
    metadata = (with_boxes / "metadata.json").read_text()
    (with_boxes / "metadata.json").write_text(metadata.replace('"Ball2|', '"Ball0|'))
    pictures = with_boxes / "pictures"
    pictures.mkdir()
    for name in ("Ball0_1", "Ball0_2"):
        Image.new("RGB", (40, 60), "red").save(pictures / f"{name}.png")
    made = import_savn(with_boxes, targets=["Ball0"], pictures=pictures, image_size=32).scene
    assert [(target.name, target.category) for target in made.targets] == [("Ball0_1", "Ball0"), ("Ball0_2", "Ball0")]


def test_views_are_taken_from_nodes_with_images_only(scene, folder):
    nodes = [savn_node(pose) for pose in scene.poses]
    with h5py.File(folder / "images.hdf5", "r+") as file:
        del file[nodes[3]]
        file.create_dataset("9.00|9.00|0|0", data=np.zeros((8, 8, 3), np.uint8))
    imported = import_savn(folder, image_size=32)
    assert len(imported.scene) == len(scene) - 1
    assert any("1 nodes of graph.json have no image" in note for note in imported.notes)
    assert any("names a state that is not in graph.json" in note for note in imported.notes) == bool(
        (scene.areas[3] > 0).any()
    )
    kept = np.delete(np.arange(len(scene)), 3)
    np.testing.assert_array_equal(imported.scene.poses, scene.poses[kept].round(2))
    expected = scene.transitions[kept]
    expected = np.where(expected == 3, kept[:, None], expected)
    np.testing.assert_array_equal(kept[imported.scene.transitions], expected)


def test_edges_that_are_no_move_and_longer_ones_are_left_out(scene, folder):
    nodes = [savn_node(pose) for pose in scene.poses]
    turned = nodes[0].split("|")
    turned[2] = "180"
    twice = nodes[0].split("|")
    twice[2] = "90"  # two turns to the right

    def change(graph):
        graph["links"] += [{"source": nodes[0], "target": "|".join(other)} for other in (turned, twice)]

    edit(folder / "graph.json", change)
    imported = import_savn(folder, image_size=32)
    assert any("1 of " in note and "no move, turn or look" in note for note in imported.notes)
    assert any("1 edges of graph.json do the same as a shorter one" in note for note in imported.notes)
    np.testing.assert_array_equal(imported.scene.transitions, scene.transitions)


@pytest.mark.parametrize(
    ("file", "change", "message"),
    [
        ("graph.json", lambda g: g.pop("nodes"), "'nodes' should be a list, and is not there"),
        ("graph.json", lambda g: g.pop("links"), "'edges' should be a list"),
        ("graph.json", lambda g: g.update(nodes=[]), "has no nodes"),
        ("graph.json", lambda g: g["nodes"][2].update(id=7), "node 2: 'id' should be a text, got 7"),
        ("graph.json", lambda g: g["nodes"][2].update(id="kitchen"), "there is no node"),
        ("graph.json", lambda g: g["links"][5].update(source="1|2|3|4"), "links 5: there is no node '1|2|3|4'"),
        ("graph.json", lambda g: g["links"].append([]), "should be a JSON object with 'source', got []"),
        ("graph.json", lambda g: g["links"].clear(), "graph.json: no edge is a move"),
        ("graph.json", lambda g: [1], "graph.json should be a JSON object with 'nodes', got [1]"),
        ("visible_object_map.json", lambda v: [1], "visible_object_map.json should be a JSON object"),
        ("visible_object_map.json", lambda v: v.update(Mug=3), "'Mug' should be a list"),
        ("metadata.json", lambda m: m[min(m)].update(objects=3), "'objects' should be a list, got 3"),
        (
            "metadata.json",
            lambda m: m[min(m)].update(objects=[{}]),
            "object 0: 'objectId' should be a text, and is not there",
        ),
        (
            "metadata.json",
            lambda m: m[min(m)].update(instance_detections2D={"Mug|1|1|1": [1, 2, "3", 4]}),
            "instance_detections2D of Mug|1|1|1 should hold finite numbers",
        ),
        (
            "metadata.json",
            lambda m: m[min(m)].update(instance_detections2D={"Mug|1|1|1": [1, 2, float("nan"), 4]}),
            "finite numbers",
        ),
    ],
)
def test_malformed_files_get_a_sentence_with_file_and_field(with_boxes, file, change, message):
    if file == "visible_object_map.json":
        (with_boxes / "metadata.json").unlink()
    edit(with_boxes / file, change if file != "graph.json" else lambda g: _kept(change(g)))
    with pytest.raises(SceneError) as caught:
        import_savn(with_boxes, image_size=32)
    assert message in str(caught.value)


def _kept(result):
    """A change that returns a list replaces the content; what `pop` and `update` return does not."""
    return result if result == [1] else None


def test_nodes_that_are_no_states(folder):
    graph = {"nodes": [{"id": "a"}, {"id": "1|2|nan|0"}], "links": []}
    (folder / "graph.json").write_text(json.dumps(graph))
    with pytest.raises(SceneError, match="node 'a' is no state"):
        import_savn(folder)
    assert parsed_state("1|2|nan|0") is None
    assert parsed_state("1|2|3") is None


def test_broken_images_and_missing_files(folder):
    key = next(iter(h5py.File(folder / "images.hdf5")))
    with h5py.File(folder / "images.hdf5", "r+") as file:
        del file[key]
        file[key] = np.zeros((8, 8, 3), np.float32)
    with pytest.raises(SceneError, match=r"images.hdf5: '.*' is of type float32"):
        import_savn(folder)
    data = (folder / "images.hdf5").read_bytes()
    (folder / "images.hdf5").write_bytes(data[: len(data) // 2])
    with pytest.raises(SceneError, match=r"images.hdf5 is not a readable HDF5 file"):
        import_savn(folder)
    (folder / "images.hdf5").rename(folder / "resnet18_featuremap.hdf5")
    with pytest.raises(SceneError, match="has features but no images"):
        import_savn(folder)
    (folder / "resnet18_featuremap.hdf5").unlink()
    with pytest.raises(SceneError, match=r"there is no file .*images.hdf5"):
        import_savn(folder)
    (folder / "graph.json").write_text('{"nodes": [')
    with pytest.raises(SceneError, match=r"graph.json is not valid JSON"):
        import_savn(folder)


def test_a_type_that_is_not_there(folder):
    with pytest.raises(SceneError, match="no object of the type 'Mug'; there are Ball0, Ball1, Ball2"):
        import_savn(folder, targets=["Mug"])


def test_the_command_writes_the_scene_and_says_what_was_left_out(with_boxes, tmp_path, capsys):
    out = tmp_path / "scene.h5"
    assert main(["scenes", "import", "savn", str(with_boxes), "--out", str(out), "--image-size", "48"]) == 0
    said = capsys.readouterr().out
    assert "cropped from the views" in said
    assert load_scene(out).image_size == 48
    assert main(["scenes", "import", "savn", str(with_boxes), "--out", str(out)]) != 0  # it exists
    assert main(["scenes", "import", "savn", str(tmp_path / "none"), "--out", str(tmp_path / "no.h5")]) != 0
    assert not (tmp_path / "no.h5").exists()


@given(
    heading=st.floats(0, 359), size=st.floats(0.05, 2.0), turn=st.sampled_from([15.0, 30.0, 45.0, 90.0, 120.0]),
    askew=st.floats(-9, 9),
)  # fmt: skip
def test_actions_between_poses(heading, size, turn, askew):
    """Whatever the steps of the lattice: each action's own change of pose is recognised as that action."""
    here = np.array([1.0, -2.0, heading, 10.0])
    changes = {}
    for name, direction in (("MOVE_AHEAD", 0), ("MOVE_RIGHT", 90), ("MOVE_BACK", 180), ("MOVE_LEFT", 270)):
        angle = np.radians(heading + direction + askew)
        changes[name] = [size * np.sin(angle), size * np.cos(angle), 0, 0]
    changes |= {"ROTATE_RIGHT": [0, 0, turn, 0], "ROTATE_LEFT": [0, 0, -turn, 0]}
    changes |= {"LOOK_UP": [0, 0, 0, turn], "LOOK_DOWN": [0, 0, 0, -turn]}
    after = here + np.array(list(changes.values()))
    found = actions_between(np.tile(here, (len(after), 1)), after)
    assert [ALL_ACTIONS[number].name for number in found] == list(changes)
    nothing = here + np.array([[0, 0, 0, 0], [0, 0, 180, 0], [size, 0, 60, 0], [0, 0, turn, turn], [size, 0, 0, 30]])
    assert (actions_between(np.tile(here, (5, 1)), nothing) == -1).all()


@settings(max_examples=60)
@given(st.data())
def test_any_flipped_byte_of_the_json_files_gives_a_sentence_or_a_scene(tmp_path_factory, data):
    folder = tmp_path_factory.mktemp("flipped") / "FloorPlan1"
    write_savn(folder, savn_scene(side=1, image_size=16, headings=(0, 90, 180, 270)), boxes=True)
    path = folder / data.draw(st.sampled_from(["graph.json", "metadata.json", "images.hdf5"]))
    content = bytearray(path.read_bytes())
    content[data.draw(st.integers(0, len(content) - 1))] ^= data.draw(st.integers(1, 255))
    path.write_bytes(content)
    try:
        import_savn(folder, image_size=16)
    except SceneError as error:
        if "\n" in str(error):
            raise
