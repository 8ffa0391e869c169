"""The learners: exact advantages, PPO's gradient and estimates against slow ones, and that they learn."""

import itertools
import subprocess
import sys
from dataclasses import replace

import numpy as np
import pytest
import torch

from active_perceiver.envs import REWARDS, SearchEnv, SearchError
from active_perceiver.policies.advantages import exact_advantages
from active_perceiver.policies.config import DistilConfig, MirrorDescentConfig, PpoConfig
from active_perceiver.policies.evaluation import exact_evaluation
from active_perceiver.policies.learners import LEARNERS, learner_named
from active_perceiver.policies.network import picture_tensors, seeded_network, task_table
from active_perceiver.policies.ppo import PairSums, SceneSamples
from active_perceiver.policies.rollouts import Rollout, RolloutWorker, estimate_advantages
from helpers.problems import random_table, toy_task

SMALL = {"hidden": 64, "target_ratio": 1.05}
CONFIGS = {
    "mirror-descent": MirrorDescentConfig(**SMALL),
    "distil": DistilConfig(**SMALL),
    "ppo": PpoConfig(**SMALL, num_envs=256, check_every=2),
}


@pytest.fixture(scope="module")
def training_task():
    return toy_task()


@pytest.mark.parametrize("name", [name for name, reward in REWARDS.items() if reward.markov])
def test_exact_advantages_equal_many_sweeps_of_value_iteration(training_task, name):
    task, gamma, reward = training_task.task, 0.9, REWARDS[name]
    table = random_table(task).astype(np.float64)
    table /= table.sum(-1, keepdims=True)
    advantages = exact_advantages(table, task, reward, gamma)
    for target in range(len(task.targets)):
        after = task.transitions
        earned = reward.function(task.areas[after, target], 0, task.goals[after, target], 1) / reward.largest(task)
        values = np.zeros(len(task))
        for _ in range(300):
            action_values = earned + gamma * np.where(task.goals[after, target], 0, values[after])
            values = (table[:, target] * action_values).sum(-1)
        searching = ~task.goals[:, target]
        expected = (action_values - values[:, None])[searching]
        np.testing.assert_allclose(advantages[searching, target], expected, atol=1e-8)


def test_rollouts_and_estimates_equal_a_plain_loop(training_task):
    """Generalised advantages episode by episode, by their definition as a sum."""
    task, gamma, decay = training_task.task, 0.9, 0.8
    rng = np.random.default_rng(0)
    worker = RolloutWorker(task, 6, REWARDS["gain"], 12, rng)
    worker.run(random_table(task), 5)  # goes on where it stopped
    rollout = worker.run(random_table(task), 40)
    values = rng.normal(size=task.goals.shape)
    advantages, returns = estimate_advantages(rollout, values, gamma, decay)
    unit = REWARDS["gain"].largest(task)
    assert rollout.terminated.any()
    assert (rollout.done & ~rollout.terminated).any()
    for search in range(6):
        ends = [*np.flatnonzero(rollout.done[:, search]), 39]
        for step in range(40):
            end = next(end for end in ends if end >= step)
            expected = 0.0
            for later in range(step, end + 1):
                state, target = rollout.states[later, search], rollout.targets[later, search]
                next_states = rollout.next_states[later, search]
                assert next_states == task.transitions[state, rollout.actions[later, search]]
                assert rollout.terminated[later, search] == task.goals[next_states, target]
                if later < end:
                    assert rollout.states[later + 1, search] == next_states
                after = 0 if rollout.terminated[later, search] else values[next_states, target]
                td_error = rollout.rewards[later, search] + gamma * after - values[state, target]
                expected += (gamma * decay) ** (later - step) * td_error
            assert advantages[step, search] == pytest.approx(expected)
            value = values[rollout.states[step, search], rollout.targets[step, search]]
            assert returns[step, search] == pytest.approx(expected + value)
    env = SearchEnv(task=task, observations=training_task.observations, reward="gain", max_steps=12)
    first = int(np.flatnonzero(rollout.done[:, 0])[0]) + 1
    env.reset(options={"start": int(rollout.states[first, 0]), "target": int(rollout.targets[first, 0])})
    for step in range(first, 40):
        _, reward, terminated, truncated, _ = env.step(int(rollout.actions[step, 0]))
        assert rollout.rewards[step, 0] * unit == pytest.approx(reward, abs=1e-6)
        assert rollout.done[step, 0] == (terminated or truncated)
        if terminated or truncated:
            break


