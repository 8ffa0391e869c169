"""Where a robot is in a known room: against the plain rule of Bayes, and against being led astray by one view."""

import numpy as np
import pytest

from active_perceiver.agent.exploration.localization import ALIKENESS, ASTRAY, BLOCKED, BayesFilter

# Five states in a row; action 0 leads to the next, action 1 back.
ROW = np.array([[1, 0], [2, 0], [3, 1], [4, 2], [4, 3]])
CLEAR = 20 * ALIKENESS


def like(state, others=()):
    """Likeness of a view that is clearly most like one state, and others equally."""
    likeness = np.full(5, 1 - CLEAR)
    likeness[[state, *others]] = 1.0
    return likeness


def by_hand(belief, likeness, action, robot_moved):
    """The belief after a look, state by state."""
    led = np.zeros(5)
    for state in range(5):
        to = ROW[state, action]
        if robot_moved and to != state:
            led[to] += belief[state]
        elif robot_moved is False:
            led[state] += belief[state]
        elif robot_moved is None:
            led[to] += (1 - BLOCKED) * belief[state]
            led[state] += BLOCKED * belief[state]
    led /= led.sum()
    weighed = ((1 - ASTRAY) * led + ASTRAY / 5) * np.exp(likeness / ALIKENESS)
    return weighed / weighed.sum()


@pytest.mark.parametrize("robot_moved", [True, False, None])
@pytest.mark.parametrize("seed", range(5))
def test_it_is_the_rule_of_bayes(robot_moved, seed):
    rng = np.random.default_rng(seed)
    where, belief = BayesFilter(5), None
    for step in range(6):
        likeness = 1 - rng.uniform(0, 4 * ALIKENESS, 5)
        action = None if step == 0 else int(rng.integers(2))
        state = where.update(likeness, ROW, action, robot_moved)
        if belief is None:
            belief = np.exp(likeness / ALIKENESS) / np.exp(likeness / ALIKENESS).sum()
        else:
            belief = by_hand(belief, likeness, action, robot_moved)
        np.testing.assert_allclose(where._belief, belief, atol=1e-12)
        assert state == belief.argmax()


def test_what_looks_the_same_is_told_apart_by_the_way():
    where = BayesFilter(5)
    assert where.update(like(0), ROW, None, None) == 0
    assert where.update(like(1, others=[3, 4]), ROW, 0, True) == 1
    assert where.update(like(2, others=[4]), ROW, 0, True) == 2


def test_a_little_more_alike_elsewhere_does_not_lead_astray():
    where = BayesFilter(5)
    where.update(like(1), ROW, None, None)
    likeness = like(2)
    likeness[4] += 2 * ALIKENESS
    assert where.update(likeness, ROW, 0, True) == 2


def test_a_robot_that_was_carried_away_is_found_again():
    where = BayesFilter(5)
    where.update(like(0), ROW, None, None)
    assert where.update(like(4), ROW, 0, True) == 4


def test_one_that_says_that_it_did_not_move_is_where_it_was():
    where = BayesFilter(5)
    where.update(like(1), ROW, None, None)
    assert where.update(like(1, others=[2]), ROW, 0, False) == 1
    assert where.update(like(1, others=[2]), ROW, 0, True) == 2


def test_moves_from_where_none_is_possible_leave_everything_open():
    blocked = np.arange(3)[:, None]
    where = BayesFilter(3)
    where.update(np.array([1.0, 0.9, 0.9]), blocked, None, None)
    assert where.update(np.array([0.9, 0.9, 1.0]), blocked, 0, True) == 2
