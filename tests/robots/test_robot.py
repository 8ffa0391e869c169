"""What every robot keeps to, whatever it is."""

import numpy as np
import pytest

from active_perceiver.errors import UserError
from active_perceiver.robots import RecordedRobot, Robot
from active_perceiver.robots.ai2thor import ThorRobot, ThorSettings
from active_perceiver.scenes import EIGHT_ACTIONS, TURTLEBOT_ACTIONS, Action
from simulated_place import simulated
from thor_controller import StandIn
from toy import STEP, toy_scene

# Each makes a robot that may do some actions, on a free place in the middle, looking level along z.
LEVEL = 3 * 4 * 5 + 1  # a state of the toy scene
MAKERS = {
    "recorded": lambda actions: RecordedRobot(toy_scene(actions=actions), start=LEVEL),
    "simulated": lambda actions: simulated(actions=actions),
    "ai2thor": lambda actions: ThorRobot(
        StandIn(toy_scene(), ("Mug", "Apple", "Mug")), ThorSettings(grid=STEP, image_size=48), actions, start=LEVEL
    ),
}
# Metres and degrees by which a robot may miss what it was told.
CLOSE, STRAIGHT = 0.03, 3.0


@pytest.fixture(params=MAKERS)
def make(request):
    return MAKERS[request.param]


def off(pose, other):
    """Metres, and degrees of heading and tilt, between two poses."""
    turned = abs((pose[2] - other[2] + 180) % 360 - 180)
    return np.hypot(pose[0] - other[0], pose[1] - other[1]), turned, abs(pose[3] - other[3])


def same(pose, other):
    metres, turned, tilted = off(pose, other)
    return metres < CLOSE and turned < STRAIGHT and tilted < STRAIGHT


def test_it_is_a_robot(make):
    with make(EIGHT_ACTIONS) as robot:
        assert isinstance(robot, Robot)
        assert robot.actions == EIGHT_ACTIONS


def test_it_looks(make):
    with make(EIGHT_ACTIONS) as robot:
        image = robot.look()
        assert image.dtype == np.uint8
        assert image.ndim == 3
        assert image.shape[2] == 3
        assert image.shape == robot.look().shape
        assert image.std() > 5


@pytest.mark.parametrize(
    ("there", "back"),
    [
        (Action.MOVE_AHEAD, Action.MOVE_BACK),
        (Action.MOVE_LEFT, Action.MOVE_RIGHT),
        (Action.ROTATE_LEFT, Action.ROTATE_RIGHT),
        (Action.LOOK_UP, Action.LOOK_DOWN),
    ],
)
def test_what_it_does_it_says_and_can_undo(make, there, back):
    with make(EIGHT_ACTIONS) as robot:
        before, seen = robot.pose(), robot.look()
        assert robot.do(there) is True
        assert not same(robot.pose(), before)
        assert (robot.look() != seen).any()
        assert robot.do(back) is True
        assert same(robot.pose(), before)


def test_four_turns_come_round(make):
    with make(EIGHT_ACTIONS) as robot:
        before = robot.pose()
        for turn in range(1, 5):
            assert robot.do(Action.ROTATE_RIGHT)
            assert off(robot.pose(), before)[1] == pytest.approx(min(90 * turn, 360 - 90 * turn), abs=STRAIGHT)
        assert same(robot.pose(), before)


def test_what_is_blocked_changes_nothing(make):
    with make(EIGHT_ACTIONS) as robot:
        for _ in range(30):
            before = robot.pose()
            if not robot.do(Action.MOVE_AHEAD):
                break
        else:
            pytest.fail("it drove on for ever")
        assert same(robot.pose(), before)


def test_a_look_beyond_the_outermost_changes_nothing(make):
    with make(EIGHT_ACTIONS) as robot:
        while robot.do(Action.LOOK_UP):
            pass
        before = robot.pose()
        assert robot.do(Action.LOOK_UP) is False
        assert robot.pose() == before


def test_it_refuses_what_it_may_not_do(make):
    with make(TURTLEBOT_ACTIONS) as robot:
        assert robot.actions == TURTLEBOT_ACTIONS
        before = robot.pose()
        with pytest.raises(UserError, match="has no action MoveLeft"):
            robot.do(Action.MOVE_LEFT)
        assert robot.pose() == before


def test_it_can_be_stopped_at_any_time(make):
    robot = make(EIGHT_ACTIONS)
    robot.stop()
    with robot:
        robot.do(Action.ROTATE_LEFT)
        robot.stop()
        robot.stop()
    with pytest.raises(ZeroDivisionError), robot:
        raise ZeroDivisionError
