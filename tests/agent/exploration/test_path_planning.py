"""What is remembered of the ways through a room is what would be computed anew."""

import numpy as np
import pytest

from active_perceiver.agent.exploration import path_planning as module
from active_perceiver.agent.exploration.path_planning import ShortestPaths
from active_perceiver.scenes.lattice import UNREACHABLE, steps_from, steps_to_goal


def agree(shortest_paths, transitions):
    """Ask for every way twice, in any order, and compare."""
    states = len(transitions)
    for state in np.random.default_rng(1).permutation(np.repeat(np.arange(states), 2)).tolist():
        np.testing.assert_array_equal(
            shortest_paths.to(state), steps_to_goal(transitions, np.arange(states) == state)
        )
        np.testing.assert_array_equal(shortest_paths.away(state), steps_from(transitions, state))


@pytest.mark.parametrize("seed", range(3))
def test_ways_are_the_shortest_whatever_is_blocked_in_between(seed):
    rng = np.random.default_rng(seed)
    transitions = rng.integers(0, 30, (30, 3)).astype(np.int32)
    shortest_paths, before = ShortestPaths(transitions), transitions.copy()
    agree(shortest_paths, transitions)
    left, blocked = shortest_paths, transitions.copy()
    for state, action in zip(rng.integers(0, 30, 5).tolist(), rng.integers(0, 3, 5).tolist(), strict=True):
        left = left.without(state, action)
        blocked[state, action] = state
        agree(left, blocked)
    agree(shortest_paths, before)


def test_no_more_is_remembered_than_there_is_room_for(monkeypatch):
    monkeypatch.setattr(module, "MOST_REMEMBERED", 100)
    transitions = np.random.default_rng(4).integers(0, 30, (30, 3)).astype(np.int32)
    shortest_paths = ShortestPaths(transitions)
    agree(shortest_paths, transitions)
    assert 1 <= len(shortest_paths._to) <= 3
    assert 1 <= len(shortest_paths._from) <= 3


def test_what_is_blocked_already_changes_nothing():
    shortest_paths = ShortestPaths(np.array([[0, 1], [1, 0]], np.int32))
    assert shortest_paths.without(0, 0) is shortest_paths
    assert shortest_paths.without(0, 1).away(0).tolist() == [0, UNREACHABLE]
    assert shortest_paths.without(0, 1).to(1).tolist() == [UNREACHABLE, 0]


def test_a_state_that_is_not_in_the_room_is_an_error():
    with pytest.raises(IndexError):
        ShortestPaths(np.zeros((2, 3), np.int32)).away(2)
