"""Several frames for a look."""

import numpy as np
import pytest

from active_perceiver.errors import UserError
from active_perceiver.robots import Robot
from active_perceiver.robots.simulated import SimulatedRobot
from active_perceiver.robots.steady import SteadyRobot
from active_perceiver.rooms.capturing.camera_faults import CameraFaults
from active_perceiver.rooms.live_room import LiveRoom
from active_perceiver.scenes import Action
from simulated_place import NO_SLIP, SETTINGS, START, small_room


@pytest.fixture
def noisy():
    plain = small_room()
    settings = type(SETTINGS)(**{**vars(SETTINGS), "faults": CameraFaults(noise=0.2, exposure=0, white_balance=0)})
    return SimulatedRobot(LiveRoom(plain.name, plain.baked, settings, 3), START, slip=NO_SLIP)


def test_the_mean_of_frames_is_nearer_to_what_is_there(noisy):
    single, several = SteadyRobot(noisy, 1), SteadyRobot(noisy, 12)
    first, second = single.look().astype(float), single.look().astype(float)
    assert (first != second).any()  # the camera makes other mistakes each time
    spread = np.abs(several.look() - several.look().astype(float)).mean()
    assert spread < 0.5 * np.abs(first - second).mean()


def test_it_does_what_the_robot_does(noisy):
    with SteadyRobot(noisy, 2) as robot:
        assert isinstance(robot, Robot)
        assert robot.actions == noisy.actions
        assert robot.do(Action.MOVE_AHEAD) is True
        assert robot.pose() == noisy.pose() != START
        assert robot.look().dtype == np.uint8
        robot.stop()
    assert not noisy.body.moving


def test_no_frames_are_no_look(noisy):
    with pytest.raises(UserError, match="at least 1 frame, got 0"):
        SteadyRobot(noisy, 0)
