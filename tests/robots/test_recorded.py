"""A robot in a recorded scene."""

import numpy as np
import pytest

from active_perceiver.errors import UserError
from active_perceiver.robots import RecordedRobot, Robot
from active_perceiver.scenes import TURTLEBOT_ACTIONS, Action
from helpers.toy import toy_scene


def test_it_is_a_robot_that_walks_the_transitions(scene):
    with RecordedRobot(scene, start=7) as robot:
        assert isinstance(robot, Robot)
        np.testing.assert_array_equal(robot.look(), scene.view(7))
        assert robot.pose() == pytest.approx(tuple(scene.poses[7]))
        for action in scene.actions:
            before = robot.state
            robot.execute(action)
            assert robot.state == scene.transitions[before, scene.actions.index(action)]


def test_the_same_seed_gives_the_same_start(scene):
    starts = [RecordedRobot(scene, seed=seed).state for seed in range(20)]
    assert starts == [RecordedRobot(scene, seed=seed).state for seed in range(20)]
    assert len(set(starts)) > 5


@pytest.mark.parametrize("start", [-1, 192])
def test_a_start_that_is_no_state_is_refused(scene, start):
    with pytest.raises(UserError, match="states 0 to 191"):
        RecordedRobot(scene, start=start)


def test_an_action_the_scene_does_not_have_is_refused():
    robot = RecordedRobot(toy_scene(side=2, actions=TURTLEBOT_ACTIONS), start=0)
    with pytest.raises(UserError, match="has no action MoveLeft"):
        robot.execute(Action.MOVE_LEFT)
