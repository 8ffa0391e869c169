"""Distillation: which actions are optimal, the loss against a plain loop, and what it cannot be told."""

from dataclasses import replace

import networkx
import numpy as np
import pytest
import torch

from active_perceiver.envs import SearchError
from active_perceiver.errors import UserError
from active_perceiver.policies.config import DistilConfig, PpoConfig
from active_perceiver.policies.distil import distillation_loss, optimal_actions
from active_perceiver.policies.fitting import state_batches
from active_perceiver.policies.learners import LEARNERS
from active_perceiver.policies.network import picture_tensors
from active_perceiver.scenes.lattice import steps_to_goal
from active_perceiver.training.config import TrainConfig
from active_perceiver.training.policy_stage import learner_config
from helpers.problems import toy_task


@pytest.fixture(scope="module")
def training_task():
    return toy_task()


@pytest.fixture(scope="module")
def broken_task(training_task):
    """The toy search, with states from which there is no way to any goal."""
    task = training_task.task
    lost = np.flatnonzero(~task.goals.any(axis=1))[::7]
    transitions = task.transitions.copy()
    transitions[lost] = lost[:, None]
    steps = np.stack([steps_to_goal(transitions, goals) for goals in task.goals.T], axis=1)
    assert (steps < 0).any()
    return replace(task, transitions=transitions, steps=steps)


def test_optimal_actions_are_the_first_of_networkx_shortest_paths(broken_task):
    task = broken_task
    graph = networkx.DiGraph()
    graph.add_nodes_from(range(len(task)))
    graph.add_edges_from((state, int(after)) for state, row in enumerate(task.transitions) for after in row)
    expected = np.zeros((*task.goals.shape, len(task.actions)), bool)
    for target in range(len(task.targets)):
        goals = set(np.flatnonzero(task.goals[:, target]).tolist())
        length = networkx.multi_source_dijkstra_path_length(graph.reverse(), goals)
        for state, row in enumerate(task.transitions):
            if state not in goals and state in length:
                expected[state, target] = [length.get(int(after)) == length[state] - 1 for after in row]
    found = optimal_actions(task, np.arange(len(task)))
    np.testing.assert_array_equal(found, expected)
    np.testing.assert_array_equal(found.any(axis=-1), task.steps > 0)
    assert (found.sum(axis=-1) > 1).any(), "there should be ties"
    some = np.array([5, 2, 5])
    np.testing.assert_array_equal(optimal_actions(task, some), expected[some])


def test_loss_and_gradient_equal_those_of_a_plain_loop(broken_task):
    optimal = optimal_actions(broken_task, np.arange(60))
    logits = torch.from_numpy(np.random.default_rng(0).normal(size=optimal.shape)).requires_grad_()
    loss = distillation_loss(torch.log_softmax(logits, -1), torch.from_numpy(optimal))
    loss.backward()
    policy = torch.softmax(logits.detach(), -1).numpy()
    losses, gradient = [], np.zeros_like(policy)
    for pair in np.ndindex(optimal.shape[:2]):
        if optimal[pair].any():
            hit = policy[pair][optimal[pair]].sum()
            losses.append(-np.log(hit))
            gradient[pair] = policy[pair] - np.where(optimal[pair], policy[pair] / hit, 0)
    assert 0 < len(losses) < optimal[..., 0].size
    assert loss.item() == pytest.approx(np.mean(losses))
    np.testing.assert_allclose(logits.grad.numpy(), gradient / len(losses), atol=1e-12)


def test_a_batch_where_no_search_goes_on_teaches_nothing():
    logits = torch.zeros(3, 2, 8, requires_grad=True)
    loss = distillation_loss(torch.log_softmax(logits, -1), torch.zeros(3, 2, 8, dtype=torch.bool))
    loss.backward()
    assert loss.item() == 0
    assert not logits.grad.any()


@pytest.mark.parametrize(("states", "size"), [(10, 4), (3, 3)])
def test_batches_go_through_all_states_evenly(states, size):
    config = DistilConfig(fit_steps=7, batch_states=4)
    batches = [batch.numpy() for batch in state_batches(states, config, np.random.default_rng(0))]
    assert [len(batch) for batch in batches] == [size] * 7
    order = np.concatenate(batches)
    for start in range(0, len(order) - states + 1, states):
        assert sorted(order[start : start + states]) == list(range(states))


def test_the_policy_is_the_running_mean_of_the_weights(training_task):
    def weights(steps, averaging):
        config = DistilConfig(hidden=8, iterations=1, fit_steps=steps, batch_states=16, averaging=averaging)
        return torch.cat(
            [part.detach().ravel() for part in LEARNERS["distil"].train([training_task], config)[0].parameters()]
        )

    first, second, third = (weights(steps, 0.0) for steps in (1, 2, 3))
    assert not torch.allclose(first, third, atol=1e-4)
    # Of the mean so far, the second step keeps 2/11 and the third 3/12, unless that is more than asked for.
    expected = 3 / 12 * (2 / 11 * first + 9 / 11 * second) + 9 / 12 * third
    torch.testing.assert_close(weights(3, 0.6), expected, rtol=0, atol=1e-6)
    torch.testing.assert_close(
        weights(3, 0.2), 0.2 * (2 / 11 * first + 9 / 11 * second) + 0.8 * third, rtol=0, atol=1e-6
    )


def test_signals_neither_fade_nor_grow_in_the_network_that_training_begins_with(training_task):
    config = DistilConfig(iterations=1, fit_steps=1, learning_rate=1e-12)
    network, _ = LEARNERS["distil"].train([training_task], config)
    views, _, _ = picture_tensors(training_task, 0)
    with torch.no_grad():
        normal = (views - network.view_mean) / network.view_scale
        first = torch.relu(network.view_layer(normal))
        second = torch.relu(network.fusion(torch.cat([first, first, torch.zeros(len(first), 25)], dim=1)))
        third = torch.relu(network.branch_layers[0](second))
    sizes = [part.square().mean().sqrt().item() for part in (first, second, third)]
    assert max(sizes) / min(sizes) < 3


def test_refuses_what_it_has_no_use_for(training_task):
    for fields in ({"reward": "goal"}, {"gamma": 0.9}):
        with pytest.raises(TypeError, match=next(iter(fields))):
            DistilConfig(**fields)
    with pytest.raises(SearchError, match="needs a DistilConfig, got a PpoConfig"):
        LEARNERS["distil"].train([training_task], PpoConfig())
    with pytest.raises(SearchError, match="at least one scene"):
        LEARNERS["distil"].train([], DistilConfig())


@pytest.mark.parametrize(("setting", "value"), [("reward", "goal"), ("entropy_weight", 0.1)])
def test_the_command_says_that_it_has_no_reward(setting, value):
    settings = TrainConfig(learner="distil")
    with pytest.raises(UserError, match=f"the learner distil has no {setting}; leave it out"):
        learner_config(replace(settings, **{setting: value}))
    for task in ("object", "view"):
        assert learner_config(replace(settings, task=task, seed=3)) == DistilConfig(seed=3)
