"""The course of a search: when it is lost, for how long, and what it then takes to say found."""

import numpy as np
import pytest

from active_perceiver.agent.controller import EXPLORATION_BUDGET, REVISIT_LIMIT, SearchController
from active_perceiver.agent.exploration import Explorer, ViewMap
from active_perceiver.goals.goal import GoalObservation
from active_perceiver.recognition.recogniser import Detection

NOTHING = GoalObservation(None, found=False, nearly=False)


@pytest.fixture
def room(scene) -> ViewMap:
    """The small scene, every view unlike all others."""
    return ViewMap.of(scene, np.random.default_rng(0).normal(size=(len(scene), 64)))


def decide(controller, room, *, state=0, goal_observation=NOTHING, earlier=0, view_changed=True):
    even = np.full(room.transitions.shape[1], 1 / room.transitions.shape[1])
    likeness = room.descriptors @ room.descriptors[state]
    return controller.step(
        goal_observation, even, earlier=earlier, view_changed=view_changed, likeness=likeness, robot_moved=None
    )


def test_a_search_is_lost_for_a_while_and_longer_each_time(room):
    controller = SearchController(explorer=Explorer(room, 1.0, 0.5))
    lasted = []
    for _ in range(3):
        for earlier in range(REVISIT_LIMIT):
            decide(controller, room, earlier=earlier)
            assert not controller.exploring
        probabilities, _ = decide(controller, room, earlier=REVISIT_LIMIT)
        assert controller.exploring
        assert probabilities.max() == 1.0  # the explorer's way, not the policy's
        looks = 1
        while controller.exploring:
            decide(controller, room)
            looks += controller.exploring
        lasted.append(looks)
    assert lasted == [EXPLORATION_BUDGET, 2 * EXPLORATION_BUDGET, 4 * EXPLORATION_BUDGET]


def test_it_stays_lost_while_it_knows_where_to_go_instead(room, scene):
    explorer = Explorer(room, 1.0, 0.5)
    controller = SearchController(explorer=explorer)
    states = np.flatnonzero(scene.areas[:, 0] > 0)[:12]
    for state in states:
        box = scene.boxes[state, 0]
        decide(
            controller,
            room,
            state=state,
            goal_observation=GoalObservation(Detection(0.999, box), found=False, nearly=False),
            earlier=REVISIT_LIMIT,
        )
    assert explorer.follows()
    for _ in range(3 * EXPLORATION_BUDGET):
        decide(controller, room, state=states[0])
        assert controller.exploring


def test_without_an_explorer_it_is_never_lost(room):
    controller = SearchController()
    for _ in range(3):
        probabilities, found = decide(controller, room, earlier=10 * REVISIT_LIMIT)
        assert not controller.exploring
        assert not found
        assert probabilities.max() < 0.5


def test_a_lost_search_takes_two_views_to_say_found(room):
    seen = GoalObservation(Detection(0.99, np.array([0.5, 0.5, 0.4, 0.4])), found=True, nearly=True)
    straight = SearchController(explorer=Explorer(room, 1.0, 0.5))
    assert decide(straight, room, goal_observation=seen)[1]
    exploring = SearchController(explorer=Explorer(room, 1.0, 0.5))
    decide(exploring, room, earlier=REVISIT_LIMIT)
    assert not decide(exploring, room, state=1, goal_observation=seen)[1]
    assert not decide(exploring, room, state=1, goal_observation=seen, view_changed=False)[1]  # the same view again
    assert decide(exploring, room, state=2, goal_observation=seen)[1]
