"""What every robot keeps to, whatever it is."""

from contextlib import ExitStack

import numpy as np
import pytest

from active_perceiver.errors import UserError
from active_perceiver.robots import RecordedRobot, Robot
from active_perceiver.robots.ai2thor import ThorConfig, ThorRobot
from active_perceiver.robots.ros.config import ACTIONS
from active_perceiver.robots.ros.robot import RosRobot
from active_perceiver.scenes import EIGHT_ACTIONS, TURTLEBOT_ACTIONS, Action
from helpers.bridge import SETTINGS, served, view, with_
from helpers.simulated_place import simulated
from helpers.thor_controller import StandIn
from helpers.toy import STEP, toy_scene

LEVEL = 3 * 4 * 5 + 1  # a state of the toy scene


def striped(x, z, heading, tilt):
    """A view with stripes whose shade tells x, which its colours do not."""
    image = view(x, z, heading, tilt)
    image[:, ::4] = round(np.clip(128 + 100 * x, 0, 255))
    return image


def behind_rosbridge(actions, ends):
    (name,) = (name for name, known in ACTIONS.items() if known == actions)
    # Patient, as the machine may have other things to do: faults are tested elsewhere.
    patience = {"camera": {"max_image_age": 5.0}, "limits": {"odometry_age": 5.0, "stall": 2.0, "seconds": 60.0}}
    settings = with_(SETTINGS, actions=name, step=0.25, tilt={"seconds": 0.1}, settle=0.05, **patience)
    bridge = ends.enter_context(served(settings, free=lambda x, z: z < 0.35, camera=striped))
    return RosRobot(bridge.url, settings)


# Each makes a robot that may do some actions, on a free place in the middle, looking level along z; what it needs
# ends with the stack.
MAKERS = {
    "recorded": lambda actions, ends: RecordedRobot(toy_scene(actions=actions), start=LEVEL),
    "simulated": lambda actions, ends: simulated(actions=actions),
    "ai2thor": lambda actions, ends: ThorRobot(
        StandIn(toy_scene(), ("Mug", "Apple", "Mug")), ThorConfig(grid=STEP, image_size=48), actions, start=LEVEL
    ),
    "ros": behind_rosbridge,
}


@pytest.fixture(params=MAKERS)
def make(request):
    with ExitStack() as ends:
        yield lambda actions: MAKERS[request.param](actions, ends)


@pytest.fixture
def exactness(request):
    """Metres and degrees by which the robot may miss what it was told; one that runs in quick motion misses more."""
    return (0.1, 10.0) if request.node.callspec.params["make"] == "ros" else (0.03, 3.0)


def off(pose, other):
    """Metres, and degrees of heading and tilt, between two poses."""
    turned = abs((pose[2] - other[2] + 180) % 360 - 180)
    return np.hypot(pose[0] - other[0], pose[1] - other[1]), turned, abs(pose[3] - other[3])


def same(pose, other, exactness):
    metres, turned, tilted = off(pose, other)
    return metres < exactness[0] and max(turned, tilted) < exactness[1]


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
def test_what_it_does_it_says_and_can_undo(make, exactness, there, back):
    with make(EIGHT_ACTIONS) as robot:
        before, seen = robot.pose(), robot.look()
        assert robot.execute(there) is True
        assert not same(robot.pose(), before, exactness)
        assert (robot.look() != seen).any()
        assert robot.execute(back) is True
        assert same(robot.pose(), before, exactness)


def test_four_turns_come_round(make, exactness):
    with make(EIGHT_ACTIONS) as robot:
        before = robot.pose()
        for turn in range(1, 5):
            assert robot.execute(Action.ROTATE_RIGHT)
            turned = off(robot.pose(), before)[1]
            assert turned == pytest.approx(min(90 * turn, 360 - 90 * turn), abs=exactness[1])
        assert same(robot.pose(), before, exactness)


def test_what_is_blocked_changes_nothing(make, exactness):
    with make(EIGHT_ACTIONS) as robot:
        for _ in range(30):
            before = robot.pose()
            if not robot.execute(Action.MOVE_AHEAD):
                break
        else:
            pytest.fail("it drove on for ever")
        assert same(robot.pose(), before, exactness)


def test_a_look_beyond_the_outermost_changes_nothing(make):
    with make(EIGHT_ACTIONS) as robot:
        while robot.execute(Action.LOOK_UP):
            pass
        before = robot.pose()
        assert robot.execute(Action.LOOK_UP) is False
        assert robot.pose() == before


def test_it_refuses_what_it_may_not_do(make):
    with make(TURTLEBOT_ACTIONS) as robot:
        assert robot.actions == TURTLEBOT_ACTIONS
        before = robot.pose()
        with pytest.raises(UserError, match="has no action MoveLeft"):
            robot.execute(Action.MOVE_LEFT)
        assert robot.pose() == before


def test_it_can_be_stopped_at_any_time(make):
    robot = make(EIGHT_ACTIONS)
    robot.stop()
    with robot:
        robot.execute(Action.ROTATE_LEFT)
        robot.stop()
        robot.stop()
    with pytest.raises(ZeroDivisionError), robot:
        raise ZeroDivisionError
