"""The network: the table equals the pairs one by one, features are normalised, files keep it."""

import numpy as np
import pytest
import torch

from active_perceiver.envs import Observations, SearchError
from active_perceiver.policies import Policy, policy_table
from active_perceiver.policies.config import MirrorDescentConfig
from active_perceiver.policies.export import export_policy, load_network, policy_model, save_network
from active_perceiver.policies.network import PolicyNetwork, picture_tensors, seeded_network, task_table
from active_perceiver.policies.training_task import TrainingTask
from active_perceiver.scenes import TURTLEBOT_ACTIONS
from helpers.problems import toy_task


@pytest.fixture(scope="module")
def training_tasks():
    """Two scenes with different numbers of actions."""
    return [toy_task(0), toy_task(1, side=2, actions=TURTLEBOT_ACTIONS)]


@pytest.fixture(scope="module")
def network(training_tasks):
    """Like a trained one: far from uniform."""
    network = seeded_network(training_tasks, MirrorDescentConfig(hidden=32))
    with torch.no_grad():
        for head in network.action_heads:
            head.weight *= 300
    return network


def test_layers_are_the_papers(training_tasks):
    network = PolicyNetwork.for_tasks(training_tasks)
    shapes = {name: tuple(parameter.shape) for name, parameter in network.named_parameters() if "weight" in name}
    assert shapes == {
        "view_layer.weight": (512, 48),
        "target_layer.weight": (512, 48),
        "fusion.weight": (512, 512 + 512 + 25),
        "branch_layers.0.weight": (512, 512),
        "branch_layers.1.weight": (512, 512),
        "action_heads.0.weight": (8, 512),
        "action_heads.1.weight": (6, 512),
        "value_heads.0.weight": (1, 512),
        "value_heads.1.weight": (1, 512),
    }


@pytest.mark.parametrize("number", [0, 1])
def test_the_table_equals_the_pairs_one_by_one(training_tasks, network, number):
    training_task, pictures = training_tasks[number], np.array([1, 0])
    probabilities, values = task_table(network, training_task, pictures)
    seen, branch = training_task.observations, training_task.task.scene
    for target, picture in enumerate(pictures):
        view = torch.from_numpy(seen.view_features)
        shown = torch.from_numpy(seen.target_features[target, picture]).expand_as(view)
        with torch.no_grad():
            log, value = network(view, shown, torch.from_numpy(seen.masks[:, target, picture]), branch)
        np.testing.assert_allclose(probabilities[:, target], log.exp(), atol=1e-5)
        np.testing.assert_allclose(values[:, target], value, atol=1e-5)
    np.testing.assert_allclose(probabilities.sum(-1), 1, atol=1e-5)


def test_the_tables_gradient_equals_that_of_the_pairs(training_tasks, network):
    training_task = training_tasks[0]
    views, targets, masks = picture_tensors(training_task, 0)
    weights = torch.from_numpy(np.random.default_rng(0).normal(size=(len(views), 2, 8)).astype(np.float32))

    def gradients(log):
        network.zero_grad()
        (weights * log.exp()).sum().backward()
        return {n: p.grad.clone() for n, p in network.named_parameters() if p.grad is not None and "value" not in n}

    table = gradients(network.table(views, targets, masks, training_task.task.scene)[0])
    pairs = [network(views, targets[t].expand_as(views), masks[:, t], training_task.task.scene)[0] for t in range(2)]
    for name, gradient in gradients(torch.stack(pairs, 1)).items():
        torch.testing.assert_close(table[name], gradient, rtol=1e-3, atol=1e-3)


def test_features_are_normalised_by_the_training_data(training_tasks, network):
    views = np.concatenate([training_task.observations.view_features for training_task in training_tasks])
    normal = (views - network.view_mean.numpy()) / network.view_scale.numpy()
    np.testing.assert_allclose(normal.mean(0), 0, atol=1e-4)
    assert 0.5 < normal.std() < 1


def test_one_view_or_one_picture_alone_gives_no_division_by_zero():
    training_task = toy_task(targets=1, pictures=1)
    seen = training_task.observations
    constant = Observations(np.ones_like(seen.view_features), seen.target_features, seen.masks)
    probabilities, values = task_table(
        PolicyNetwork.for_tasks([TrainingTask(training_task.task, constant)], 16),
        TrainingTask(training_task.task, constant),
    )
    assert np.isfinite(probabilities).all()
    assert np.isfinite(values).all()


