"""AI2-THOR's agent as a robot, with a stand-in for the simulator; the client itself where it is installed."""

import dataclasses
import re
import subprocess
import sys

import numpy as np
import pytest

from active_perceiver.capture.thor_scenes import capture_room
from active_perceiver.cli.main import main
from active_perceiver.live import robot_factory
from active_perceiver.live.robot_factory import robot_at
from active_perceiver.robots import RecordedRobot, Robot
from active_perceiver.robots.ai2thor import (
    ThorConfig,
    ThorError,
    ThorRobot,
    captured_config,
    captured_source,
    event_pose,
    reachable_positions,
    start_controller,
)
from active_perceiver.scenes import EIGHT_ACTIONS, TURTLEBOT_ACTIONS, Action, load_scene, save_scene
from helpers import thor_controller
from helpers.thor_controller import StandIn
from helpers.toy import STEP, toy_scene

SETTINGS = ThorConfig(grid=STEP, image_size=48)
TYPES = ("Mug", "Apple", "Mug")
WRITTEN = {"search.mp4", "report.html", "path.png", "final.png", "search.json"}
needs_client = pytest.mark.skipif(
    thor_controller.ai2thor is None, reason="ai2thor is not installed: pip install 'active-perceiver[thor]'"
)


def test_it_is_a_robot_that_does_what_a_recorded_one_does(scene):
    controller = StandIn(scene, TYPES)
    rng = np.random.default_rng(0)
    with ThorRobot(controller, SETTINGS, start=40) as robot:
        assert isinstance(robot, Robot)
        assert robot.actions == EIGHT_ACTIONS
        recorded = RecordedRobot(scene, start=40)
        for _ in range(300):
            np.testing.assert_array_equal(robot.look(), recorded.look())
            assert robot.look().flags.c_contiguous
            assert robot.pose() == pytest.approx(recorded.pose(), abs=0.001)
            action = EIGHT_ACTIONS[rng.integers(8)]
            robot.execute(action)
            recorded.execute(action)
        robot.stop()
        robot.stop()
        assert controller.stopped == 0
    assert controller.stopped == 1


def test_actions_say_how_far(scene):
    controller = StandIn(scene, TYPES)
    robot = ThorRobot(controller, SETTINGS, start=1)  # heading 0, tilt 0
    controller.steps.clear()
    for action in (Action.MOVE_AHEAD, Action.ROTATE_LEFT, Action.LOOK_UP, Action.LOOK_UP, Action.LOOK_DOWN):
        robot.execute(action)
    # The second look up would leave the tilts that the policy knows.
    assert controller.steps == [
        ("MoveAhead", {"moveMagnitude": STEP}), ("RotateLeft", {"degrees": 90.0}), ("LookUp", {"degrees": 30.0}),
        ("LookDown", {"degrees": 30.0}),
    ]  # fmt: skip


def test_a_blocked_move_leaves_it_where_it_is(scene):
    column = EIGHT_ACTIONS.index(Action.MOVE_AHEAD)
    state = int(np.flatnonzero(scene.transitions[:, column] == np.arange(len(scene)))[0])
    robot = ThorRobot(StandIn(scene, TYPES), SETTINGS, start=state)
    before = robot.pose()
    robot.execute(Action.MOVE_AHEAD)
    assert robot.pose() == before
    np.testing.assert_array_equal(robot.look(), scene.view(state))


def test_the_same_seed_gives_the_same_start_and_others_are_tried(scene):
    def poses(**options):
        return [ThorRobot(StandIn(scene, TYPES, **options), SETTINGS, seed=seed).pose() for seed in range(8)]

    free = poses()
    assert free == poses()
    assert len(set(free)) > 5
    blocked = set(range(0, len(scene), 2))
    assert all(round(pose[0] / STEP) for pose in poses(blocked=blocked))
    with pytest.raises(ThorError, match="could not be put at a start"):
        ThorRobot(StandIn(scene, TYPES, blocked=range(len(scene))), SETTINGS, seed=0)
    with pytest.raises(ThorError, match="could not be put at a start"):
        ThorRobot(StandIn(scene, TYPES, blocked={7}), SETTINGS, start=7)
    with pytest.raises(ThorError, match="starts 0 to 191; there is no start 192"):
        ThorRobot(StandIn(scene, TYPES), SETTINGS, start=192)


def test_what_it_may_not_do_is_refused(scene):
    robot = ThorRobot(StandIn(scene, TYPES), SETTINGS, actions=TURTLEBOT_ACTIONS)
    with pytest.raises(ThorError, match="has no action MoveLeft"):
        robot.execute(Action.MOVE_LEFT)


def test_a_crash_of_the_simulator_is_a_sentence(scene):
    robot = ThorRobot(StandIn(scene, TYPES, fails_after=3), SETTINGS, start=0)
    robot.execute(Action.ROTATE_LEFT)
    with pytest.raises(ThorError, match=r"AI2-THOR failed at RotateLeft \(Error encountered"):
        robot.execute(Action.ROTATE_LEFT)


def test_a_room_without_reachable_positions_is_refused(scene):
    controller = StandIn(scene, TYPES)
    controller._GetReachablePositions = lambda: (False, None)
    with pytest.raises(ThorError, match=r"can be reached \(Collided\)"):
        reachable_positions(controller)
    controller._GetReachablePositions = lambda: (True, [])
    with pytest.raises(ThorError, match="can be reached"):
        ThorRobot(controller, SETTINGS)


