"""Scenes captured from AI2-THOR, with a stand-in for its simulator."""

import dataclasses

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from active_perceiver.capture import thor_scenes
from active_perceiver.capture.thor import thor_transitions
from active_perceiver.capture.thor_scenes import capture_room, capture_rooms, rooms_of
from active_perceiver.capture.thor_targets import (
    NoTargetsError,
    instance_views,
    picture_states,
    room_instances,
    training_first,
)
from active_perceiver.cli.main import main
from active_perceiver.errors import UserError
from active_perceiver.robots.ai2thor import ThorConfig, ThorError
from active_perceiver.scenes import EIGHT_ACTIONS, Action, load_scene, open_scene
from active_perceiver.scenes.checking import scene_issues
from active_perceiver.scenes.image_modes import TRANSPARENT_BACKGROUND
from active_perceiver.scenes.lattice import lattice_poses
from active_perceiver.utils.files import OutputExistsError
from helpers import thor_controller
from helpers.thor_controller import PlainEvent, StandIn, box_masks, client_event
from helpers.toy import COLOURS, STEP, toy_scene

SETTINGS = ThorConfig(grid=STEP, image_size=48)
TYPES = ("Mug", "Apple", "Mug")


@pytest.fixture(params=["plain", "client"])
def make_event(request):
    if request.param == "client" and thor_controller.ai2thor is None:
        pytest.skip("ai2thor is not installed: pip install 'active-perceiver[thor]'")
    return PlainEvent if request.param == "plain" else client_event


@pytest.fixture(scope="module")
def small():
    return toy_scene(side=2)


def standing_in(scene, **options):
    """What starts a simulator, and the simulators it has started."""
    started = []

    def start(room, settings):
        started.append(StandIn(scene, TYPES, **options))
        return started[-1]

    return start, started


def test_a_captured_room_is_the_room(scene, make_event, tmp_path):
    start, started = standing_in(scene, make_event=make_event)
    captured = capture_room("FloorPlan1", tmp_path / "mine.h5", SETTINGS, types=("Apple", "Mug"), start=start)
    got = load_scene(tmp_path / "mine.h5")
    assert got.name == "mine"
    assert got.target_names == ("Apple", "Mug_1", "Mug_2")
    assert [target.category for target in got.targets] == ["Apple", "Mug", "Mug"]
    assert captured.failed == 0
    assert started[0].stopped == 1
    assert "AI2-THOR FloorPlan1" in got.source
    # The same poses, moves and boxes, in whatever order.
    of = {tuple(pose): state for state, pose in enumerate(np.round(scene.poses, 2).tolist())}
    same = np.array([of[tuple(pose)] for pose in np.round(got.poses, 2).tolist()])
    assert sorted(same) == list(range(len(scene)))
    np.testing.assert_array_equal(same[got.transitions], scene.transitions[same])
    hidden = 0
    for state, theirs in enumerate(same):
        masks = thor_controller.toy_masks(scene, theirs)
        for ours, row in enumerate((1, 0, 2)):
            truth = scene.boxes[theirs, row]
            if masks[row].sum() < max(1, 0.0005 * 48 * 48):
                truth = np.full(4, np.nan)
            if not np.allclose(got.boxes[state, ours], truth, atol=1e-6, equal_nan=True):
                hidden += 1  # by another ball: then its pixels tell less than its outline
    assert hidden < 0.02 * len(scene)
    difference = np.abs(got.view(3).astype(int) - scene.view(same[3]).astype(int)).mean()
    assert difference < 12  # WebP
    assert not [problem for problem in scene_issues(got) if problem.fatal]


