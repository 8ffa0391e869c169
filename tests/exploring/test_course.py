"""The course of a search: when it is lost, for how long, and what it then takes to say found."""

import numpy as np
import pytest

from active_perceiver.course import EXCURSION, LOST, Course
from active_perceiver.exploring import Explorer, RoomMap
from active_perceiver.known_targets import Sight
from active_perceiver.recognition.recogniser import Detection

NOTHING = Sight(None, found=False, nearly=False)


@pytest.fixture
def room(scene) -> RoomMap:
    """The small scene, every view unlike all others."""
    return RoomMap.of(scene, np.random.default_rng(0).normal(size=(len(scene), 64)))


def decide(course, room, *, state=0, sight=NOTHING, earlier=0, moved=True):
    even = np.full(room.transitions.shape[1], 1 / room.transitions.shape[1])
    likeness = room.looks @ room.looks[state]
    return course.decide(sight, even, earlier=earlier, moved=moved, likeness=likeness, told=None)


def test_a_search_is_lost_for_a_while_and_longer_each_time(room):
    course = Course(explorer=Explorer(room, 1.0, 0.5))
    lasted = []
    for _ in range(3):
        for earlier in range(LOST):
            decide(course, room, earlier=earlier)
            assert not course.lost
        probabilities, _ = decide(course, room, earlier=LOST)
        assert course.lost
        assert probabilities.max() == 1.0  # the explorer's way, not the policy's
        looks = 1
        while course.lost:
            decide(course, room)
            looks += course.lost
        lasted.append(looks)
    assert lasted == [EXCURSION, 2 * EXCURSION, 4 * EXCURSION]


def test_it_stays_lost_while_it_knows_where_to_go_instead(room, scene):
    explorer = Explorer(room, 1.0, 0.5)
    course = Course(explorer=explorer)
    states = np.flatnonzero(scene.areas[:, 0] > 0)[:12]
    for state in states:
        box = scene.boxes[state, 0]
        decide(course, room, state=state, sight=Sight(Detection(0.999, box), found=False, nearly=False), earlier=LOST)
    assert explorer.follows()
    for _ in range(3 * EXCURSION):
        decide(course, room, state=states[0])
        assert course.lost


def test_without_an_explorer_it_is_never_lost(room):
    course = Course()
    for _ in range(3):
        probabilities, found = decide(course, room, earlier=10 * LOST)
        assert not course.lost
        assert not found
        assert probabilities.max() < 0.5


def test_a_lost_search_takes_two_views_to_say_found(room):
    seen = Sight(Detection(0.99, np.array([0.5, 0.5, 0.4, 0.4])), found=True, nearly=True)
    straight = Course(explorer=Explorer(room, 1.0, 0.5))
    assert decide(straight, room, sight=seen)[1]
    lost = Course(explorer=Explorer(room, 1.0, 0.5))
    decide(lost, room, earlier=LOST)
    assert not decide(lost, room, state=1, sight=seen)[1]
    assert not decide(lost, room, state=1, sight=seen, moved=False)[1]  # the same view again
    assert decide(lost, room, state=2, sight=seen)[1]
