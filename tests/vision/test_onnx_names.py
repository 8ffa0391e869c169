"""The same network is the same file, whatever its code is called and wherever it stands."""

from __future__ import annotations

import numpy as np
import onnx
import onnxruntime
import pytest
from onnx import TensorProto, helper, numpy_helper

from active_perceiver.vision.onnx_names import anonymise


def model(names: dict[str, str], doc: str = "", order: int = 1) -> onnx.ModelProto:
    """relu(x @ w + b) @ w, with a weight that nothing uses."""
    w, b, hidden, sums = (names.get(name, name) for name in ("w", "b", "hidden", "sums"))
    nodes = [
        helper.make_node("MatMul", ["x", w], [hidden], name=doc, doc_string=doc),
        helper.make_node("Add", [hidden, b], [sums], doc_string=doc),
        helper.make_node("Relu", [sums], ["r"]),
        helper.make_node("Clip", ["r", "", b], ["clipped"]),  # its second input is not given
        helper.make_node("MatMul", ["clipped", w], ["y"]),
    ]
    weights = [
        numpy_helper.from_array(np.arange(9, dtype=np.float32).reshape(3, 3) - 4, w),
        numpy_helper.from_array(np.array(2.5, np.float32), b),
        numpy_helper.from_array(np.zeros(1, np.float32), "unused"),
    ]
    ends = [helper.make_tensor_value_info(name, TensorProto.FLOAT, ["n", 3]) for name in ("x", "y")]
    shapes = [helper.make_tensor_value_info(name, TensorProto.FLOAT, ["n", 3]) for name in (sums, hidden)]
    graph = helper.make_graph(
        nodes, doc or "graph", ends[:1], ends[1:], weights[::order], doc, value_info=shapes[::order]
    )
    made = helper.make_model(graph, opset_imports=[helper.make_opsetid("", 17)], ir_version=10, producer_version=doc)
    for part in (made.graph.node[0], made.graph):
        part.metadata_props.add(key="where", value=f"/home/{doc}/network.py, line 7")
    helper.set_model_props(made, {"kind": "a kind"})
    return made


def anonymous(made: onnx.ModelProto) -> bytes:
    anonymise(made)
    onnx.checker.check_model(made, full_check=True)
    return made.SerializeToString(deterministic=True)


def run(data: bytes, x: np.ndarray) -> np.ndarray:
    return onnxruntime.InferenceSession(data, providers=["CPUExecutionProvider"]).run(["y"], {"x": x})[0]


def test_names_places_and_order_leave_no_trace():
    first = anonymous(model({}))
    assert anonymous(model({"w": "b", "b": "w", "hidden": "value_3"}, "somebody", order=-1)) == first
    assert b"somebody" not in first
    assert b"where" not in first


def test_it_computes_the_same_and_says_what_it_is():
    made = model({}, "somebody")
    x = np.random.default_rng(0).normal(size=(4, 3)).astype(np.float32)
    before, data = run(made.SerializeToString(), x), anonymous(made)
    np.testing.assert_array_equal(run(data, x), before)
    again = onnx.load_from_string(data)
    assert {item.key: item.value for item in again.metadata_props} == {"kind": "a kind"}
    assert ([v.name for v in again.graph.input], [v.name for v in again.graph.output]) == (["x"], ["y"])
    assert len({node.name for node in again.graph.node}) == 5, "quantising tells nodes apart by their names"


def test_doing_it_again_changes_nothing():
    data = anonymous(model({}))
    assert anonymous(onnx.load_from_string(data)) == data


def test_other_weights_are_another_file():
    other = model({})
    other.graph.initializer[0].CopyFrom(numpy_helper.from_array(np.ones((3, 3), np.float32), "w"))
    assert anonymous(other) != anonymous(model({}))


def test_torch_modules_that_compute_the_same_are_the_same_file():
    torch = pytest.importorskip("torch")
    from active_perceiver.vision.onnx_export import to_onnx

    class One(torch.nn.Module):
        def __init__(self) -> None:
            super().__init__()
            self.layer = torch.nn.Linear(3, 2)

        def forward(self, x):
            return torch.relu(self.layer(x))

    class Other(torch.nn.Module):
        def __init__(self, layer) -> None:
            super().__init__()
            self.renamed = layer

        def forward(self, images):
            moved = self.renamed(images)
            return torch.relu(moved)

    one = One().eval()
    data = [to_onnx(module, {"x": torch.rand(2, 3)}, ["y"], {"kind": "k"}) for module in (one, Other(one.layer))]
    assert data[0] == data[1]
    assert b".py" not in data[0]
