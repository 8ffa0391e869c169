"""A backbone with 8-bit numbers: a third of the size, and faster on processors that multiply them well."""

from __future__ import annotations

import logging
import tempfile
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from active_perceiver.errors import UserError
from active_perceiver.scenes.images import square_image
from active_perceiver.vision import sessions  # noqa: F401 - before ONNX Runtime, which then calls nobody

# Convolutions at the front that stay as they are: they take little time, and pixels suffer most from being rounded.
# The map's error (L2) is 11 % of the map with 2 of them, 18 % with none, 10 % with 4.
KEPT = 2


def quantise_backbone(source: Path, target: Path, images: Sequence[NDArray[np.uint8]], image_size: int) -> None:
    """Write a backbone that computes with 8-bit weights and activations, for ONNX Runtime.

    Args:
        source: ONNX file of the backbone.
        target: the file to write.
        images: N of (H, W, 3) uint8 RGB, by which the ranges of the activations are set; a few dozen like those that
            it will see.
        image_size: side in pixels to which they are scaled.

    Raises:
        UserError: if there are no images, the backbone has 8-bit numbers already, or `onnx` is not installed.
    """
    if not images:
        raise UserError("a backbone is made 8-bit by pictures, and there are none; give --calibrate SCENE")
    try:
        import onnx
        from onnxruntime.quantization import CalibrationDataReader, QuantType, quantize_static
        from onnxruntime.quantization.shape_inference import quant_pre_process
    except ImportError as error:
        raise UserError(
            f"8-bit networks are made with {error.name}: pip install 'active-perceiver[train]', or leave out --int8"
        ) from None

    class Reader(CalibrationDataReader):
        """Hands out the images, one at a time."""

        def __init__(self) -> None:
            self._batches: Iterator[dict[str, NDArray[np.uint8]]] = (
                {"images": square_image(image, image_size)[None]} for image in images
            )

        def get_next(self) -> dict[str, NDArray[np.uint8]] | None:
            """The next one, None after the last."""
            return next(self._batches, None)

    with tempfile.TemporaryDirectory(prefix="active-perceiver-") as name, _quiet():
        prepared = Path(name) / "prepared.onnx"
        if any(node.op_type == "QuantizeLinear" for node in onnx.load(source).graph.node):
            raise UserError(
                f"{source} has 8-bit numbers already; leave out --int8, or export the agent it was made of"
            )
        quant_pre_process(str(source), str(prepared), skip_symbolic_shape=True)
        quantize_static(
            str(prepared),
            str(target),
            Reader(),
            per_channel=True,
            activation_type=QuantType.QUInt8,
            weight_type=QuantType.QInt8,
            nodes_to_exclude=_front(onnx.load(prepared)),
        )


def _front(model: Any) -> list[str]:
    """Names of a network's nodes up to its `KEPT`-th convolution, in the order in which they are computed."""
    names, convolutions = [], 0
    for node in model.graph.node:
        names.append(node.name)
        convolutions += node.op_type == "Conv"
        if convolutions == KEPT:
            break
    return names


@contextmanager
def _quiet() -> Iterator[None]:
    """Hide the advice to prepare the network, which was done."""
    logging.disable(logging.WARNING)
    try:
        yield
    finally:
        logging.disable(logging.NOTSET)
