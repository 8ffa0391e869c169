from __future__ import annotations

import urllib.error

import numpy as np
import pytest

from active_perceiver.vision import BACKBONES, BackboneError, load_backbone, pooled
from active_perceiver.vision.backbone import Backbone
from active_perceiver.vision.sessions import ModelFileError
from helpers.small import SIZE

torch = pytest.importorskip("torch")


def noise(rng, *shape: int) -> np.ndarray:
    return rng.integers(0, 256, shape, dtype=np.uint8)


def test_maps_are_those_of_torch(backbone, rng):
    from active_perceiver.vision.efficientnet_lite import efficientnet_lite0

    images = noise(rng, 3, SIZE, SIZE, 3)
    with torch.inference_mode():
        expected = efficientnet_lite0()(torch.from_numpy(images)).numpy()
    maps = backbone.maps(list(images))
    assert maps.shape == (3, 672, SIZE // 16, SIZE // 16)
    assert maps.dtype == np.float32
    np.testing.assert_allclose(maps, expected, atol=2e-3)


def test_a_map_does_not_depend_on_the_batch(backbone, rng):
    images = list(noise(rng, 11, SIZE, SIZE, 3))
    np.testing.assert_allclose(backbone.maps(images)[10], backbone.maps(images[10:])[0], atol=1e-4)


@pytest.mark.parametrize("shape", [(7, 90, 3), (200, 31, 3), (1, 1, 3), (SIZE, SIZE, 3)])
def test_images_of_any_size(backbone, rng, shape):
    assert np.isfinite(backbone.maps([noise(rng, *shape)])).all()


def test_no_images(backbone):
    assert backbone.maps([]).shape == (0, 672, SIZE // 16, SIZE // 16)


@pytest.mark.parametrize(
    "image",
    [
        np.zeros((SIZE, SIZE), np.uint8),
        np.zeros((SIZE, SIZE, 4), np.uint8),
        np.zeros((SIZE, SIZE, 3), np.float32),
        np.zeros((0, 5, 3), np.uint8),
        "picture.png",
    ],
)
def test_what_is_no_image_is_refused(backbone, image):
    with pytest.raises(BackboneError, match="uint8 RGB"):
        backbone.maps([image])


def test_pooled_is_the_mean(rng):
    maps = rng.normal(size=(2, 5, 3, 4)).astype(np.float32)
    np.testing.assert_allclose(pooled(maps), maps.reshape(2, 5, -1).mean(2), atol=1e-6)


def test_lite0_knows_pictures_apart(backbone, scene):
    """Crops of a picture are nearer to their own picture than to others: the weights are really trained ones."""
    pictures = [target.picture() for target in scene.targets]
    crops = [np.ascontiguousarray(picture[3:-2, 5:, ::1]) for picture in pictures]
    whole, cropped = (pooled(backbone.maps(images)) for images in (pictures, crops))
    unit = [features / np.linalg.norm(features, axis=1, keepdims=True) for features in (whole, cropped)]
    assert ((unit[1] @ unit[0].T).argmax(1) == np.arange(len(pictures))).all()


def test_a_second_load_reads_the_cache(backbone, monkeypatch):
    monkeypatch.setattr("active_perceiver.vision.backbone._convert", lambda *_: pytest.fail("was converted again"))
    assert load_backbone(image_size=SIZE).fingerprint == backbone.fingerprint


def test_a_damaged_cache_file_is_made_again(backbone, monkeypatch, tmp_path):
    monkeypatch.setenv("ACTIVE_PERCEIVER_CACHE", str(tmp_path))
    path = tmp_path / "backbones" / f"efficientnet_lite0-{SIZE}.onnx"
    path.parent.mkdir()
    path.write_bytes(backbone.path.read_bytes()[:1000])
    monkeypatch.setattr(
        "active_perceiver.vision.backbone._convert", lambda _, __, path: path.write_bytes(backbone.path.read_bytes())
    )
    assert load_backbone(image_size=SIZE).fingerprint == backbone.fingerprint


def test_an_agents_folder_comes_first(backbone, tmp_path):
    (tmp_path / "backbone.onnx").write_bytes(backbone.path.read_bytes())
    assert load_backbone(folder=tmp_path, image_size=SIZE).path.parent == tmp_path
    with pytest.raises(BackboneError, match="for 96 pixels; efficientnet_lite0 for 128"):
        load_backbone(folder=tmp_path, image_size=128)
    (tmp_path / "backbone.onnx").write_bytes(b"nothing")
    with pytest.raises(BackboneError, match="not a readable ONNX model"):
        load_backbone(folder=tmp_path, image_size=SIZE)


def test_bad_arguments():
    with pytest.raises(BackboneError, match="there are efficientnet_lite0, resnet50"):
        load_backbone("alexnet")
    with pytest.raises(BackboneError, match="multiple of 32"):
        load_backbone(image_size=100)
    with pytest.raises(ModelFileError, match="cannot be read"):
        Backbone("no/such/file.onnx")


def test_resnet50_offline_names_the_way_out(monkeypatch, tmp_path):
    def offline(*_, **__):
        raise urllib.error.URLError("no network")

    monkeypatch.setattr("torch.hub.urlopen", offline)
    monkeypatch.setenv("ACTIVE_PERCEIVER_CACHE", str(tmp_path))
    monkeypatch.setenv("TORCH_HOME", str(tmp_path))
    with pytest.raises(BackboneError, match="--backbone efficientnet_lite0"):
        load_backbone("resnet50", image_size=SIZE)


def test_resnet50_trunk_loads_torchvisions_names_strictly(rng):
    from active_perceiver.vision.resnet50 import ResNet50Trunk, load_weights

    network = ResNet50Trunk().eval()
    state = network.state_dict()
    # 8.5 million weights and these names are what torchvision's file has up to layer3.
    assert sum(value.numel() for value in network.parameters()) == 8_543_296
    assert {"conv1.weight", "layer1.0.downsample.1.running_var", "layer3.5.bn3.bias"} <= state.keys()
    load_weights(network, {**state, "fc.weight": torch.zeros(1), "layer4.0.conv1.weight": torch.zeros(1)})
    with pytest.raises(BackboneError, match="missing"):
        load_weights(network, {name: value for name, value in state.items() if name != "layer2.0.conv1.weight"})
    with pytest.raises(BackboneError, match="unexpected"):
        load_weights(network, {**state, "head.weight": torch.zeros(1)})
    with torch.inference_mode():
        assert network(torch.from_numpy(noise(rng, 1, 64, 64, 3))).shape == (1, BACKBONES["resnet50"].channels, 4, 4)