@pytest.mark.parametrize(
    ("rotation", "horizon", "heading", "tilt"),
    [
        (0.0, 0.0, 0, 0), (359.99997, -0.0, 0, 0), (-90.0, 30.00002, 270, -30), (90.0, -30.0, 90, 30),
        (450.0, 330.0, 90, 30),
    ],
)  # fmt: skip
def test_poses_are_read_as_ours(scene, rotation, horizon, heading, tilt):
    event = StandIn(scene, TYPES).last_event
    event.metadata["agent"] |= {
        "rotation": {"x": 0, "y": rotation, "z": 0}, "cameraHorizon": horizon,
        "position": {"x": -1.5, "y": 0.9, "z": 2},
    }  # fmt: skip
    assert event_pose(event) == (-1.5, 2.0, heading, tilt)


def test_the_settings_of_a_captured_scene_are_found_again(scene, tmp_path):
    capture_room(
        "FloorPlan212", tmp_path / "a.h5", SETTINGS, types=TYPES, start=lambda *_: StandIn(toy_scene(side=2), TYPES)
    )
    assert captured_config(load_scene(tmp_path / "a.h5")) == ("FloorPlan212", SETTINGS)
    with pytest.raises(ThorError, match="was not captured in AI2-THOR; search in it as --robot scene:FILE"):
        captured_config(scene)


@pytest.mark.skipif(thor_controller.ai2thor is not None, reason="ai2thor is installed")
def test_without_the_client_an_error_says_what_to_install():
    with pytest.raises(ThorError, match=re.escape("pip install 'active-perceiver[thor]'")):
        start_controller("FloorPlan1", ThorConfig())


@needs_client
def test_a_simulator_that_does_not_start_is_a_sentence_with_a_remedy(monkeypatch):
    asked = {}

    class Broken:
        def __init__(self, **arguments):
            asked.update(arguments)
            raise ValueError("Invalid commit_id: f08 - no build exists for arch=Linux\nand more")

    monkeypatch.setattr("ai2thor.controller.Controller", Broken)
    monkeypatch.delenv("DISPLAY", raising=False)
    with pytest.raises(ThorError, match=r"no build exists for arch=Linux\).*libvulkan1"):
        start_controller("FloorPlan1", ThorConfig(turn=45.0))
    assert (asked["width"], asked["height"], asked["fieldOfView"]) == (300, 300, 75.0)
    assert (asked["gridSize"], asked["rotateStepDegrees"], asked["snapToGrid"]) == (0.25, 45.0, False)
    assert asked["renderInstanceSegmentation"] is True
    assert asked["platform"].__name__ == "CloudRendering" or sys.platform != "linux"


def test_search_finds_in_it(scene, agent_folder, tmp_path, monkeypatch, capsys):
    monkeypatch.setattr(
        robot_factory, "start_controller", lambda room, settings: started.append(StandIn(scene, TYPES)) or started[-1]
    )
    started = []
    picture = tmp_path / "ball.png"
    picture.write_bytes(scene.targets[0].pictures[0])
    code = main(
        ["search", str(agent_folder), "--picture", str(picture), "--robot", f"thor:{captured(scene, tmp_path)}",
         "--scene", "toy_0", "--seed", "3", "--out", str(tmp_path / "run")]
    )  # fmt: skip
    said = capsys.readouterr().out
    assert code == 0
    assert "in room, from x " in said
    assert "found after" in said
    assert started[-1].stopped == 1
    written = {path.name for path in (tmp_path / "run").iterdir()}
    assert written == WRITTEN


def captured(scene, folder):
    """A scene file that says that it was captured in AI2-THOR."""
    path = folder / "room.h5"
    source = captured_source("FloorPlan1", SETTINGS, "5.0.0")
    save_scene(dataclasses.replace(scene, name="room", source=source), path)
    return path


def test_search_without_a_scene_file_needs_no_floor_plan(agent_folder, tmp_path, monkeypatch, capsys):
    quarter = toy_scene()
    moved = np.array([0.25 / STEP, 0.25 / STEP, 1, 1], np.float32)
    quarter.poses[:] = quarter.poses * moved
    monkeypatch.setattr(robot_factory, "start_controller", lambda room, settings: StandIn(quarter, TYPES))
    picture = tmp_path / "ball.png"
    picture.write_bytes(quarter.targets[1].pictures[0])
    main(
        ["search", str(agent_folder), "--picture", str(picture), "--robot", "thor:FloorPlan1", "--scene", "toy_0",
         "--max-steps", "5", "--seed", "0", "--out", str(tmp_path / "run")]
    )  # fmt: skip
    assert "in FloorPlan1, from x " in capsys.readouterr().out
    assert {path.name for path in (tmp_path / "run").iterdir()} == WRITTEN


def test_a_robot_that_cannot_begin_ends_the_simulator(scene, monkeypatch):
    controller = StandIn(scene, TYPES, blocked=range(len(scene)))
    monkeypatch.setattr(robot_factory, "start_controller", lambda room, settings: controller)
    with pytest.raises(ThorError, match="could not be put"):
        robot_at("thor:FloorPlan1", lambda name: EIGHT_ACTIONS)
    assert controller.stopped == 1


def test_importing_the_robot_needs_no_client():
    code = "import sys, active_perceiver.robots.ai2thor; print('ai2thor' in sys.modules)"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    assert done.stdout.strip() == "False", done.stderr
