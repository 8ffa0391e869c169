"""Converting torch modules to ONNX, with the proof that they compute the same. Needs torch and onnx."""

from __future__ import annotations

import logging
import warnings
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager

import numpy as np
import torch
from torch import Tensor, nn

from active_perceiver.vision.onnx_names import anonymise
from active_perceiver.vision.sessions import onnxruntime


class ExportError(RuntimeError):
    """The ONNX model does not compute what the torch module computes."""


@contextmanager
def _quiet() -> Iterator[None]:
    """Hide what torch's exporter says about its own insides and about torchvision, which is not needed."""
    logger = logging.getLogger("torch.onnx")
    level = logger.level
    logger.setLevel(logging.ERROR)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            yield
    finally:
        logger.setLevel(level)


@torch.inference_mode()
def to_onnx(
    module: nn.Module,
    inputs: Mapping[str, Tensor],
    outputs: Sequence[str],
    metadata: Mapping[str, str],
    tolerance: float = 1e-3,
) -> bytes:
    """Convert a module whose inputs and outputs have a free first axis, and check it.

    Args:
        module: in evaluation mode; takes `inputs` by position.
        inputs: name -> example; every first axis is at least 2 long and all differ, so that the converter does
            not take two of them for the same.
        outputs: names of what the module returns.
        metadata: what to store in the file, beside the weights.
        tolerance: largest difference allowed between torch and ONNX Runtime, relative to the largest output.

    Returns:
        The ONNX file's content; it follows from the network alone, see `anonymise`.

    Raises:
        ExportError: if the outputs differ.
    """
    batch_axes = tuple({0: torch.export.Dim(f"batch_{name}")} for name in inputs)
    with _quiet():
        program = torch.onnx.export(
            module,
            tuple(inputs.values()),
            input_names=list(inputs),
            output_names=list(outputs),
            dynamic_shapes=batch_axes,
            dynamo=True,
            external_data=False,
            verbose=False,
        )
    assert program is not None
    program.model.metadata_props.update(metadata)
    model = program.model_proto
    anonymise(model)
    data = model.SerializeToString(deterministic=True)
    returned = module(*inputs.values())
    expected = [returned] if isinstance(returned, Tensor) else list(returned)
    session = onnxruntime.InferenceSession(data, providers=["CPUExecutionProvider"])
    actual = session.run(list(outputs), {name: value.numpy() for name, value in inputs.items()})
    for name, ours, theirs in zip(outputs, actual, expected, strict=True):
        difference = float(np.abs(ours - theirs.numpy()).max()) / max(1.0, float(theirs.abs().max()))
        if not difference <= tolerance:
            raise ExportError(f"output '{name}' of the ONNX model differs from torch's by {difference:.2g}")
    return data


def backbone_onnx(network: nn.Module, name: str, image_size: int) -> bytes:
    """The ONNX file of a backbone, checked against torch.

    Args:
        network: (N, H, W, 3) uint8 -> (N, C, H / 16, W / 16) float32, in evaluation mode.
        name: what the file says it is, one of `BACKBONES`.
        image_size: H and W.

    Raises:
        ExportError: if the outputs differ.
    """
    images = torch.randint(0, 256, (2, image_size, image_size, 3), generator=torch.Generator().manual_seed(0))
    metadata = {"kind": "active-perceiver-backbone", "name": name}
    return to_onnx(network, {"images": images.to(torch.uint8)}, ["maps"], metadata)
