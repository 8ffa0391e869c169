"""Exact evaluation against dense algebra, against episodes, and episodes against the environment."""

import json

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from active_perceiver.envs import SearchEnv, SearchError, SearchTask
from active_perceiver.policies import RandomPolicy, policy_table
from active_perceiver.policies.evaluation import episode_evaluation, exact_evaluation, mean_evaluation
from active_perceiver.policies.hitting_times import exact_hitting_times
from active_perceiver.policies.sampling import run_episode
from helpers.problems import random_table, toy_task


@pytest.fixture(scope="module")
def training_task():
    return toy_task()


@pytest.fixture(scope="module")
def task(training_task):
    return training_task.task


def shortest_table(task):
    """The policy that takes a shortest path."""
    best = task.steps[task.transitions].transpose(0, 2, 1)
    best = np.where(best < 0, best.max() + 1, best).argmin(axis=-1)
    return np.eye(len(task.actions), dtype=np.float32)[best]


def test_shortest_paths_are_perfect(task):
    evaluation = exact_evaluation(shortest_table(task), task)
    for target, result in enumerate((*evaluation.per_target, evaluation.overall)):
        assert (result.success, result.ratio, result.spl) == pytest.approx((1, 1, 1))
        if target < len(task.targets):
            steps = task.steps[task.starts(target), target]
            assert result.mean_steps == pytest.approx(steps.mean())
            assert result.median_steps == np.quantile(steps, 0.5, method="inverted_cdf")
            assert (result.scene, result.target) == (task.scene, task.targets[target])


@settings(max_examples=15, deadline=None)
@given(seed=st.integers(0, 10**6), sharpness=st.floats(0, 3), limit=st.sampled_from([1, 7, 40, 5000]))
def test_equals_dense_algebra(task, seed, sharpness, limit):
    table = random_table(task, seed, sharpness)
    result = exact_evaluation(table, task, limit).per_target[0]
    starts = task.starts(0)
    chain = np.zeros((len(task), len(task)))
    for state in range(len(task)):
        for action, next_states in enumerate(task.transitions[state]):
            chain[state, next_states] += table[state, 0, action]
    inside = chain[np.ix_(starts, starts)]
    under_way = np.linalg.matrix_power(inside, limit)
    assert result.success == pytest.approx(1 - under_way.sum(1).mean(), abs=1e-5)
    if limit == 5000 and result.success > 1 - 1e-7:
        steps = np.linalg.solve(np.eye(len(starts)) - inside, np.ones(len(starts)))
        assert result.mean_steps == pytest.approx(steps.mean(), rel=1e-4)
        assert result.ratio == pytest.approx(steps.mean() / task.steps[starts, 0].mean(), rel=1e-4)


def test_agrees_with_many_episodes(task):
    table = random_table(task, 1)
    limit, episodes = 30, 4000
    exact = exact_evaluation(table, task, limit)
    sampled = episode_evaluation(table, task, episodes, limit, rng=1)
    for one, other in zip((*exact.per_target, exact.overall), (*sampled.per_target, sampled.overall), strict=True):
        error = 4 / np.sqrt(episodes)
        assert other.success == pytest.approx(one.success, abs=error)
        assert other.spl == pytest.approx(one.spl, abs=error)
        assert other.mean_steps == pytest.approx(one.mean_steps, abs=error * limit / 2)
        assert other.shortest_mean == pytest.approx(one.shortest_mean, abs=error * 5)
        assert other.median_steps == pytest.approx(one.median_steps, abs=1)
    assert 0.5 < exact.overall.success < 0.99, "the limit should cut some searches off"


def test_episodes_do_what_the_environment_does(training_task):
    """The paper's protocol as a plain loop over environment steps."""
    task, limit, episodes = training_task.task, 30, 150
    table = random_table(task, 2)
    env = SearchEnv(task=task, observations=training_task.observations, max_steps=limit)
    rng = np.random.default_rng(0)
    found, lengths, spl = [], [], []
    env.reset(seed=0)
    for target in range(len(task.targets)):
        for _ in range(episodes):
            _, info = env.reset(options={"target": target})
            shortest, count, done, arrived = info["shortest"], 0, False, False
            while not done:
                chances = table[info["state"], target].astype(float)
                action = rng.choice(len(task.actions), p=chances / chances.sum())
                *_, arrived, late, info = env.step(action)
                count, done = count + 1, arrived or late
            found.append(arrived)
            spl.append(shortest / count * arrived)
            lengths += [count] * arrived
    result = episode_evaluation(table, task, 2000, limit, rng=0).overall
    assert result.success == pytest.approx(np.mean(found), abs=0.1)
    assert result.spl == pytest.approx(np.mean(spl), abs=0.1)
    assert result.mean_steps == pytest.approx(np.mean(lengths), rel=0.15)


def test_random_walk_is_a_policy(training_task):
    policy = RandomPolicy({"toy_0": training_task.task.actions})
    table = policy_table(policy, training_task.observations, "toy_0")
    assert table.shape == (*training_task.task.goals.shape, 8)
    assert (table == np.float32(1 / 8)).all()
    assert exact_evaluation(table, training_task.task).overall.ratio > 3


