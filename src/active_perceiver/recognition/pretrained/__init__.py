"""Weights that matching recognisers start from, learned in rooms that are not among the bundled scenes."""

from __future__ import annotations

from pathlib import Path

from active_perceiver.recognition.export import load_network
from active_perceiver.recognition.network import RecogniserNetwork


def pretrained_path(kind: str, backbone: str, image_size: int) -> Path:
    """Where the weights for a kind of recogniser and a backbone are, if there are any."""
    return Path(__file__).parent / f"{kind}-{backbone}-{image_size}.safetensors"


def pretrained_network(kind: str, backbone: str, image_size: int) -> RecogniserNetwork | None:
    """A recogniser that `active-perceiver pretrain` has trained; None if there is none for this backbone.

    Args:
        kind: a name in `RECOGNISERS`.
        backbone: a name in `BACKBONES`.
        image_size: side in pixels to which the backbone scales images.
    """
    path = pretrained_path(kind, backbone, image_size)
    return load_network(path) if path.is_file() else None
