"""A robot behind rosbridge, over a real WebSocket to a simulated body, and all that can go wrong there."""

import math
import signal
import socket
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest

from active_perceiver.cli.main import main
from active_perceiver.errors import UserError
from active_perceiver.live.robot_factory import robot_at
from active_perceiver.robots import NavigatingRobot, Robot
from active_perceiver.robots.base import MotionError, Odometry
from active_perceiver.robots.ros.connection import ConnectionLost, RosError
from active_perceiver.robots.ros.robot import RosRobot
from active_perceiver.scenes import EIGHT_ACTIONS, TURTLEBOT_ACTIONS, Action
from active_perceiver.simulation import ros_bridge
from active_perceiver.simulation.diff_drive import NO_NOISE, DiffDriveSim
from helpers.bridge import LONG, SETTINGS, Tripwire, comes_to_rest, served, view, with_
from helpers.toy import toy_scene

PATIENT = with_(LONG, connection={"attempts": 20})


def colour(image):
    return image.reshape(-1, 3).mean(0)


def test_it_moves_turns_and_looks():
    with served() as bridge, RosRobot(bridge.url, SETTINGS) as robot:
        body = bridge.body
        assert isinstance(robot, Robot)
        assert robot.actions == EIGHT_ACTIONS
        assert robot.pose() == pytest.approx((0, 0, 0, 0), abs=1e-6)
        assert robot.execute(Action.MOVE_AHEAD)
        assert (body.x, body.z) == pytest.approx((0, 0.4), abs=0.1)
        assert robot.execute(Action.ROTATE_RIGHT)
        assert body.heading == pytest.approx(90, abs=10)
        assert robot.execute(Action.MOVE_LEFT)
        assert (body.x, body.z) == pytest.approx((0, 0.8), abs=0.15)
        x, z, heading, tilt = robot.pose()
        assert (x, z, heading, tilt) == pytest.approx((body.x, body.z, body.heading, 0), abs=10)
        image = robot.look()
        assert image.shape == (32, 32, 3)
        assert image.dtype == np.uint8
        # The picture was taken where it stands now, not on the way.
        np.testing.assert_allclose(colour(image), colour(view(*robot.pose())), atol=4)
    assert not body.moving


def test_it_tilts_its_camera_as_far_as_the_lattice_goes():
    with served() as bridge, RosRobot(bridge.url, SETTINGS) as robot:
        assert robot.execute(Action.LOOK_UP)
        np.testing.assert_allclose(colour(robot.look()), colour(view(0, 0, 0, 30)), atol=4)
        assert bridge.tilt == pytest.approx(30)
        assert robot.pose()[3] == 30
        assert not robot.execute(Action.LOOK_UP)
        assert robot.execute(Action.LOOK_DOWN)
        assert robot.execute(Action.LOOK_DOWN)
        np.testing.assert_allclose(colour(robot.look()), colour(view(0, 0, 0, -30)), atol=4)


def test_a_robot_without_a_tilt_joint_and_with_stamped_velocities_and_ros_2_names():
    settings = with_(
        tilt=None, tilts=(0.0,), actions="six", stamps=False,
        velocity={"type": "geometry_msgs/msg/TwistStamped"}, odometry={"type": "nav_msgs/msg/Odometry"},
    )  # fmt: skip
    # The bridge says the types as ROS 1 does.
    ros_1 = with_(settings, velocity={"type": "geometry_msgs/TwistStamped"}, odometry={"type": "nav_msgs/Odometry"})
    with served(ros_1) as bridge, RosRobot(bridge.url, settings) as robot:
        assert robot.actions == TURTLEBOT_ACTIONS
        assert not robot.execute(Action.LOOK_UP)
        assert robot.execute(Action.MOVE_BACK)
        assert bridge.body.z == pytest.approx(-0.4, abs=0.1)
        with pytest.raises(RosError, match="no action MoveLeft"):
            robot.execute(Action.MOVE_LEFT)


