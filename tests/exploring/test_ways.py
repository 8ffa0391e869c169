"""What is remembered of the ways through a room is what would be computed anew."""

import numpy as np
import pytest

from active_perceiver.exploring import ways as module
from active_perceiver.exploring.ways import Ways
from active_perceiver.scenes.lattice import UNREACHABLE, steps_from, steps_to_goal


def agree(ways, transitions):
    """Ask for every way twice, in any order, and compare."""
    states = len(transitions)
    for state in np.random.default_rng(1).permutation(np.repeat(np.arange(states), 2)).tolist():
        np.testing.assert_array_equal(ways.to(state), steps_to_goal(transitions, np.arange(states) == state))
        np.testing.assert_array_equal(ways.away(state), steps_from(transitions, state))


@pytest.mark.parametrize("seed", range(3))
def test_ways_are_the_shortest_whatever_is_blocked_in_between(seed):
    rng = np.random.default_rng(seed)
    transitions = rng.integers(0, 30, (30, 3)).astype(np.int32)
    ways, before = Ways(transitions), transitions.copy()
    agree(ways, transitions)
    left, blocked = ways, transitions.copy()
    for state, action in zip(rng.integers(0, 30, 5).tolist(), rng.integers(0, 3, 5).tolist(), strict=True):
        left = left.without(state, action)
        blocked[state, action] = state
        agree(left, blocked)
    agree(ways, before)


def test_no_more_is_remembered_than_there_is_room_for(monkeypatch):
    monkeypatch.setattr(module, "MOST_REMEMBERED", 100)
    transitions = np.random.default_rng(4).integers(0, 30, (30, 3)).astype(np.int32)
    ways = Ways(transitions)
    agree(ways, transitions)
    assert 1 <= len(ways._to) <= 3
    assert 1 <= len(ways._from) <= 3


def test_what_is_blocked_already_changes_nothing():
    ways = Ways(np.array([[0, 1], [1, 0]], np.int32))
    assert ways.without(0, 0) is ways
    assert ways.without(0, 1).away(0).tolist() == [0, UNREACHABLE]
    assert ways.without(0, 1).to(1).tolist() == [UNREACHABLE, 0]


def test_a_state_that_is_not_in_the_room_is_an_error():
    with pytest.raises(IndexError):
        Ways(np.zeros((2, 3), np.int32)).away(2)
