"""Searches that end by the agent's own word, against a slow loop."""

import numpy as np
import pytest

from active_perceiver.agent.controller import SearchController
from active_perceiver.evaluation import stop_evaluation
from active_perceiver.goals.goal import GoalObservation
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
        alike=np.eye(len(scene), dtype=bool),
        controller=lambda picture: SearchController(confirm=nearly is not None),
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


def test_mean_steps_agree_with_a_slow_loop(scene, tables):
    found, detected = perfect(scene)
    fast = search(scene, tables, found, detected, searches=3000)
    rng = np.random.default_rng(5)
    starts = np.flatnonzero(~found[:, 0])
    lengths = []
    for _ in range(600):
        state, picture, steps = int(rng.choice(starts)), int(rng.integers(2)), 0
        descriptors = dict.fromkeys(range(len(scene)), 0)
        while not found[state, picture] and steps < stop_evaluation.LIMIT:
            chances = tables[state, picture] ** (1 / (1 + descriptors[state]))
            descriptors[state] += 1
            state = int(scene.transitions[state, rng.choice(8, p=chances / chances.sum())])
            steps += 1
        if found[state, picture]:
            lengths.append(steps)
    error = np.std(lengths) / np.sqrt(len(lengths))
    assert abs(np.mean(lengths) - fast.mean_steps) < 4 * error + 4 * np.std(lengths) / np.sqrt(3000)


def test_searches_of_two_views_agree_with_a_slow_loop(scene, tables):
    """Found counts only if the last other view was nearly enough; bumping into something is no other view."""
    found, detected = perfect(scene)
    nearly = np.random.default_rng(2).random(found.shape) < 0.8
    fast = search(scene, tables, found, detected, searches=3000, nearly=nearly)
    rng = np.random.default_rng(5)
    starts = np.flatnonzero(~found[:, 0])
    lengths = []
    for _ in range(600):
        state, picture, steps, before = int(rng.choice(starts)), int(rng.integers(2)), 0, False
        descriptors = dict.fromkeys(range(len(scene)), 0)
        while not (found[state, picture] and before):
            chances = tables[state, picture] ** (1 / (1 + descriptors[state]))
            descriptors[state] += 1
            there = int(scene.transitions[state, rng.choice(8, p=chances / chances.sum())])
            if there != state:
                before = nearly[state, picture]
            state = there
            steps += 1
        lengths.append(steps)
    assert fast.true_found > 0.98
    error = np.std(lengths) / np.sqrt(len(lengths))
    assert abs(np.mean(lengths) - fast.mean_steps) < 4 * error + 4 * np.std(lengths) / np.sqrt(3000)
    assert fast.mean_steps > search(scene, tables, found, detected, searches=3000).mean_steps


def test_without_a_view_that_is_nearly_enough_nothing_is_found(scene, tables):
    found, detected = perfect(scene)
    result = search(scene, tables, found, detected, searches=20, nearly=np.zeros_like(found))
    assert result.not_found == 1


def test_the_same_seed_gives_the_same_result(scene, tables):
    assert search(scene, tables, *perfect(scene)) == search(scene, tables, *perfect(scene))


@pytest.mark.parametrize(
    ("own", "expected"),
    [([0.3, 0.25, 0.4], 0.2), ([0.19, 0.15, 0.4], 0.15), ([0.01, 0.3, 0.3], 0.12), ([0.0, 0.0, 0.0], 0.12)],
)
def test_found_area_is_the_smallest_own_box_at_a_goal_within_limits(own, expected):
    areas = np.array([0.2, 0.3, 0.25, 0.05])
    goals = np.array([True, True, True, False])
    side = np.sqrt(np.array([*own, 0.9]))
    boxes = np.stack([np.full(4, 0.5), np.full(4, 0.5), side, side], 1)[:, None]
    scores = (side > 0).astype(float)[:, None]
    assert stop_evaluation.stop_area_threshold(scores, boxes, areas, goals, 0.5) == pytest.approx(
        stop_evaluation.MARGIN * expected
    )


def test_a_loop_is_left(scene, tables):
    """A policy that only turns left and right for ever comes away from where it is, because it remembers."""
    found, detected = perfect(scene)
    stuck = np.full_like(tables, 1e-6)
    stuck[..., 4] = 1.0
    assert search(scene, stuck / stuck.sum(-1, keepdims=True), found, detected, searches=50).true_found > 0.5


def test_alike_views_are_those_with_nearly_the_same_features():
    features = np.random.default_rng(0).random((20, 64)).astype(np.float32)
    features[7] = features[3] * 1.5
    alike = stop_evaluation.alike_views(features)
    assert alike[3, 7]
    assert alike.sum() == 22