def test_a_blocked_way_is_driven_back():
    with served(free=lambda x, z: z < 0.15) as bridge, RosRobot(bridge.url, SETTINGS) as robot:
        assert not robot.execute(Action.MOVE_AHEAD)
        assert bridge.body.collisions >= 1
        assert bridge.body.z == pytest.approx(0, abs=0.1)


def test_stopping_is_safe_at_any_time():
    with served() as bridge:
        robot = RosRobot(bridge.url, SETTINGS)
        robot.stop()
        robot.close()
        robot.stop()
        robot.close()
        with pytest.raises(ConnectionLost, match="was given up"):
            robot.execute(Action.MOVE_AHEAD)
        with pytest.raises(ConnectionLost):
            robot.look()


def moving(settings, fault):
    """A bridge whose body is on its way when a fault happens."""
    body = DiffDriveSim(0, 0, 0, Tripwire(0.15, lambda: fault[0]()), NO_NOISE, 0)
    return served(settings, body=body, speedup=1.0)


FAULTS = {
    "dropped": (lambda bridge: bridge.drop(60), ConnectionLost, "it was closed"),
    "silent": (lambda bridge: bridge.hush(), ConnectionLost, "nothing was heard"),
    "frozen": (lambda bridge: bridge.freeze_camera(), RosError, "image is .* its stamp stands still"),
    "blind": (lambda bridge: bridge.freeze_camera(repeat=False), RosError, "nothing new comes on /camera/image"),
    "late": (lambda bridge: bridge.delay_odometry(4), MotionError, "the odometry is .* old"),
    "broken images": (lambda bridge: bridge.garbage("/camera/image/compressed"), RosError, "image.* cannot be read"),
    "broken odometry": (lambda bridge: bridge.garbage("/odom"), RosError, "on /odom that cannot be read"),
}


@pytest.mark.parametrize("fault", FAULTS)
def test_a_fault_on_the_way_stops_the_robot_and_is_named(fault):
    happen, kind, said = FAULTS[fault]
    then = []
    with moving(LONG, then) as bridge:
        then.append(lambda: happen(bridge))
        with RosRobot(bridge.url, LONG) as robot:
            with pytest.raises(kind, match=said):
                robot.execute(Action.MOVE_AHEAD)
            assert comes_to_rest(bridge.body)
            assert bridge.body.z < 2.2
            # What the robot could say, it said: the base did not have to stop by itself.
            assert fault in ("dropped", "silent") or bridge.velocity == (0, 0)


def look_on(robot):
    for _ in range(1000):
        robot.look()
        time.sleep(0.01)


@pytest.mark.parametrize("repeat", [True, False])
def test_a_frozen_camera_is_noticed_when_looking(repeat):
    with served() as bridge, RosRobot(bridge.url, SETTINGS) as robot:
        robot.look()
        bridge.freeze_camera(repeat=repeat)
        with pytest.raises(RosError, match="'max_image_age' is 1 s"):
            look_on(robot)
        bridge.freeze_camera(False)
        assert robot.look().shape == (32, 32, 3)


def test_a_connection_that_is_lost_on_the_way_is_made_again_and_the_action_carried_out():
    then = []
    with moving(PATIENT, then) as bridge:
        then.append(lambda: bridge.drop(0.5))
        with RosRobot(bridge.url, PATIENT) as robot:
            assert robot.execute(Action.MOVE_AHEAD)
            assert bridge.connections == 2
            # Where it was going before, not a whole step from where it was stopped.
            assert bridge.body.z == pytest.approx(2.5, abs=0.15)
            bridge.drop()
            assert robot.look().shape == (32, 32, 3)
            assert bridge.connections == 3


class Rebooting(DiffDriveSim):
    """A body whose odometry can begin anew."""

    jump = 0.0

    def odometry(self):
        at = super().odometry()
        return Odometry(at.x + self.jump, at.z, at.heading, at.time)