def test_lost_searches_fail_but_do_not_count_as_starts():
    """A chain of four states: from the start one action leads on, one into a trap."""
    transitions = np.array([[1, 3], [2, 2], [2, 2], [3, 3]], np.int32)
    goals = np.array([[False], [False], [True], [False]])
    steps = np.array([[2], [1], [0], [-1]])
    task = SearchTask("trap", ("on", "off"), ("cup",), transitions, goals.astype(np.float32), goals, steps)
    table = np.full((4, 1, 2), 0.5, np.float32)
    result = exact_evaluation(table, task).per_target[0]
    assert result.success == pytest.approx((0.5 + 1) / 2)
    assert result.mean_steps == pytest.approx((0.5 * 2 + 1 * 1) / 1.5)
    assert result.shortest_mean == result.mean_steps
    assert result.ratio == 1
    assert result.spl == pytest.approx(0.75)
    sampled = episode_evaluation(table, task, 2000, limit=10, rng=0).per_target[0]
    assert sampled.success == pytest.approx(0.75, abs=0.05)


def test_nothing_found_is_null_in_json():
    goals = np.array([[False], [True]])
    transitions, steps = np.array([[1, 0], [1, 1]], np.int32), np.array([[1], [0]])
    task = SearchTask("line", ("go", "stay"), ("cup",), transitions, goals.astype(np.float32), goals, steps)
    said = exact_evaluation(np.tile(np.float32([0, 1]), (2, 1, 1)), task).as_dict()
    assert said["overall"]["success"] == said["overall"]["spl"] == 0
    assert said["overall"]["mean_steps"] is said["overall"]["median_steps"] is said["overall"]["ratio"] is None
    assert json.loads(json.dumps(said, allow_nan=False)) == said
    assert set(said) == {"protocol", "overall", "per_target"}
    keys = ["scene", "target", "success", "mean_steps", "median_steps", "shortest_mean", "ratio", "spl"]
    assert [list(row) for row in said["per_target"]] == [keys] * 1


def test_probability_is_conserved(task):
    arrivals = exact_hitting_times(random_table(task, 3)[:, 1], task, 1)
    np.testing.assert_allclose(arrivals.success, 1, atol=1e-4)
    assert arrivals.histogram.sum() == pytest.approx(arrivals.success.mean())
    assert (arrivals.steps >= arrivals.shortest - 1e-3).all()
    assert (arrivals.shortest * arrivals.inverse_steps <= 1 + 1e-5).all()


def test_scenes_are_put_together_with_equal_weights_per_target(task):
    other = toy_task(1, targets=3).task
    first, second = exact_evaluation(random_table(task), task), exact_evaluation(random_table(other), other)
    both = mean_evaluation([first, second])
    assert both.per_target == first.per_target + second.per_target
    assert both.overall.spl == pytest.approx(np.mean([result.spl for result in both.per_target]))
    with pytest.raises(SearchError, match="same protocol"):
        mean_evaluation([first, exact_evaluation(random_table(other), other, limit=10)])


def test_an_episode_follows_transitions_to_a_goal(task):
    table = random_table(task)
    start = int(task.starts(1)[3])
    episode = run_episode(table, task, 1, start, rng=3)
    assert episode.states[0] == start
    assert len(episode) == len(episode.actions) == len(episode.states) - 1
    np.testing.assert_array_equal(task.transitions[episode.states[:-1], episode.actions], episode.states[1:])
    assert episode.success
    assert task.goals[episode.states[-1], 1]
    assert not task.goals[episode.states[:-1], 1].any()
    assert not run_episode(table, task, 1, int(task.steps[:, 1].argmax()), limit=1).success
    assert len(run_episode(table, task, 1, int(episode.states[-1]))) == 0
    best = run_episode(shortest_table(task), task, 1, start)
    assert len(best) == task.steps[start, 1]


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda table: table[:, :1], "has shape"),
        (lambda table: table * 2, "sum to 1"),
        (lambda table: table * np.nan, "sum to 1"),
        (lambda table: table - 0.5, "sum to 1"),
    ],
)
def test_refuses_what_is_no_policy(task, change, message):
    table = change(random_table(task))
    for evaluate in (exact_evaluation, episode_evaluation, lambda some, of: run_episode(some, of, 0, 0)):
        with pytest.raises(SearchError, match=message):
            evaluate(table, task)


def test_refuses_numbers_out_of_range(task):
    table = random_table(task)
    with pytest.raises(SearchError, match="limit"):
        exact_evaluation(table, task, limit=0)
    with pytest.raises(SearchError, match="at least one episode"):
        episode_evaluation(table, task, episodes=0)
    with pytest.raises(SearchError, match="no target 2"):
        run_episode(table, task, 2, 0)
    with pytest.raises(SearchError, match="no picture 9"):
        policy_table(RandomPolicy({"a": ("x",)}), toy_task().observations, "a", picture=9)