def test_pictures_show_the_object_alone(scene, make_event, tmp_path):
    start, _ = standing_in(scene, make_event=make_event)
    capture_room("FloorPlan1", tmp_path / "a.h5", SETTINGS, types=TYPES[:2], start=start)
    got = load_scene(tmp_path / "a.h5")
    for row, name in enumerate(("Mug_1", "Apple", "Mug_2")):
        target = got.targets[got.target_index(name)]
        assert 2 <= len(target.pictures) <= 12
        assert target.held_out == len(target.pictures) // 3
        assert len(set(target.pictures)) == len(target.pictures)
        for number in range(len(target.pictures)):
            picture = target.picture(number).astype(float)
            assert picture.shape[0] == picture.shape[1]
            middle = picture[picture.shape[0] // 2, picture.shape[1] // 2]
            assert np.abs(middle - COLOURS[row]).max() < 40, "the ball is in the middle"
            corners = picture[[0, 0, -1, -1], [0, -1, 0, -1]]
            assert np.abs(corners - TRANSPARENT_BACKGROUND).max() < 12, "and nothing around it"


def test_where_the_agent_cannot_be_is_no_state(scene, tmp_path):
    blocked, ignored = {5, 17, 100}, {30, 31}
    start, _ = standing_in(scene, blocked=blocked, ignored=ignored)
    captured = capture_room("FloorPlan1", tmp_path / "a.h5", SETTINGS, types=TYPES, start=start)
    assert captured.failed == 5
    assert len(captured.scene) == len(scene) - 5
    missing = {tuple(pose) for pose in np.round(scene.poses[[5, 17, 100, 30, 31]], 2).tolist()}
    assert not missing & {tuple(pose) for pose in np.round(captured.scene.poses, 2).tolist()}


def test_an_interrupted_capture_goes_on_where_it_was(small, tmp_path):
    scene, out = small, tmp_path / "a.h5"
    done = 30
    whole, started = standing_in(scene)
    capture_room("FloorPlan1", tmp_path / "whole.h5", SETTINGS, types=TYPES, start=whole)
    all_steps = len(started[0].steps)
    first, started = standing_in(scene, fails_after=done)
    with pytest.raises(ThorError, match=r"failed at Teleport \(Error encountered.*--resume"):
        capture_room("FloorPlan1", out, SETTINGS, types=TYPES, start=first)
    assert started[0].stopped == 1
    assert not out.exists()
    with pytest.raises(OutputExistsError, match="--resume goes on"):
        capture_room("FloorPlan1", out, SETTINGS, types=TYPES, start=whole)
    with pytest.raises(UserError, match="other settings"):
        capture_room("FloorPlan1", out, SETTINGS, types=TYPES[:1], resume=True, start=whole)
    again, started = standing_in(scene)
    capture_room("FloorPlan1", out, SETTINGS, types=TYPES, resume=True, start=again)
    assert len(started[0].steps) == all_steps - done  # what the agent can reach among it
    assert [path.name for path in tmp_path.iterdir() if ".part" in path.name] == []
    one, other = load_scene(tmp_path / "whole.h5"), load_scene(out)
    assert one.views == other.views
    assert [target.pictures for target in one.targets] == [target.pictures for target in other.targets]
    with pytest.raises(OutputExistsError, match="--force"):
        capture_room("FloorPlan1", out, SETTINGS, types=TYPES, start=whole)
    capture_room("FloorPlan1", out, SETTINGS, types=TYPES, start=whole, force=True)


def test_another_room_than_the_one_begun_in_is_noticed(small, tmp_path):
    first, _ = standing_in(small, fails_after=30)
    with pytest.raises(ThorError):
        capture_room("FloorPlan1", tmp_path / "a.h5", SETTINGS, types=TYPES, start=first)
    with pytest.raises(ThorError, match="has no Apple any more"):
        capture_room(
            "FloorPlan1", tmp_path / "a.h5", SETTINGS, types=TYPES, resume=True,
            start=lambda room, settings: StandIn(small, ("Mug", "Pear", "Mug")),
        )  # fmt: skip


def test_what_cannot_be_begun_leaves_nothing_behind(small, tmp_path):
    start, started = standing_in(small)
    with pytest.raises(NoTargetsError, match="no Sofa; it has Apple, Mug"):
        capture_room("FloorPlan1", tmp_path / "a.h5", SETTINGS, types=("Mug", "Sofa"), start=start)
    assert started[0].stopped == 1

    def broken(room, settings):
        raise ThorError("no simulator")

    with pytest.raises(ThorError, match="no simulator"):
        capture_room("FloorPlan1", tmp_path / "a.h5", SETTINGS, types=("Mug",), start=broken)
    with pytest.raises(ThorError, match=r"ends in \.h5"):
        capture_room("FloorPlan1", tmp_path / "folder", SETTINGS, start=start)
    assert list(tmp_path.iterdir()) == []


def test_a_target_never_seen_is_left_out_with_a_note(small, tmp_path):
    def unseen(scene, state):
        masks = thor_controller.toy_masks(scene, state)
        return [masks[0], np.zeros_like(masks[1]), masks[2]]

    start, _ = standing_in(small, masks=unseen)
    captured = capture_room("FloorPlan1", tmp_path / "a.h5", SETTINGS, types=TYPES, start=start)
    assert captured.scene.target_names == ("Mug_1", "Mug_2")
    assert captured.notes == ("Apple is never seen, it is left out",)
    start, _ = standing_in(small, masks=lambda scene, state: [np.zeros((48, 48), bool)] * 3)
    with pytest.raises(ThorError, match="none of the targets is seen"):
        capture_room("FloorPlan1", tmp_path / "b.h5", SETTINGS, types=TYPES, start=start)


def test_rooms_of_a_kind_one_after_the_other(small, tmp_path):
    assert rooms_of("kitchens")[::29] == ("FloorPlan1", "FloorPlan30")
    assert rooms_of("bathrooms")[::29] == ("FloorPlan401", "FloorPlan430")
    assert [rooms_of(kind)[0] for kind in ("living_rooms", "bedrooms")] == ["FloorPlan201", "FloorPlan301"]
    contents = {"FloorPlan1": ("Mug", "Apple", "Mug"), "FloorPlan2": ("Fridge",) * 3, "FloorPlan3": ("Mug",) * 3}
    started = []

    def start(room, settings):
        started.append(room)
        return StandIn(small, contents[room])

    rooms = tuple(contents)
    done = dict(capture_rooms(rooms, tmp_path, SETTINGS, types=("Apple", "Mug"), start=start))
    kinds = [type(captured).__name__ for captured in done.values()]
    assert kinds == ["ThorCapture", "NoTargetsError", "ThorCapture"]
    assert sorted(path.name for path in tmp_path.iterdir()) == ["FloorPlan1.h5", "FloorPlan3.h5"]
    assert load_scene(tmp_path / "FloorPlan3.h5").target_names == ("Mug_1", "Mug_2", "Mug_3")
    with pytest.raises(OutputExistsError, match="--resume keeps"):
        list(capture_rooms(rooms, tmp_path, SETTINGS, types=("Mug",), start=start))
    started.clear()
    done = dict(capture_rooms(rooms, tmp_path, SETTINGS, types=("Apple", "Mug"), start=start, resume=True))
    assert started == ["FloorPlan2"]
    assert list(done.values())[::2] == [None, None]


def test_the_command(small, tmp_path, monkeypatch, capsys):
    monkeypatch.setattr(thor_scenes, "start_controller", standing_in(small, blocked={3})[0])
    command = [
        "scenes", "capture", "thor", "FloorPlan1", "--grid", "0.4", "--headings", "90", "--tilts", "-30", "0", "30",
        "--image-size", "48", "--targets", "Mug", "Apple", "--out", str(tmp_path / "a.h5"),
    ]  # fmt: skip
    assert main(command) == 0
    assert "47 views, 1 poses out of reach, 3 targets" in capsys.readouterr().out
    assert main(command) == 2
    assert main(["scenes", "capture", "thor"]) == 2
    assert main(["scenes", "capture", "thor", "FloorPlan1", "--scenes", "kitchens"]) == 2
    assert main(["scenes", "capture", "thor", "FloorPlan1", "--tilts", "0", "70"]) == 2
    error = capsys.readouterr().err.replace("\n", " ")
    assert "one of the two" in error
    assert "tilts must rise evenly, each in -60..30" in error
    assert "Traceback" not in error


def test_the_command_shows_examples(capsys):
    with pytest.raises(SystemExit):
        main(["scenes", "capture", "--help"])
    assert "active-perceiver scenes capture thor --scenes kitchens" in capsys.readouterr().out.split("Examples:")[1]


def test_boxes_are_those_of_a_bundled_scene(make_event):
    """Exact boxes out of the client's inclusive pixel corners, upside down images and all."""
    scene = open_scene("conference_room")
    row = scene.target_index("bag")
    one = dataclasses.replace(scene, targets=scene.targets[row : row + 1], boxes=scene.boxes[:, row : row + 1])
    controller = StandIn(one, ("Bag",), masks=box_masks, make_event=make_event)
    instances = room_instances(controller.last_event.metadata["objects"], (), all_types=True)
    for state in range(0, len(scene), 12):
        controller.state = state
        event = controller._event("Pass", True, None)
        np.testing.assert_array_equal(event.frame, scene.view(state))
        np.testing.assert_allclose(instance_views(event, instances).boxes[0], one.boxes[state, 0], atol=1e-6)


def test_an_event_without_segmentation_is_refused(scene):
    event = StandIn(scene, TYPES).last_event
    instances = room_instances(event.metadata["objects"], TYPES, all_types=True)
    event.instance_detections2D = None
    with pytest.raises(ThorError, match="renderInstanceSegmentation=True"):
        instance_views(event, instances)
    event.frame = None
    event.instance_detections2D = {}
    with pytest.raises(ThorError, match="no image"):
        instance_views(event, instances)


@pytest.mark.skipif(thor_controller.ai2thor is None, reason="ai2thor is not installed")
def test_the_plain_events_say_what_the_clients_say(scene):
    for state in range(0, len(scene), 7):
        said = []
        for make in (PlainEvent, client_event):
            controller = StandIn(scene, TYPES, make_event=make)
            controller.state = state
            event = controller._event("Pass", True, None)
            boxes = {name: tuple(event.instance_detections2D[name]) for name in event.instance_detections2D}
            said.append((event.frame.tobytes(), boxes, {k: event.instance_masks[k].tobytes() for k in boxes}))
        assert said[0] == said[1]


def test_objects_of_a_type_are_numbered_and_the_rest_left_out():
    objects = [
        {"objectId": "Mug|+02.00", "objectType": "Mug", "pickupable": True},
        {"objectId": "Mug|-01.00", "objectType": "Mug", "pickupable": True},
        {"objectId": "Bread|+1", "objectType": "Bread", "pickupable": True},
        {"objectId": "Fridge|+1", "objectType": "Fridge", "pickupable": False},
    ]
    named = room_instances(objects, ("Bread", "Mug", "Bread"), all_types=True)
    assert [(one.name, one.object_id) for one in named] == [
        ("Bread", "Bread|+1"), ("Mug_1", "Mug|+02.00"), ("Mug_2", "Mug|-01.00"),
    ]  # fmt: skip
    assert [one.name for one in room_instances(objects, (), all_types=True)] == ["Bread", "Mug_1", "Mug_2"]
    assert [one.name for one in room_instances(objects, ("Fridge", "Sofa"), all_types=False)] == ["Fridge"]
    with pytest.raises(NoTargetsError, match="no Sofa; it has Bread, Fridge, Mug"):
        room_instances(objects, ("Sofa",), all_types=False)
    with pytest.raises(NoTargetsError, match="no objects to pick up"):
        room_instances(objects[3:], (), all_types=True)


def test_moves_at_45_degrees_lead_a_cell_on_along_both_axes():
    places = np.array([(x, z) for x in range(4) for z in range(3) if (x, z) != (2, 1)]) * 0.25 - 1.5
    poses = lattice_poses(places, ThorConfig(turn=45.0).headings, (0.0,))
    transitions = thor_transitions(poses, EIGHT_ACTIONS, 0.25)
    direction = {Action.MOVE_AHEAD: 0, Action.MOVE_RIGHT: 90, Action.MOVE_BACK: 180, Action.MOVE_LEFT: 270}
    for state, (x, z, heading, _) in enumerate(poses):  # slow and obvious
        for column, action in enumerate(EIGHT_ACTIONS):
            if action in direction:
                angle = np.radians(heading + direction[action])
                wanted = [x + 0.25 * round(np.sin(angle)), z + 0.25 * round(np.cos(angle)), heading]
            elif action in (Action.ROTATE_LEFT, Action.ROTATE_RIGHT):
                wanted = [x, z, (heading + (45 if action is Action.ROTATE_RIGHT else -45)) % 360]
            else:
                wanted = [x, z, heading]
            there = np.flatnonzero(np.abs(poses[:, :3] - wanted).max(1) < 0.01)
            assert transitions[state, column] == (there[0] if len(there) else state)


def test_clean_views_are_large_uncut_and_unhidden_from_different_places():
    box = [0.5, 0.5, 0.3, 0.3]
    boxes = np.array(
        [
            box,  # 0: clean
            [0.5, 0.5, 0.4, 0.4],  # 1: larger, hidden by half
            [0.2, 0.5, 0.4, 0.4],  # 2: larger, cut by the border
            [0.5, 0.5, 0.32, 0.32],  # 3: larger than 0, the same place as 0
            [0.5, 0.5, 0.2, 0.2],  # 4: clean, another place
            [0.5, 0.5, 0.05, 0.05],  # 5: too small
            [np.nan] * 4,
        ],
        np.float32,
    )
    filled = np.array([0.7, 0.3, 0.7, 0.7, 0.68, 0.7, 0], np.float32)
    places = np.array([0, 1, 2, 0, 3, 4, 5])
    assert picture_states(boxes, filled, places, 300) == ([3, 4], True)
    assert picture_states(boxes[[2, 5]], filled[[2, 5]], places[[2, 5]], 300) == ([1], False)
    assert picture_states(boxes[[2]], filled[[2]], places[[2]], 300) == ([0], False)
    assert picture_states(boxes[[6]], filled[[6]], places[[6]], 300) == ([], False)


@given(st.lists(st.binary(min_size=1, max_size=4), min_size=1, max_size=14, unique=True))
def test_a_third_of_the_pictures_is_held_out_and_none_lost(pictures):
    ordered, held_out = training_first(pictures)
    assert sorted(ordered) == sorted(pictures)
    assert held_out == len(pictures) // 3
    assert ordered[0] == pictures[0]


@pytest.mark.parametrize(
    ("setting", "message"),
    [
        ({"grid": 0.0}, "grid must be"), ({"grid": float("nan")}, "grid must be"), ({"turn": 30.0}, "turn must be"),
        ({"tilts": ()}, "tilts must"), ({"tilts": (30.0, 0.0)}, "tilts must"), ({"tilts": (0.0, 45.0)}, "tilts must"),
        ({"tilts": (-30.0, 0.0, 20.0)}, "tilts must"), ({"image_size": 4}, "image_size"), ({"fov": 200.0}, "fov"),
    ],
)  # fmt: skip
def test_settings_that_cannot_be_are_refused(setting, message):
    with pytest.raises(ThorError, match=message):
        ThorConfig(**setting)