def test_odometry_that_began_anew_is_not_driven_by():
    def reboot():
        body.jump = 5.0
        bridge.drop(0.2)

    body = Rebooting(0, 0, 0, Tripwire(0.15, reboot), NO_NOISE, 0)
    with served(PATIENT, body=body, speedup=1.0) as bridge, RosRobot(bridge.url, PATIENT) as robot:
        assert not robot.execute(Action.MOVE_AHEAD)
        assert comes_to_rest(body)
        stands = body.z
        assert robot.execute(Action.ROTATE_RIGHT)
        assert (body.x, body.z) == pytest.approx((0, stands), abs=0.15)


def test_it_goes_to_points_as_seen_from_where_it_began_and_back_from_blocked_ones():
    with served(free=lambda x, z: z < 1.0) as bridge:
        with RosRobot(bridge.url, SETTINGS) as robot:
            assert robot.execute(Action.ROTATE_RIGHT)
        # A new robot begins here: along x.
        with RosRobot(bridge.url, SETTINGS) as robot:
            assert isinstance(robot, NavigatingRobot)
            assert robot.go_to(0.2, 0.5, 90.0, -22.0)
            assert (bridge.body.x, bridge.body.z) == pytest.approx((0.5, -0.2), abs=0.1)
            assert robot.pose()[2:] == pytest.approx((180, -30), abs=8)
            np.testing.assert_allclose(colour(robot.look()), colour(view(*robot.pose())), atol=6)
            assert not robot.go_to(-2.0, 0.5, 0.0, 0.0)
            assert (bridge.body.x, bridge.body.z) == pytest.approx((0.5, -0.2), abs=0.15)
            assert robot.pose()[3] == -30
        assert comes_to_rest(bridge.body)


def test_a_journey_goes_on_after_a_lost_connection():
    then = []
    with moving(PATIENT, then) as bridge:
        then.append(lambda: bridge.drop(0.5))
        with RosRobot(bridge.url, PATIENT) as robot:
            assert robot.go_to(0.0, 1.5, 0.0, 0.0)
            assert bridge.connections == 2
            assert bridge.body.z == pytest.approx(1.5, abs=0.15)


def test_without_its_odometry_a_robot_does_not_know_where_to_go():
    def reboot():
        body.jump = 5.0
        bridge.drop(0.2)

    body = Rebooting(0, 0, 0, Tripwire(0.15, reboot), NO_NOISE, 0)
    with served(PATIENT, body=body, speedup=1.0) as bridge, RosRobot(bridge.url, PATIENT) as robot:
        with pytest.raises(RosError, match="put it back to where it began"):
            robot.go_to(0.0, 1.0, 0.0, 0.0)
        assert comes_to_rest(body)
        stands = body.z
        assert robot.execute(Action.ROTATE_RIGHT)
        assert (body.x, body.z) == pytest.approx((0, stands), abs=0.15)


def test_a_robot_that_does_not_come_back_is_given_up():
    settings = with_(LONG, connection={"attempts": 2, "timeout": 1.0})
    then = []
    with moving(settings, then) as bridge:
        then.append(lambda: bridge.drop(60))
        with RosRobot(bridge.url, settings) as robot:
            with pytest.raises(ConnectionLost, match=r"was lost: it was closed, and 2 attempts .*no rosbridge"):
                robot.execute(Action.MOVE_AHEAD)
            assert comes_to_rest(bridge.body)


