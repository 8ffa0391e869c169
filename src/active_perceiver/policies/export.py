"""Writing a trained network: `policy.onnx` for running without torch, safetensors for training on."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import onnx
import torch
from numpy.typing import NDArray
from onnx import TensorProto, helper, numpy_helper
from safetensors import SafetensorError, safe_open
from safetensors.torch import save_file
from torch import nn

from active_perceiver.errors import SearchError
from active_perceiver.policies.network import PolicyNetwork
from active_perceiver.policies.policy import KIND, Policy
from active_perceiver.scenes.storage import replacing
from active_perceiver.vision.location import GRID

OPSET = 17
TOLERANCE = 1e-4
"""Largest difference of a probability between torch and ONNX Runtime that is rounding."""


def export_policy(network: PolicyNetwork, path: Path | str, *, force: bool = False) -> None:
    """Write a network as an ONNX model that `Policy` runs; checked against the network before it is kept.

    Args:
        network: what to write.
        path: the file, written atomically.
        force: replace an existing file.

    Raises:
        FileExistsError: if the file exists and `force` is false.
        SearchError: if ONNX Runtime decides otherwise than the network, or the network holds NaN.
    """
    model = policy_model(network)
    data = model.SerializeToString()
    _check(network, Policy(data))
    with replacing(Path(path), force) as temporary:
        temporary.write_bytes(data)


def policy_model(network: PolicyNetwork) -> onnx.ModelProto:
    """The network as an ONNX model with one output of probabilities per branch; values are left out."""
    graph = _GraphBuilder()
    embedded = []
    for label, layer in (("view", network.view_layer), ("target", network.target_layer)):
        mean, scale = (getattr(network, f"{label}_{part}").double().numpy() for part in ("mean", "scale"))
        # (x - mean) / scale is linear, so it is folded into the layer's weights.
        weight = layer.weight.detach().double().numpy() / scale
        bias = layer.bias.detach().double().numpy() - weight @ mean
        embedded.append(graph.add("Relu", graph.linear(label, weight, bias)))
    fused = graph.add("Relu", graph.layer(graph.add("Concat", *embedded, "mask", axis=1), network.fusion))
    for number, (branch, head) in enumerate(zip(network.branch_layers, network.action_heads, strict=True)):
        hidden = graph.add("Relu", graph.layer(fused, branch))
        graph.add("Softmax", graph.layer(hidden, head), output=f"probabilities_{number}", axis=1)
    inputs = {"view": network.feature_dim, "target": network.feature_dim, "mask": GRID * GRID}
    outputs = {f"probabilities_{number}": len(names) for number, names in enumerate(network.branches.values())}
    model = helper.make_model(
        helper.make_graph(
            graph.nodes,
            "policy",
            [helper.make_tensor_value_info(name, TensorProto.FLOAT, ["N", width]) for name, width in inputs.items()],
            [helper.make_tensor_value_info(name, TensorProto.FLOAT, ["N", width]) for name, width in outputs.items()],
            graph.constants,
        ),
        opset_imports=[helper.make_opsetid("", OPSET)],
        ir_version=8,  # of opset 17; onnx would write its newest, which older ONNX Runtimes refuse
        producer_name="active-perceiver",
    )
    helper.set_model_props(model, {"kind": KIND, "branches": json.dumps(network.branches)})
    onnx.checker.check_model(model)
    return model


def save_network(network: PolicyNetwork, path: Path | str, *, force: bool = False) -> None:
    """Write a network's weights and branches as safetensors, atomically.

    Raises:
        FileExistsError: if the file exists and `force` is false.
    """
    metadata = {"kind": KIND, "branches": json.dumps(network.branches)}
    with replacing(Path(path), force) as temporary:
        save_file(network.state_dict(), temporary, metadata)


def load_network(path: Path | str) -> PolicyNetwork:
    """Read what `save_network` wrote.

    Raises:
        SearchError: if the file is missing, damaged or not a policy network.
    """
    path = Path(path)
    if not path.is_file():
        raise SearchError(f"there is no policy network {path}; train one with `active-perceiver train`")
    try:
        with safe_open(path, "pt") as file:
            metadata = file.metadata() or {}
            weights = {name: file.get_tensor(name) for name in file.keys()}  # noqa: SIM118 (no mapping)
    except (SafetensorError, OSError) as error:
        raise SearchError(f"{path} is not a readable safetensors file: {error}") from None
    if metadata.get("kind") != KIND:
        raise SearchError(f"{path} holds weights, but not of a policy network")
    hidden, feature_dim = weights["view_layer.weight"].shape
    network = PolicyNetwork(feature_dim, json.loads(metadata["branches"]), hidden)
    network.load_state_dict(weights)
    return network


class _GraphBuilder:
    """Collects the nodes and constants of an ONNX graph; values get numbers for names."""

    def __init__(self) -> None:
        self.nodes: list[onnx.NodeProto] = []
        self.constants: list[onnx.TensorProto] = []

    def add(self, kind: str, *inputs: str, output: str | None = None, **attributes: Any) -> str:
        output = output or f"value_{len(self.nodes)}"
        self.nodes.append(helper.make_node(kind, inputs, [output], **attributes))
        return output

    def linear(self, value: str, weight: NDArray[np.floating], bias: NDArray[np.floating]) -> str:
        return self.add("Gemm", value, self._constant(weight), self._constant(bias), transB=1)

    def layer(self, value: str, layer: nn.Module) -> str:
        parameters = layer.state_dict()
        return self.linear(value, parameters["weight"].numpy(), parameters["bias"].numpy())

    def _constant(self, array: NDArray[np.floating]) -> str:
        name = f"constant_{len(self.constants)}"
        self.constants.append(numpy_helper.from_array(np.ascontiguousarray(array, np.float32), name))
        return name


def _check(network: PolicyNetwork, policy: Policy) -> None:
    rng = np.random.default_rng(0)
    rows = 16
    view, target = (
        (getattr(network, f"{label}_mean") + getattr(network, f"{label}_scale") * _normal(rng, rows, network))
        for label in ("view", "target")
    )
    mask = torch.from_numpy((rng.random((rows, GRID * GRID)) < 0.2).astype(np.float32))
    for branch in network.branches:
        with torch.no_grad():
            expected = network(view, target, mask, branch)[0].exp().numpy()
        decided = policy.probabilities(view.numpy(), target.numpy(), mask.numpy(), branch)
        difference = np.abs(decided - expected).max()
        if not difference <= TOLERANCE:
            raise SearchError(
                f"the exported policy differs from the network by {difference:.1e} in branch '{branch}'"
            )


def _normal(rng: np.random.Generator, rows: int, network: PolicyNetwork) -> torch.Tensor:
    return torch.from_numpy(rng.standard_normal((rows, network.feature_dim), dtype=np.float32))
