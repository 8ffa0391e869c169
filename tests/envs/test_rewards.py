"""The rewards, as the paper words them."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from active_perceiver.envs import REWARDS, SearchError, SearchTask, reward_named

areas = st.lists(st.floats(0, 1, width=32), min_size=1, max_size=12)


def pay(name, episode, goal_at_end=False, goal_area=1.0):
    """Rewards of the steps of an episode that sees these areas."""
    best_area, paid = episode[0], []
    for step, area in enumerate(episode[1:], 1):
        paid.append(
            float(REWARDS[name].function(area, best_area, goal_at_end and step == len(episode) - 1, goal_area))
        )
        best_area = max(best_area, area)
    return paid


@given(areas)
def test_record_is_equation_2(episode):
    expected = [
        area if all(area > earlier for earlier in episode[:step]) else 0.0 for step, area in enumerate(episode)
    ][1:]
    assert pay("record", episode) == expected


@given(areas)
def test_gain_over_an_episode_is_at_most_its_weight(episode):
    paid = pay("gain", episode)
    assert sum(paid) <= 0.3 - 0.02 * len(paid) + 1e-6


def test_a_larger_goal_gains_no_more():
    small, large = (pay("gain", [0, area], goal_at_end=True, goal_area=0.2) for area in (0.2, 0.9))
    assert small == large == pytest.approx([1.28])


def test_known_values():
    assert pay("goal", [0, 0.1, 0.2], goal_at_end=True) == [-0.01, 10]
    assert pay("area", [0, 0.1, 0.05]) == [0.1, 0.05]
    assert pay("arrival", [0, 0.1, 0.2], goal_at_end=True) == pytest.approx([-0.02, 0.98])
    assert pay("gain", [0.1, 0.3, 0.2, 0.4], goal_at_end=True, goal_area=0.4) == pytest.approx(
        [0.15 - 0.02, -0.02, 0.075 + 0.98]
    )


@pytest.mark.parametrize("reward", REWARDS.values(), ids=lambda reward: reward.name)
def test_markov_says_whether_the_record_matters(reward):
    area, goal = np.array([0.1, 0.2, 0.3]), np.array([False, False, True])
    few, many = (reward.function(area, np.full(3, best_area), goal, 0.3) for best_area in (0.0, 0.25))
    assert few.shape == (3,)
    assert reward.markov == np.array_equal(few, many)


@pytest.mark.parametrize("reward", REWARDS.values(), ids=lambda reward: reward.name)
def test_largest_bounds_every_step(scene, reward):
    task = SearchTask.from_scene(scene)
    for best_area in (0.0, 0.01, 1.0):
        paid = reward.function(task.areas, np.full_like(task.areas, best_area), task.goals, task.goal_areas)
        assert np.abs(paid).max() <= reward.largest(task) + 1e-9


def test_unknown_reward():
    with pytest.raises(SearchError, match="no reward 'fun'; choose one of gain, arrival"):
        reward_named("fun")