def test_a_base_that_does_not_stop_by_itself_is_stopped_as_soon_as_it_can_be_reached(monkeypatch):
    monkeypatch.setattr(ros_bridge, "WATCHDOG", math.inf)
    settings = with_(LONG, connection={"attempts": 1, "timeout": 1.0})

    def cut():
        bridge.freeze_camera(repeat=False)
        bridge.drop()

    # It drives on until it is told otherwise, and nothing it sees will come again.
    with moving(settings, [cut]) as bridge, RosRobot(bridge.url, settings) as robot:
        with pytest.raises(ConnectionLost, match="no image came"):
            robot.execute(Action.MOVE_AHEAD)
        assert bridge.connections == 2
        assert bridge.velocity == (0, 0)
        assert comes_to_rest(bridge.body)


def test_a_connection_that_is_lost_again_in_the_same_action_is_given_up():
    then = []
    with moving(PATIENT, then) as bridge:
        second = Tripwire(0.6, lambda: bridge.drop(60))
        then.append(lambda: (bridge.drop(), setattr(bridge.body, "_free", second)))
        with RosRobot(bridge.url, PATIENT) as robot:
            with pytest.raises(ConnectionLost, match="closed, once more in the same action; stop it if it still"):
                robot.execute(Action.MOVE_AHEAD)
            assert comes_to_rest(bridge.body)


@pytest.mark.parametrize("wrong", [(math.nan, 0.0), (0.1, math.nan), (math.inf, 0.0)])
def test_what_is_no_velocity_stops_the_robot(wrong):
    with served() as bridge, RosRobot(bridge.url, SETTINGS) as robot:
        robot._base.drive(0.2, 0.0)
        with pytest.raises(RosError, match="is no velocity"):
            robot._base.drive(*wrong)
        robot.stop()
        assert bridge.velocity == (0, 0)
        assert abs(bridge.body.z) < 0.1


def test_nobody_answers():
    settings = with_(connection={"timeout": 1.0})
    with socket.create_server(("127.0.0.1", 0)) as deaf:
        url = f"ws://127.0.0.1:{deaf.getsockname()[1]}"
        with pytest.raises(ConnectionLost, match="did not answer within 1 s"):
            RosRobot(url, settings)
    with pytest.raises(ConnectionLost, match="it refused"):
        RosRobot(url, settings)
    with pytest.raises(RosError, match="give ws://HOST:PORT"):
        RosRobot("http://127.0.0.1:9090", settings)


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        (
            {"velocity": {"type": "geometry_msgs/TwistStamped"}},
            "/cmd_vel is of type geometry_msgs/Twist on the robot",
        ),
        ({"camera": {"topic": "/elsewhere"}}, "no image came within 1.5 s: nothing new comes on /elsewhere"),
        ({"odometry": {"topic": "/elsewhere"}}, "no odometry came within 1.5 s"),
    ],
)
def test_topics_that_are_wrong(changes, said):
    with served() as bridge, pytest.raises(RosError, match=said):
        RosRobot(bridge.url, with_(**changes, connection={"timeout": 1.5}))


def test_garbage_from_the_beginning_is_named():
    with served() as bridge:
        bridge.garbage("/camera/image/compressed")
        with pytest.raises(RosError, match=r"no image came .* that cannot be read"):
            RosRobot(bridge.url, with_(connection={"timeout": 1.5}))


def test_without_roslibpy_the_error_names_the_extra(monkeypatch):
    monkeypatch.setitem(sys.modules, "roslibpy", None)
    with pytest.raises(RosError, match=r"pip install 'active-perceiver\[ros\]'"):
        RosRobot("ws://127.0.0.1:9", SETTINGS)


ENDS = {
    "Ctrl-C": "robot.execute(Action.MOVE_AHEAD)",
    "the end of the program": "robot._base.drive(0.5, 0); time.sleep(0.3); print('moving', flush=True)",
}


