"""Writing a trained recogniser for running without torch, and its weights for training on."""

from __future__ import annotations

import json
from pathlib import Path

import torch
from safetensors import SafetensorError, safe_open
from safetensors.torch import save_file
from torch import Tensor, nn

from active_perceiver.recognition.network import RECOGNISERS, RecogniserNetwork
from active_perceiver.recognition.recogniser import RecogniserError
from active_perceiver.utils.files import replacing
from active_perceiver.vision.onnx_export import to_onnx


class _BothWays(nn.Module):
    """One graph with two ways through it: target pictures to codes, and views with codes to judgements."""

    def __init__(self, network: RecogniserNetwork) -> None:
        super().__init__()
        self.network = network

    def forward(self, view_maps: Tensor, embeddings: Tensor, target_maps: Tensor) -> tuple[Tensor, Tensor, Tensor]:
        """(N, C, h, w), (M, D), (K, C, h, w) -> (N, M) logits, (N, M, 4) boxes, (K, D) codes."""
        network = self.network
        logits, boxes = network.all_pairs(network.encode_view(network.prepare(view_maps)), embeddings)
        return logits, boxes, network.encode_target(network.prepare_target(target_maps))


def recogniser_onnx(network: RecogniserNetwork, threshold: float = 0.5, backbone: str = "") -> bytes:
    """The ONNX model that `Recogniser` runs, checked against torch.

    Args:
        network: trained.
        threshold: presence probability from which on a detection counts.
        backbone: fingerprint of the backbone it was trained on.

    Raises:
        ExportError: if the ONNX model computes something else.
    """
    network = network.eval()
    generator = torch.Generator().manual_seed(0)
    views, targets = (torch.rand(count, *network.map_shape, generator=generator) for count in (2, 4))
    with torch.inference_mode():
        embeddings = network.encode_target(network.prepare_target(targets))[:3]
    metadata = {
        "kind": "active-perceiver-recogniser",
        "recogniser": kind_of(network),
        "threshold": repr(threshold),
        "backbone": backbone,
    }
    inputs = {"view_maps": views, "codes": embeddings.clone(), "target_maps": targets}
    return to_onnx(_BothWays(network), inputs, ["logits", "boxes", "target_codes"], metadata)


def export_recogniser(
    network: RecogniserNetwork, path: Path | str, threshold: float = 0.5, backbone: str = ""
) -> None:
    """Write `recogniser_onnx` to a file, atomically; see there for the arguments."""
    data = recogniser_onnx(network, threshold, backbone)
    with replacing(Path(path)) as temporary:
        temporary.write_bytes(data)


def kind_of(network: RecogniserNetwork) -> str:
    """The network's name in `RECOGNISERS`."""
    return next(name for name, kind in RECOGNISERS.items() if type(network) is kind)


def save_network(network: RecogniserNetwork, path: Path | str) -> None:
    """Write the weights as safetensors, atomically; the kind and the shape of the maps go into the header."""
    description = {"recogniser": kind_of(network), "map_shape": json.dumps(network.map_shape)}
    with replacing(Path(path)) as temporary:
        save_file(network.state_dict(), temporary, metadata=description)


def load_network(path: Path | str) -> RecogniserNetwork:
    """Read what `save_network` wrote.

    Raises:
        RecogniserError: if the file is missing, damaged or not a recogniser's.
    """
    try:
        with safe_open(str(path), framework="pt") as file:
            description = file.metadata() or {}
            network = RECOGNISERS[description["recogniser"]](tuple(json.loads(description["map_shape"])))
            network.load_state_dict({name: file.get_tensor(name) for name in file.keys()})  # noqa: SIM118
    except FileNotFoundError:
        raise RecogniserError(f"there is no file {path}; train a recogniser first") from None
    except (SafetensorError, OSError, KeyError, ValueError, RuntimeError) as error:
        raise RecogniserError(f"{path} does not hold the weights of a recogniser: {error}") from None
    return network.eval()