def test_the_seed_decides_the_weights_and_torchs_own_stream_goes_on(training_tasks):
    before = torch.random.get_rng_state()
    first, second, other = (
        seeded_network(training_tasks, MirrorDescentConfig(hidden=8, seed=seed)) for seed in (1, 1, 2)
    )
    assert torch.equal(before, torch.random.get_rng_state())
    assert torch.equal(first.fusion.weight, second.fusion.weight)
    assert not torch.equal(first.fusion.weight, other.fusion.weight)


def test_onnx_decides_like_the_network(training_tasks, network, tmp_path):
    export_policy(network, tmp_path / "policy.onnx")
    policy = Policy(tmp_path / "policy.onnx")
    assert policy.branches == network.branches
    assert policy.feature_dim == network.feature_dim
    for training_task in training_tasks:
        for picture in range(2):
            table = policy_table(policy, training_task.observations, training_task.task.scene, picture)
            np.testing.assert_allclose(table, task_table(network, training_task, picture)[0], atol=2e-5)
    with pytest.raises(FileExistsError):
        export_policy(network, tmp_path / "policy.onnx")
    export_policy(network, tmp_path / "policy.onnx", force=True)
    assert [path.name for path in tmp_path.iterdir()] == ["policy.onnx"]


def test_a_network_of_nan_is_not_exported(training_tasks, tmp_path):
    broken = PolicyNetwork.for_tasks(training_tasks, 8)
    with torch.no_grad():
        broken.fusion.weight.fill_(float("nan"))
    with pytest.raises(SearchError, match="by nan"):
        export_policy(broken, tmp_path / "policy.onnx")
    assert not list(tmp_path.iterdir())


def test_weights_survive_a_file(training_tasks, network, tmp_path):
    save_network(network, tmp_path / "model.safetensors")
    loaded = load_network(tmp_path / "model.safetensors")
    assert loaded.branches == network.branches
    for training_task in training_tasks:
        for before, after in zip(task_table(network, training_task), task_table(loaded, training_task), strict=True):
            np.testing.assert_array_equal(before, after)


def test_refuses_files_that_are_no_policy(network, tmp_path):
    path = tmp_path / "file"
    with pytest.raises(SearchError, match="no policy network"):
        load_network(path)
    with pytest.raises(SearchError, match="cannot be read"):
        Policy(path)
    path.write_bytes(b"nonsense")
    with pytest.raises(SearchError, match="not a readable safetensors"):
        load_network(path)
    with pytest.raises(SearchError, match="not a readable ONNX"):
        Policy(path)
    foreign = policy_model(network)
    del foreign.metadata_props[:]
    with pytest.raises(SearchError, match="not a policy of this software"):
        Policy(foreign.SerializeToString())


def test_refuses_observations_of_another_shape(training_tasks, network):
    policy = Policy(policy_model(network).SerializeToString())
    view, mask = np.zeros((1, 48), np.float32), np.zeros((1, 25), np.float32)
    assert policy.probabilities(view, view, mask, "toy_1").shape == (1, 6)
    with pytest.raises(SearchError, match="no branch for scene 'attic'; it was trained in toy_0, toy_1"):
        policy.probabilities(view, view, mask, "attic")
    with pytest.raises(SearchError, match="was another backbone used"):
        policy.probabilities(view[:, 1:], view, mask, "toy_0")
    with pytest.raises(SearchError, match=r"mask has shape \(1, 24\)"):
        policy.probabilities(view, view, mask[:, 1:], "toy_0")
    with pytest.raises(SearchError, match="no branch 'attic'"):
        network.branch_number("attic")


def test_refuses_problems_that_do_not_go_together(training_tasks):
    with pytest.raises(SearchError, match="at least one scene"):
        PolicyNetwork.for_tasks([])
    with pytest.raises(SearchError, match="given twice"):
        PolicyNetwork.for_tasks([training_tasks[0], training_tasks[0]])
    with pytest.raises(SearchError, match="one backbone"):
        PolicyNetwork.for_tasks([training_tasks[0], toy_task(1, width=12)])
    with pytest.raises(SearchError, match="hidden"):
        PolicyNetwork(4, {"a": ("x",)}, hidden=0)
    with pytest.raises(SearchError, match="do not fit"):
        TrainingTask(training_tasks[0].task, training_tasks[1].observations)