@pytest.mark.parametrize("end", ENDS)
def test_the_robot_stops_when_the_program_ends(end):
    program = f"""
import sys, time
from active_perceiver.robots.ros.robot import RosRobot
from active_perceiver.scenes import Action
from helpers.bridge import LONG
robot = RosRobot(sys.argv[1], LONG)
try:
    {ENDS[end]}
except KeyboardInterrupt:
    sys.exit("interrupted")
"""
    run = []
    # What is sent stays what the robot said last: the base's own stopping does not change it.
    wire = Tripwire(0.3, lambda: end == "Ctrl-C" and run[0].send_signal(signal.SIGINT))
    path = [*sys.path, str(Path(__file__).parents[2])]
    with served(LONG, free=wire, speedup=1.0) as bridge:
        run.append(
            subprocess.Popen(
                [sys.executable, "-c", program, bridge.url], env={"PYTHONPATH": ":".join(filter(None, path))},
                stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
            )
        )  # fmt: skip
        _, complaint = run[0].communicate(timeout=120)
        assert bridge.velocity == (0, 0), complaint
        assert comes_to_rest(bridge.body)
        assert 0 < bridge.body.z < 2.2
        assert complaint.strip() == ("interrupted" if end == "Ctrl-C" else "")


def test_search_on_a_robot(agent_folder, tmp_path, capsys):
    scene = toy_scene()

    def nearest(x, z, heading, tilt):
        off = np.abs(scene.poses - np.array([x + 0.8, z + 0.8, heading, tilt]))
        off[:, 2] = np.minimum(off[:, 2], 360 - off[:, 2]) / 100
        off[:, 3] /= 100
        return scene.view(int(off.sum(1).argmin()))

    config = tmp_path / "robot.yaml"
    config.write_text(
        "camera: {topic: /camera/image/compressed, rate: 20}\nvelocity: {topic: /cmd_vel}\nodometry: {topic: /odom}\n"
        "tilt: {topic: /tilt_controller/command, seconds: 0.2, rest: 0.5, sign: -1}\ntilts: [-30, 0, 30]\n"
        "step: 0.4\nactions: eight\nsettle: 0.1\n"
        "limits: {speed: 1.0, angular_velocity: 180, distance: 3, odometry_age: 1, "
        "position_tolerance: 0.02, heading_tolerance: 2, stall: 0.6}\n"
    )
    picture = tmp_path / "ball.png"
    picture.write_bytes(scene.targets[1].pictures[0])
    with served(camera=nearest) as bridge:
        main(
            ["search", str(agent_folder), "--picture", str(picture), "--robot", f"ros:{bridge.url}",
             "--robot-config", str(config), "--max-steps", "2", "--seed", "0"]
        )  # fmt: skip
        assert comes_to_rest(bridge.body)
    said = capsys.readouterr().out
    assert "from x 0.00 m, z 0.00 m, heading 0, tilt 0 of its odometry" in said
    assert "found after" in said or "gave up after 2 actions" in said


@pytest.mark.parametrize(
    ("robot", "more", "said"),
    [
        ("ros:ws://127.0.0.1:9", {}, "--robot-config"),
        ("ros:ws://127.0.0.1:9", {"config": "turtlebot2", "start": 3}, "starts where it stands"),
        ("ros:ws://127.0.0.1:9", {"config": "turtlebot5"}, "turtlebot5 cannot be read"),
        ("scene:conference_room", {"config": "turtlebot2"}, "only a ros robot has settings"),
    ],
)
def test_robots_that_cannot_be(robot, more, said):
    with pytest.raises(UserError, match=said):
        robot_at(robot, lambda name: EIGHT_ACTIONS, **more)


def test_a_simulated_bridge_tells_clients_what_they_did_wrong():
    from websockets.sync.client import connect

    with served() as bridge, connect(bridge.url) as client:
        for text in ("nonsense", "[1]", '{"op": "dance"}', '{"op": "publish", "topic": "/cmd_vel", "msg": {}}',
                     '{"op": "subscribe", "topic": "/odom", "type": "std_msgs/String"}'):  # fmt: skip
            client.send(text)
            assert '"op": "status"' in client.recv(timeout=10)
        assert math.isclose(bridge.body.z, 0)
