"""What a search does next: when it is lost, for how long, what it then takes to say found, and how it draws."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from active_perceiver.agent.controller import EXPLORATION_BUDGET, REVISIT_LIMIT, SearchController
from active_perceiver.agent.exploration import Explorer, ViewMap
from active_perceiver.agent.goals.goal import GoalObservation
from active_perceiver.agent.search_policy import Observation
from active_perceiver.agent.visit_memory import ViewFeatures
from active_perceiver.recognition.recogniser import Detection

NOTHING = GoalObservation(None, found=False, nearly=False)


@pytest.fixture
def room(scene) -> ViewMap:
    """The small scene, every view unlike all others."""
    return ViewMap.of(scene, np.random.default_rng(0).normal(size=(len(scene), 64)))


def even(observation):
    return np.full(8, 1 / 8)


def look(room, state, goal=NOTHING, robot_moved=None):
    return Observation(goal, ViewFeatures.of(room.descriptors[state], room), robot_moved)


def lost(room, controller, state=0):
    """Let a controller look at one state until it explores; how often it did."""
    for looks in range(1, 10):
        controller.step(look(room, state))
        if controller.exploring:
            return looks
    raise AssertionError("it never explores")


def test_a_search_is_lost_for_a_while_and_longer_each_time(room):
    controller = SearchController(even, explorer=Explorer(room, 1.0, 0.5))
    fresh = iter(range(10, len(room.descriptors)))
    lasted = []
    for place in range(3):
        assert lost(room, controller, place) == REVISIT_LIMIT + 1
        looks = 1
        while controller.exploring:
            decision = controller.step(look(room, next(fresh)))
            assert (
                decision.probabilities.max() == 1.0
            ) == controller.exploring  # the explorer's way, not the policy's
            looks += controller.exploring
        lasted.append(looks)
    assert lasted == [EXPLORATION_BUDGET, 2 * EXPLORATION_BUDGET, 4 * EXPLORATION_BUDGET]


def test_it_stays_lost_while_it_knows_where_to_go_instead(room, scene):
    explorer = Explorer(room, 1.0, 0.5)
    controller = SearchController(even, explorer=explorer)
    states = np.flatnonzero(scene.areas[:, 0] > 0)[:12]
    for state in states:
        seen = GoalObservation(Detection(0.999, scene.boxes[state, 0]), found=False, nearly=False)
        controller.step(look(room, state, seen))
    assert explorer.follows()
    for _ in range(REVISIT_LIMIT):
        controller.step(look(room, states[0]))
    for _ in range(3 * EXPLORATION_BUDGET):
        controller.step(look(room, states[0]))
        assert controller.exploring


def test_without_an_explorer_it_is_never_lost(room):
    controller = SearchController(even)
    for _ in range(10 * REVISIT_LIMIT):
        decision = controller.step(look(room, 0))
        assert not controller.exploring
        assert not decision.found
        assert decision.probabilities.max() < 0.5


def test_a_lost_search_takes_two_views_to_say_found(room):
    seen = GoalObservation(Detection(0.99, np.array([0.5, 0.5, 0.4, 0.4])), found=True, nearly=True)
    straight = SearchController(even, explorer=Explorer(room, 1.0, 0.5))
    assert straight.step(look(room, 0, seen)).found
    exploring = SearchController(even, explorer=Explorer(room, 1.0, 0.5))
    lost(room, exploring)
    assert not exploring.step(look(room, 1, seen)).found
    assert not exploring.step(look(room, 1, seen)).found  # the same view again
    assert exploring.step(look(room, 2, seen)).found


def test_an_explorer_needs_to_know_what_the_view_is_like(room):
    controller = SearchController(even, explorer=Explorer(room, 1.0, 0.5))
    with pytest.raises(ValueError, match="how alike the view is"):
        controller.step(Observation(NOTHING, ViewFeatures.of(room.descriptors[0])))


def test_what_the_robot_says_of_its_moves_counts_more_than_the_views(room):
    """A robot that has moved may see the same again: nothing is blocked, and the look before was at another view."""
    nearly = GoalObservation(None, found=False, nearly=True)
    found = GoalObservation(None, found=True, nearly=True)
    for robot_moved, expected in ((True, True), (False, False), (None, False)):
        controller = SearchController(even, confirm=True)
        controller.step(look(room, 0, nearly))
        assert controller.step(look(room, 0, found, robot_moved)).found == expected


@given(
    weights=st.lists(st.floats(0.01, 1.0), min_size=2, max_size=8),
    moves=st.lists(st.sampled_from([True, False, None]), max_size=20),
    seed=st.integers(0, 2**32 - 1),
)
def test_it_draws_as_numpy_does_and_never_what_is_blocked(weights, moves, seed):
    """The seed gives the draws of `Generator.choice`; what did not move the robot is left out until it has moved."""
    policy = np.array(weights, np.float32) / np.sum(weights, dtype=np.float32)
    controller = SearchController(lambda _: policy, seed=seed)
    rng, blocked, last = np.random.default_rng(seed), set(), -1
    view = ViewFeatures.of(np.ones(4, np.float32))
    for robot_moved in [None, *moves]:
        decision = controller.step(Observation(NOTHING, view, robot_moved))
        blocked = blocked | {last} if robot_moved is False else set() if robot_moved else blocked
        assert decision.action == rng.choice(len(policy), p=decision.probabilities)
        assert decision.probabilities.sum() == pytest.approx(1)
        if len(blocked) < len(policy):
            assert not decision.probabilities[list(blocked)].any()
        else:
            assert decision.probabilities.all()
        last = decision.action
