"""Backbones with random weights: the same networks, and never in the way of the published weights."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from active_perceiver.vision import BACKBONES, Backbone, BackboneError
from helpers.small import SIZE

torch = pytest.importorskip("torch")
from active_perceiver.vision.untrained import TRUNKS, save_untrained_backbone, untrained_trunk  # noqa: E402


@pytest.mark.parametrize("name", BACKBONES)
def test_what_goes_through_neither_fades_nor_grows_beyond_bounds(name: str, rng: np.random.Generator) -> None:
    images = torch.from_numpy(rng.integers(0, 256, (1, SIZE, SIZE, 3), dtype=np.uint8))
    with torch.inference_mode():
        maps = untrained_trunk(name)(images).numpy()
    assert maps.shape == (1, BACKBONES[name].channels, SIZE // 16, SIZE // 16)
    assert 1e-2 < np.abs(maps).mean() < 1e4


def test_every_backbone_has_its_trunk() -> None:
    assert set(TRUNKS) == set(BACKBONES)


def test_lite0_is_the_network_of_the_published_weights(backbone: Backbone, tmp_path: Path) -> None:
    other = save_untrained_backbone("efficientnet_lite0", tmp_path / "random.onnx", SIZE, threads=1)
    assert (other.name, other.channels, other.map_size) == (backbone.name, backbone.channels, backbone.map_size)
    assert other.fingerprint != backbone.fingerprint
    image = [np.full((SIZE, SIZE, 3), 90, np.uint8)]
    assert not np.allclose(other.maps(image), backbone.maps(image), atol=0.1)


def test_weights_follow_from_the_seed_and_leave_torchs_own_stream_alone() -> None:
    torch.manual_seed(5)
    expected = torch.rand(3)
    torch.manual_seed(5)
    first, same, other = (untrained_trunk("efficientnet_lite0", seed).state_dict() for seed in (0, 0, 1))
    assert torch.equal(torch.rand(3), expected)
    assert torch.equal(first["_conv_stem.weight"], same["_conv_stem.weight"])
    assert not torch.equal(first["_conv_stem.weight"], other["_conv_stem.weight"])


def test_wrong_input_is_explained(tmp_path: Path) -> None:
    with pytest.raises(BackboneError, match="no backbone 'resnet51'"):
        untrained_trunk("resnet51")
    with pytest.raises(BackboneError, match="multiple of 32"):
        save_untrained_backbone("resnet50", tmp_path / "x.onnx", 100)
    assert not list(tmp_path.iterdir())