@pytest.mark.parametrize("entropy_weight", [0.0, 0.05])
def test_ppos_gradient_equals_that_of_the_samples(training_task, entropy_weight):
    config = PpoConfig(hidden=16)
    task, rng = training_task.task, np.random.default_rng(0)
    network = seeded_network([training_task], config)
    views, targets, masks = picture_tensors(training_task, 0)
    with torch.no_grad():
        before, _ = network.table(views, targets, masks, task.scene)
        for parameter in network.parameters():  # so that some ratios are clipped
            parameter += 0.2 * torch.from_numpy(rng.normal(size=parameter.shape).astype(np.float32))
    rollout = RolloutWorker(task, 64, REWARDS["gain"], 30, rng).run(before.exp().numpy(), 20)
    advantages, returns = rng.normal(size=(2, 20, 64)).astype(np.float32)

    def gradients(loss):
        network.zero_grad()
        loss.backward()
        return {name: parameter.grad.clone() for name, parameter in network.named_parameters()}

    sums = PairSums.of(before.shape, rollout, advantages, returns)
    scene = SceneSamples(task.scene, views, targets, masks, before, sums)
    summed = gradients(scene.loss(network, torch.arange(len(task)), config, entropy_weight))

    state, target, action = (
        torch.from_numpy(array.ravel()) for array in (rollout.states, rollout.targets, rollout.actions)
    )
    log, value = network(views[state], targets[target], masks[state, target], task.scene)
    ratio = (log.gather(1, action[:, None])[:, 0] - before[state, target, action]).exp()
    advantage, wanted = torch.from_numpy(advantages.ravel()), torch.from_numpy(returns.ravel())
    clipped = ratio.clamp(1 - config.clip, 1 + config.clip)
    assert 0.05 < (clipped != ratio).float().mean() < 0.95
    surrogate = torch.minimum(ratio * advantage, clipped * advantage).mean()
    squared = ((value - wanted) ** 2).mean()
    entropy = -(log.exp() * log).sum(-1).mean()
    sampled = gradients(-surrogate + config.value_coef * squared - entropy_weight * entropy)
    for name, gradient in sampled.items():
        torch.testing.assert_close(summed[name], gradient, rtol=1e-3, atol=1e-5)


@pytest.mark.parametrize("name", CONFIGS)
def test_finds_every_target_with_every_picture(name, training_task):
    robot_moved = []
    network, history = LEARNERS[name].train(
        [training_task], CONFIGS[name], inspect=lambda record, tables: robot_moved.append(record)
    )
    for picture in range(training_task.observations.pictures):
        overall = exact_evaluation(task_table(network, training_task, picture)[0], training_task.task).overall
        assert overall.success == pytest.approx(1)
        assert overall.ratio <= 1.05
    assert robot_moved == history
    last = history[-1]
    fields = {"iteration", "seconds", "measuring", "samples", "success", "mean_steps", "ratio", "entropy"}
    assert set(last) == fields
    measured = [0.0, *(record["measuring"] for record in history)]
    assert all(before < after for before, after in itertools.pairwise(measured))
    # All but the measurements is training, which takes time too.
    trained = [0.0, *(record["seconds"] - record["measuring"] for record in history)]
    assert all(before < after for before, after in itertools.pairwise(trained))
    assert last["success"] == pytest.approx(1)
    assert last["ratio"] <= 1.05
    assert history[0]["entropy"] > last["entropy"]
    assert last["iteration"] < CONFIGS[name].iterations, "it should have stopped early"


@pytest.mark.parametrize("name", CONFIGS)
def test_learns_several_scenes_at_once_and_the_same_for_the_same_seed(name, training_task):
    training_tasks = [training_task, toy_task(1, side=2, targets=1)]
    config = replace(CONFIGS[name], iterations=2, target_ratio=None)
    tables = []
    for seed in (3, 3, 4):
        network, history = LEARNERS[name].train(training_tasks, replace(config, seed=seed))
        assert [record["iteration"] for record in history][-1] == 2
        tables.append([task_table(network, some)[0] for some in training_tasks])
    for first, second, other in zip(*tables, strict=True):
        np.testing.assert_array_equal(first, second)
        assert not np.array_equal(first, other)
    walk = [
        exact_evaluation(np.full_like(table, 1 / 8), some.task)
        for table, some in zip(tables[0], training_tasks, strict=True)
    ]
    for table, some, random in zip(tables[0], training_tasks, walk, strict=True):
        assert exact_evaluation(table, some.task).overall.mean_steps < random.overall.mean_steps


