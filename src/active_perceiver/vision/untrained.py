"""Backbones with random weights: as fast as the published ones, which a measurement of speed then does not need."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import torch
from torch import nn

from active_perceiver.utils.files import replacing
from active_perceiver.vision.backbone import IMAGE_SIZE, Backbone, check_backbone
from active_perceiver.vision.efficientnet_lite import EfficientNetLite0
from active_perceiver.vision.onnx_export import backbone_onnx
from active_perceiver.vision.resnet50 import ResNet50Trunk

TRUNKS: dict[str, Callable[[], nn.Module]] = {"efficientnet_lite0": EfficientNetLite0, "resnet50": ResNet50Trunk}


def untrained_trunk(name: str, seed: int = 0) -> nn.Module:
    """The torch module of a backbone with random weights, in evaluation mode.

    The weights keep the size of what goes through them (He et al. 2015, https://arxiv.org/abs/1502.01852): numbers
    that fade away layer by layer would end as denormal ones, which processors compute slowly.

    Args:
        name: one of `BACKBONES`.
        seed: the weights follow from it.

    Raises:
        BackboneError: if there is no such backbone.
    """
    check_backbone(name)
    with torch.random.fork_rng():
        torch.manual_seed(seed)
        network = TRUNKS[name]().eval()
        for layer in network.modules():
            if isinstance(layer, nn.Conv2d):
                nn.init.kaiming_normal_(layer.weight, nonlinearity="relu")
    return network


def save_untrained_backbone(
    name: str, path: Path, image_size: int = IMAGE_SIZE, threads: int | None = None
) -> Backbone:
    """Write a backbone with random weights to a file of your own, never to the cache, and open it.

    Args:
        name: one of `BACKBONES`.
        path: the ONNX file to write.
        image_size: side in pixels to which images are scaled; a multiple of 32.
        threads: see `Backbone`.

    Raises:
        BackboneError: if there is no such backbone, or none for this size.
    """
    check_backbone(name, image_size)
    data = backbone_onnx(untrained_trunk(name), name, image_size)
    with replacing(path) as temporary:
        temporary.write_bytes(data)
    return Backbone(path, threads)
