"""Searches that end by the agent's own word, against a slow loop."""

import numpy as np
import pytest

from active_perceiver.agent.goals.goal import GoalObservation
from active_perceiver.agent.visit_memory import ViewFeatures
from active_perceiver.evaluation import stop_evaluation
from active_perceiver.scenes.lattice import goal_states, steps_to_goal


@pytest.fixture
def tables(scene):
    rng = np.random.default_rng(1)
    raw = rng.random((len(scene), 2, 8)) ** 3
    return raw / raw.sum(-1, keepdims=True)


def search(scene, tables, found, detected, searches=400, seed=0, nearly=None):
    goals = goal_states(scene.areas)[:, 0]
    asked = stop_evaluation.SearchTables(
        scene="toy",
        target="ball0",
        probabilities=tables,
        goal_observations=lambda state, picture: GoalObservation(
            None, found[state, picture], nearly is None or nearly[state, picture]
        ),
        right=stop_evaluation.is_on_object(detected, scene.boxes[:, 0]),
        transitions=scene.transitions,
        steps=steps_to_goal(scene.transitions, goals),
        views=ViewFeatures.of_scene(np.eye(len(scene), dtype=np.float32)),
        confirm=nearly is not None,
    )
    return stop_evaluation.search_until_found(asked, searches, np.random.default_rng(seed))


def perfect(scene):
    detected = np.repeat(np.nan_to_num(scene.boxes[:, :1]), 2, axis=1)
    goals = np.repeat(goal_states(scene.areas)[:, :1], 2, axis=1)
    return goals, detected


def test_a_perfect_eye_finds_truly_and_at_goals(scene, tables):
    result = search(scene, tables, *perfect(scene))
    assert result.true_found == pytest.approx(1.0, abs=0.02)
    assert result.at_goal == result.true_found
    assert result.false_found == 0


def test_shares_add_up_and_a_box_elsewhere_is_false(scene, tables):
    found, detected = perfect(scene)
    detected = np.clip(1 - detected, 0.01, 0.99)
    result = search(scene, tables, found, detected)
    assert result.true_found + result.false_found + result.not_found == pytest.approx(1)
    assert result.false_found > 0.5


def test_who_never_says_found_gives_up(scene, tables):
    _, detected = perfect(scene)
    result = search(scene, tables, np.zeros((len(scene), 2), bool), detected, searches=3)
    assert result.not_found == 1
    assert np.isnan(result.mean_steps)


def slow_search(scene, tables, found, nearly, rng):
    """Actions of one search, written out: what is blocked is left out until the robot has moved."""
    starts = np.flatnonzero(~found[:, 0])
    state, picture, steps, before = int(rng.choice(starts)), int(rng.integers(2)), 0, nearly is None
    looks, blocked = dict.fromkeys(range(len(scene)), 0), set()
    while not (found[state, picture] and before):
        chances = tables[state, picture] ** (1 / (1 + looks[state]))
        chances[list(blocked)] = 0
        looks[state] += 1
        action = rng.choice(8, p=chances / chances.sum())
        there = int(scene.transitions[state, action])
        if there == state:
            blocked.add(action)
        else:
            blocked.clear()
            before = nearly is None or nearly[state, picture]
        state = there
        steps += 1
    return steps


def test_mean_steps_agree_with_a_slow_loop(scene, tables):
    """With confirm, found counts only if the last other view was nearly enough; bumping into something is none."""
    found, detected = perfect(scene)
    some = np.random.default_rng(2).random(found.shape) < 0.8
    rng, means = np.random.default_rng(5), []
    for nearly in (None, some):
        fast = search(scene, tables, found, detected, searches=800, nearly=nearly)
        lengths = [slow_search(scene, tables, found, nearly, rng) for _ in range(300)]
        error = np.std(lengths) / np.sqrt(len(lengths)) + np.std(lengths) / np.sqrt(800)
        assert fast.true_found > 0.98
        assert abs(np.mean(lengths) - fast.mean_steps) < 4 * error
        means.append(fast.mean_steps)
    assert means[1] > means[0]


def test_without_a_view_that_is_nearly_enough_nothing_is_found(scene, tables):
    found, detected = perfect(scene)
    result = search(scene, tables, found, detected, searches=20, nearly=np.zeros_like(found))
    assert result.not_found == 1


def test_the_same_seed_gives_the_same_result(scene, tables):
    assert search(scene, tables, *perfect(scene)) == search(scene, tables, *perfect(scene))


def test_a_loop_is_left(scene, tables):
    """A policy that only turns left and right for ever comes away from where it is, because it remembers."""
    found, detected = perfect(scene)
    stuck = np.full_like(tables, 1e-6)
    stuck[..., 4] = 1.0
    assert search(scene, stuck / stuck.sum(-1, keepdims=True), found, detected, searches=50).true_found > 0.5
