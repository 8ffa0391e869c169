"""Taking out of an ONNX model what does not compute: where the code stood that it was converted from."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import onnx


def anonymise(model: onnx.ModelProto) -> None:
    """Leave the graph and its weights, so that the same network is the same file wherever it is converted.

    Torch's exporter writes the paths, line numbers and names of the Python code into the model. They are dropped, and
    nodes, weights and intermediate results are numbered as they are computed. Inputs, outputs and the model's own
    metadata keep their names. The model is changed in place.

    Args:
        model: without functions and without graphs inside nodes, as networks without branches and loops are.
    """
    graph = model.graph
    names = {value.name: value.name for value in (*graph.input, *graph.output)} | {"": ""}  # "": input not given
    weights = {weight.name: weight for weight in graph.initializer}
    used: list[onnx.TensorProto] = []
    for number, node in enumerate(graph.node):
        for name in node.input:
            if name in weights and name not in names:
                names[name] = f"weight_{len(used)}"
                used.append(weights[name])
        for name in node.output:
            names.setdefault(name, f"value_{len(names)}")
        node.name = f"node_{number}"
        node.input[:] = [names[name] for name in node.input]
        node.output[:] = [names[name] for name in node.output]
        _strip(node)
    for weight in used:
        weight.name = names[weight.name]
        _strip(weight)
    shapes = {names[value.name]: value for value in graph.value_info if value.name in names}
    for name, value in shapes.items():
        value.name = name
    for value in (*graph.input, *graph.output, *shapes.values()):
        _strip(value)
    _replace(graph.initializer, used)
    _replace(graph.value_info, [shapes[name] for name in names.values() if name in shapes])
    _strip(graph)
    graph.name = "network"
    model.ClearField("producer_version")


def _strip(part: onnx.GraphProto | onnx.NodeProto | onnx.TensorProto | onnx.ValueInfoProto) -> None:
    part.ClearField("doc_string")
    part.ClearField("metadata_props")


def _replace(field: Any, items: Iterable[Any]) -> None:
    """Give a repeated field of a model other content, of which some may come from the field itself."""
    copies = [type(item).FromString(item.SerializeToString()) for item in items]
    del field[:]
    field.extend(copies)
