"""The search loop: limits, dry runs, what it notes of each look."""

import dataclasses
import itertools

import numpy as np
import pytest

from active_perceiver.agent.found_criterion import FoundCriterion
from active_perceiver.agent.perceiver import ActivePerceiver
from active_perceiver.live import SearchConfig, search
from active_perceiver.live.config import SearchLimitError
from active_perceiver.live.search_loop import FOUND, MAX_MINUTES, MAX_STEPS
from active_perceiver.robots import RecordedRobot
from active_perceiver.scenes.images import encode_image


@pytest.fixture(scope="module")
def agent(wanderer):
    return ActivePerceiver.from_pretrained(wanderer, threads=1)


@pytest.fixture
def picture(scene):
    return scene.targets[0].picture(0)


class Watched(RecordedRobot):
    """Notes what is asked of it."""

    def __init__(self, scene, start=7):
        super().__init__(scene, start)
        self.done, self.stops = [], 0

    def execute(self, action):
        before = self.state
        super().execute(action)
        self.done.append((action, self.state != before))
        return self.state != before

    def stop(self):
        self.stops += 1


def test_each_look_says_whether_the_action_before_it_moved_the_robot(agent, scene, picture):
    robot = Watched(scene)
    record = search(agent, robot, picture, SearchConfig(max_steps=60, seed=1))
    assert record.reason == MAX_STEPS
    assert (record.actions, len(record.step_records), robot.stops) == (60, 61, 1)
    assert record.step_records[0].robot_moved is None
    assert [step_record.robot_moved for step_record in record.step_records[1:]] == [
        robot_moved for _, robot_moved in robot.done
    ]
    assert {robot_moved for _, robot_moved in robot.done} == {True, False}
    for look, (action, robot_moved) in enumerate(robot.done):
        assert record.robot_moved(look) is robot_moved
        assert record.caption(look) == action.value + ("" if robot_moved else ", blocked")
    assert record.robot_moved(60) is None
    assert record.caption(60) == "not found"
    seconds = [step_record.seconds for step_record in record.step_records]
    assert seconds[0] > 0
    assert all(one <= other for one, other in itertools.pairwise([*seconds, record.seconds]))


def test_of_a_robot_that_does_not_say_whether_it_moved_nothing_is_noted(agent, scene, picture):
    class Silent(RecordedRobot):
        def execute(self, action):
            super().execute(action)

    record = search(agent, Silent(scene, 7), picture, SearchConfig(max_steps=3, seed=1))
    assert [step_record.robot_moved for step_record in record.step_records] == [None] * 4


def test_encoded_frames_are_kept_as_they_are(agent, scene, picture):
    class Camera(Watched):
        def look(self):
            return encode_image(super().look(), "png")

    encoded = search(agent, Camera(scene), picture, SearchConfig(max_steps=4, seed=1))
    plain = search(agent, Watched(scene), picture, SearchConfig(max_steps=4, seed=1))
    for one, other in zip(encoded.step_records, plain.step_records, strict=True):
        assert isinstance(one.frame, bytes)
        np.testing.assert_array_equal(one.image, other.image)
        assert one.pose == other.pose


def test_a_dry_run_moves_nothing_and_each_look_is_the_first(agent, scene, picture):
    robot = Watched(scene)
    record = search(agent, robot, picture, SearchConfig(max_steps=9, seed=3, dry_run=True, dry_pause=0.0))
    assert robot.done == []
    assert robot.stops == 1
    assert (len(record.step_records), record.actions, record.reason, record.found) == (9, 0, MAX_STEPS, False)
    for step_record in record.step_records:
        np.testing.assert_array_equal(step_record.step.probabilities, record.step_records[0].step.probabilities)
        assert step_record.robot_moved is None
    assert len({step_record.step.action for step_record in record.step_records}) > 1  # drawn, not frozen
    assert record.caption(0) == f"would {record.step_records[0].step.action.value}"
    assert record.ending == "end of the dry run"


@pytest.mark.parametrize("dry_run", [False, True])
def test_found_ends_a_search_but_no_dry_run(agent, scene, picture, dry_run, monkeypatch):
    credulous = ActivePerceiver(agent.folder, dataclasses.replace(agent.config, match_threshold=2.0), agent.backbone)
    monkeypatch.setattr(FoundCriterion, "met", lambda self, score, area: True)
    record = search(
        credulous, Watched(scene), picture, SearchConfig(max_steps=4, seed=0, dry_run=dry_run, dry_pause=0.0)
    )
    assert record.found
    assert (len(record.step_records), record.reason) == ((4, MAX_STEPS) if dry_run else (1, FOUND))
    assert record.caption(0) == ("would say found" if dry_run else "found")


def test_time_ends_a_search(agent, scene, picture):
    record = search(agent, Watched(scene), picture, SearchConfig(max_minutes=1e-9, seed=0))
    assert (record.reason, record.actions, record.ending) == (MAX_MINUTES, 0, "not found")


@pytest.mark.parametrize(
    "limits",
    [{"max_steps": 0}, {"max_steps": -3}, {"max_minutes": 0.0}, {"max_minutes": -1.0}, {"max_minutes": float("nan")}],
    ids=str,
)
def test_limits_that_no_search_can_keep_to_are_refused(agent, scene, picture, limits):
    robot = Watched(scene)
    with pytest.raises(SearchLimitError, match="a search needs"):
        search(agent, robot, picture, SearchConfig(**limits))
    assert robot.done == []
    assert robot.stops == 1