@pytest.mark.parametrize("reward", REWARDS)
def test_ppo_takes_every_reward(reward, training_task):
    config = PpoConfig(reward=reward, iterations=1, num_envs=16, num_steps=8, hidden=8)
    assert len(LEARNERS["ppo"].train([training_task], config)[1]) == 1


@pytest.mark.parametrize("name", CONFIGS)
def test_stops_when_time_is_up_and_gives_threads_and_precision_back(name, training_task):
    threads, precision = torch.get_num_threads(), torch.get_float32_matmul_precision()
    _, history = LEARNERS[name].train([training_task], replace(CONFIGS[name], seconds=0.0, threads=threads + 1))
    assert len(history) == 1
    assert (torch.get_num_threads(), torch.get_float32_matmul_precision()) == (threads, precision)


def test_stops_when_it_gets_no_better(training_task):
    config = replace(CONFIGS["mirror-descent"], target_ratio=0.5, patience=2)
    _, history = LEARNERS["mirror-descent"].train([training_task], config)
    ratios = [record["ratio"] for record in history]
    assert len(ratios) < config.iterations
    assert min(ratios[-2:]) > min(ratios[:-2]) * 0.998


def test_says_which_learner_takes_a_reward_that_depends_on_the_past():
    with pytest.raises(SearchError, match="use the learner ppo with it, or one of the rewards arrival, goal, area"):
        MirrorDescentConfig(reward="record")


@pytest.mark.parametrize(
    ("kind", "fields", "message"),
    [
        (MirrorDescentConfig, {"iterations": 0}, "iterations must be at least 1"),
        (MirrorDescentConfig, {"fit_steps": 0}, "fit_steps must be at least 1"),
        (MirrorDescentConfig, {"step_size": -1.0}, "step size"),
        (MirrorDescentConfig, {"patience": 0}, "patience must be"),
        (MirrorDescentConfig, {"gamma": 1.0}, "gamma"),
        (MirrorDescentConfig, {"learning_rate": 0.0}, "learning rate"),
        (MirrorDescentConfig, {"reward": "fun"}, "no reward 'fun'"),
        (DistilConfig, {"iterations": 0}, "iterations must be at least 1"),
        (DistilConfig, {"batch_states": 0}, "batch_states must be at least 1"),
        (DistilConfig, {"learning_rate": -1.0}, "learning rate"),
        (DistilConfig, {"averaging": 1.0}, "averaging must be"),
        (PpoConfig, {"gamma": -0.1}, "gamma"),
        (PpoConfig, {"epochs": 0}, "epochs must be at least 1"),
        (PpoConfig, {"gae_lambda": 1.5}, "gae_lambda"),
    ],
)
def test_refuses_settings_out_of_range(kind, fields, message):
    with pytest.raises(SearchError, match=message):
        kind(**fields)


def test_refuses_unknown_learners_and_settings_of_another(training_task):
    with pytest.raises(SearchError, match="no learner 'sarsa'; choose one of mirror-descent, distil, ppo, a3c"):
        learner_named("sarsa")
    with pytest.raises(SearchError, match="needs a PpoConfig, got a MirrorDescentConfig"):
        LEARNERS["ppo"].train([training_task], MirrorDescentConfig())


def test_running_a_policy_does_not_import_torch():
    code = "import sys, active_perceiver.policies, active_perceiver.envs; sys.exit('torch' in sys.modules)"
    subprocess.run([sys.executable, "-c", code], check=True, timeout=60)


def test_rollout_fields_are_all_alike(training_task):
    rollout = RolloutWorker(training_task.task, 3, REWARDS["area"], 5, np.random.default_rng(0)).run(
        random_table(training_task.task), 7
    )
    assert isinstance(rollout, Rollout)
    assert {array.shape for array in rollout} == {(7, 3)}
