"""The network: the table equals the pairs one by one, features are normalised, files keep it."""

import numpy as np
import pytest
import torch
from problems import toy_problem

from active_perceiver.policies import Policy, policy_table
from active_perceiver.policies.config import MirrorDescentConfig
from active_perceiver.policies.export import export_policy, load_network, policy_model, save_network
from active_perceiver.policies.network import PolicyNetwork, picture_tensors, problem_table, seeded_network
from active_perceiver.policies.problem import Problem
from active_perceiver.scenes import TURTLEBOT_ACTIONS
from active_perceiver.search import Observations, SearchError


@pytest.fixture(scope="module")
def problems():
    """Two scenes with different numbers of actions."""
    return [toy_problem(0), toy_problem(1, side=2, actions=TURTLEBOT_ACTIONS)]


@pytest.fixture(scope="module")
def network(problems):
    """Like a trained one: far from uniform."""
    network = seeded_network(problems, MirrorDescentConfig(hidden=32))
    with torch.no_grad():
        for head in network.action_heads:
            head.weight *= 300
    return network


def test_layers_are_the_papers(problems):
    network = PolicyNetwork.for_problems(problems)
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
def test_the_table_equals_the_pairs_one_by_one(problems, network, number):
    problem, pictures = problems[number], np.array([1, 0])
    probabilities, values = problem_table(network, problem, pictures)
    seen, branch = problem.observations, problem.task.scene
    for target, picture in enumerate(pictures):
        view = torch.from_numpy(seen.view_features)
        shown = torch.from_numpy(seen.target_features[target, picture]).expand_as(view)
        with torch.no_grad():
            log, value = network(view, shown, torch.from_numpy(seen.masks[:, target, picture]), branch)
        np.testing.assert_allclose(probabilities[:, target], log.exp(), atol=1e-5)
        np.testing.assert_allclose(values[:, target], value, atol=1e-5)
    np.testing.assert_allclose(probabilities.sum(-1), 1, atol=1e-5)


def test_the_tables_gradient_equals_that_of_the_pairs(problems, network):
    problem = problems[0]
    views, targets, masks = picture_tensors(problem, 0)
    weights = torch.from_numpy(np.random.default_rng(0).normal(size=(len(views), 2, 8)).astype(np.float32))

    def gradients(log):
        network.zero_grad()
        (weights * log.exp()).sum().backward()
        return {n: p.grad.clone() for n, p in network.named_parameters() if p.grad is not None and "value" not in n}

    table = gradients(network.table(views, targets, masks, problem.task.scene)[0])
    pairs = [network(views, targets[t].expand_as(views), masks[:, t], problem.task.scene)[0] for t in range(2)]
    for name, gradient in gradients(torch.stack(pairs, 1)).items():
        torch.testing.assert_close(table[name], gradient, rtol=1e-3, atol=1e-3)


def test_features_are_normalised_by_the_training_data(problems, network):
    views = np.concatenate([problem.observations.view_features for problem in problems])
    normal = (views - network.view_mean.numpy()) / network.view_scale.numpy()
    np.testing.assert_allclose(normal.mean(0), 0, atol=1e-4)
    assert 0.5 < normal.std() < 1


def test_one_view_or_one_picture_alone_gives_no_division_by_zero():
    problem = toy_problem(targets=1, pictures=1)
    seen = problem.observations
    constant = Observations(np.ones_like(seen.view_features), seen.target_features, seen.masks)
    probabilities, values = problem_table(
        PolicyNetwork.for_problems([Problem(problem.task, constant)], 16), Problem(problem.task, constant)
    )
    assert np.isfinite(probabilities).all()
    assert np.isfinite(values).all()


def test_the_seed_decides_the_weights_and_torchs_own_stream_goes_on(problems):
    before = torch.random.get_rng_state()
    first, second, other = (seeded_network(problems, MirrorDescentConfig(hidden=8, seed=seed)) for seed in (1, 1, 2))
    assert torch.equal(before, torch.random.get_rng_state())
    assert torch.equal(first.fusion.weight, second.fusion.weight)
    assert not torch.equal(first.fusion.weight, other.fusion.weight)


def test_onnx_decides_like_the_network(problems, network, tmp_path):
    export_policy(network, tmp_path / "policy.onnx")
    policy = Policy(tmp_path / "policy.onnx")
    assert policy.branches == network.branches
    assert policy.feature_dim == network.feature_dim
    for problem in problems:
        for picture in range(2):
            table = policy_table(policy, problem.observations, problem.task.scene, picture)
            np.testing.assert_allclose(table, problem_table(network, problem, picture)[0], atol=2e-5)
    with pytest.raises(FileExistsError):
        export_policy(network, tmp_path / "policy.onnx")
    export_policy(network, tmp_path / "policy.onnx", force=True)
    assert [path.name for path in tmp_path.iterdir()] == ["policy.onnx"]


def test_a_network_of_nan_is_not_exported(problems, tmp_path):
    broken = PolicyNetwork.for_problems(problems, 8)
    with torch.no_grad():
        broken.fusion.weight.fill_(float("nan"))
    with pytest.raises(SearchError, match="by nan"):
        export_policy(broken, tmp_path / "policy.onnx")
    assert not list(tmp_path.iterdir())


def test_weights_survive_a_file(problems, network, tmp_path):
    save_network(network, tmp_path / "model.safetensors")
    loaded = load_network(tmp_path / "model.safetensors")
    assert loaded.branches == network.branches
    for problem in problems:
        for before, after in zip(problem_table(network, problem), problem_table(loaded, problem), strict=True):
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


def test_refuses_observations_of_another_shape(problems, network):
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


def test_refuses_problems_that_do_not_go_together(problems):
    with pytest.raises(SearchError, match="at least one scene"):
        PolicyNetwork.for_problems([])
    with pytest.raises(SearchError, match="given twice"):
        PolicyNetwork.for_problems([problems[0], problems[0]])
    with pytest.raises(SearchError, match="one backbone"):
        PolicyNetwork.for_problems([problems[0], toy_problem(1, width=12)])
    with pytest.raises(SearchError, match="hidden"):
        PolicyNetwork(4, {"a": ("x",)}, hidden=0)
    with pytest.raises(SearchError, match="do not fit"):
        Problem(problems[0].task, problems[1].observations)
