"""`active-perceiver bridge`: a simulated TurtleBot in a room behind rosbridge, and settings that fit the room."""

import re
import signal
import socket
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from active_perceiver.capture.rendered.config import DEFAULT_CONFIGS
from active_perceiver.cli.main import main
from active_perceiver.errors import UserError
from active_perceiver.robots.ros.config_file import load_config, save_config
from active_perceiver.robots.ros.connection import RosError
from active_perceiver.robots.ros.robot import RosRobot
from active_perceiver.scenes import EIGHT_ACTIONS, TURTLEBOT_ACTIONS, Action
from active_perceiver.simulation.simulated_robot import bridge_in, fitted_config
from helpers.simulated_place import NO_NOISE, SETTINGS, START, small_room


def quick(settings):
    """The same, of a robot that does everything sooner."""
    limits = replace(settings.limits, speed=1.0, angular_velocity=180.0)
    return replace(settings, limits=limits, settle=0.2)


@pytest.mark.parametrize("preset", ["turtlebot2", "turtlebot3", "turtlebot4"])
def test_settings_fit_the_room_and_keep_the_topics(preset):
    before = load_config(preset)
    settings = fitted_config(small_room(), before)
    assert (settings.step, settings.tilts, settings.policy_actions) == (0.5, SETTINGS.tilts, EIGHT_ACTIONS)
    assert (settings.camera.topic, settings.velocity, settings.odometry) == (
        before.camera.topic, before.velocity, before.odometry,
    )  # fmt: skip
    assert settings.tilt is not None
    assert (settings.limits.speed, settings.limits.angular_velocity) == (
        before.limits.speed,
        before.limits.angular_velocity,
    )
    assert settings.connection.timeout > before.connection.timeout


def test_the_paper_s_room_has_its_own_lattice():
    room = replace(small_room(), settings=replace(DEFAULT_CONFIGS["conference_room"], spacing=1.2))
    settings = fitted_config(room, load_config("turtlebot2"))
    assert (settings.step, settings.tilts, settings.policy_actions) == (1.2, (-25.0, 0.0), TURTLEBOT_ACTIONS)
    assert settings.limits.distance > 1.5


def test_actions_that_no_robot_behind_rosbridge_has_are_refused():
    room = replace(small_room(), settings=replace(SETTINGS, actions=(Action.MOVE_AHEAD, Action.ROTATE_LEFT)))
    with pytest.raises(UserError, match="have other actions"):
        fitted_config(room, load_config("turtlebot2"))


def test_a_robot_is_driven_in_the_room_with_the_settings_that_were_written(tmp_path):
    room = small_room()
    save_config(quick(fitted_config(room, load_config("turtlebot2"))), tmp_path / "robot.yaml")
    settings = load_config(tmp_path / "robot.yaml")
    with bridge_in(room, START, settings, odometry_noise=NO_NOISE) as bridge, RosRobot(bridge.url, settings) as robot:
        assert robot.execute(Action.ROTATE_RIGHT)
        assert robot.execute(Action.LOOK_UP)
        shown = robot.look().astype(float)
        assert bridge.tilt == pytest.approx(30, abs=1)
        errors = {}
        for heading in range(0, 360, 90):
            image, _ = room.look((bridge.body.x, bridge.body.z, heading, 30.0))
            errors[heading] = np.abs(image - shown).mean()
        assert min(errors, key=errors.get) == 90  # the box is there
        assert robot.execute(Action.ROTATE_RIGHT)
        moved = [robot.execute(Action.MOVE_AHEAD) for _ in range(3)]
        # The wall is 1.3 m away: two steps, and what is left of it counts only if it is most of one.
        assert moved[:2] == [True, True]
        assert bridge.body.z == pytest.approx(START[1] - 1.0, abs=0.35)
        assert room.free(bridge.body.x, bridge.body.z)


def test_a_port_that_is_taken_is_named():
    with socket.create_server(("127.0.0.1", 0)) as other:
        port = other.getsockname()[1]
        with (
            pytest.raises(RosError, match=f"port {port} cannot be served"),
            bridge_in(small_room(), START, load_config("turtlebot2"), port=port),
        ):
            pass


def test_the_command_serves_until_ctrl_c(tmp_path):
    # The room of boxes has no name, so it is put in the place of the one that is named.
    program = f"""
from active_perceiver.cli.main import main
from active_perceiver.simulation import simulated_robot
from helpers.simulated_place import small_room
simulated_robot.open_room = lambda name, seed: small_room()
raise SystemExit(main(["bridge", "kitchen_1", "--port", "0", "--start", "0", "--seed", "1",
                       "--write-config", {str(tmp_path / "robot.yaml")!r}]))
"""
    path = [*sys.path, str(Path(__file__).parent.parent)]
    with subprocess.Popen(
        [sys.executable, "-c", program], env={"PYTHONPATH": ":".join(filter(None, path))},
        stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
    ) as run:  # fmt: skip
        printed = [run.stdout.readline() for _ in range(3)]
        try:
            url = re.search(r"ws://127\.0\.0\.1:\d+", printed[0]).group()
            assert f"--robot ros:{url} --robot-config {tmp_path / 'robot.yaml'}" in printed[1]
            with RosRobot(url, load_config(tmp_path / "robot.yaml")) as robot:
                assert robot.look().shape == (32, 32, 3)
        finally:
            run.send_signal(signal.SIGINT)
        rest, complaint = run.communicate(timeout=60)
    assert (rest, run.returncode) == ("ended\n", 0), complaint


def test_what_makes_no_sense_is_refused(tmp_path, capsys):
    (tmp_path / "robot.yaml").write_text("mine")
    for options, said in (
        (["cellar_1"], "no room that can be made"),
        (["kitchen_1", "--port", "70000"], "0..65535"),
        (["kitchen_1", "--robot-config", "turtlebot9"], "give a YAML file, or one of"),
        (["kitchen_1", "--write-config", str(tmp_path / "robot.yaml")], "--force"),
    ):
        assert main(["bridge", *options]) == 2
        assert said in " ".join(capsys.readouterr().err.split())
    assert (tmp_path / "robot.yaml").read_text() == "mine"
