"""The frozen ImageNet network that turns images into feature maps, run by ONNX Runtime (the paper, section IV).

Torch is needed once, to convert a network's published weights; the result is kept in the user's cache.
"""

from __future__ import annotations

import hashlib
import os
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from active_perceiver.scenes.images import square_image
from active_perceiver.utils.files import replacing
from active_perceiver.vision.sessions import BackboneError, ModelFileError, open_session

if TYPE_CHECKING:
    from torch import nn

# How far from the middle of a target picture its object is looked for, as a fraction of half the picture.
FOCUS = 0.45
STRIDE = 16
IMAGE_SIZE = 320
FILE_NAME = "backbone.onnx"
# Images that go through the network together: larger batches are no faster on a CPU and need more memory.
BATCH = 8


@dataclass(frozen=True)
class BackboneKind:
    """A network that can serve as backbone.

    Attributes:
        channels: features per cell of the map.
        build: makes the torch module, (N, H, W, 3) uint8 -> (N, channels, H / 16, W / 16) float32.
        summary: one line for people.
    """

    channels: int
    build: Callable[[], nn.Module]
    summary: str


def _efficientnet_lite0() -> nn.Module:
    from active_perceiver.vision.efficientnet_lite import efficientnet_lite0

    return efficientnet_lite0()


def _resnet50() -> nn.Module:
    from active_perceiver.vision.resnet50 import resnet50

    return resnet50()


BACKBONES: dict[str, BackboneKind] = {
    "efficientnet_lite0": BackboneKind(672, _efficientnet_lite0, "fast, its weights come with the `train` extra"),
    "resnet50": BackboneKind(1024, _resnet50, "the paper's; its weights (98 MB) are downloaded once"),
}


def cache_folder() -> Path:
    """Where converted backbones and features of scenes are kept; set ACTIVE_PERCEIVER_CACHE to choose another.

    Raises:
        BackboneError: if no folder is chosen and platformdirs, which knows the user's, is not installed.
    """
    if chosen := os.environ.get("ACTIVE_PERCEIVER_CACHE"):
        return Path(chosen)
    try:
        import platformdirs  # a robot with an exported agent has no cache, and is not asked to have it
    except ImportError:
        raise BackboneError(
            "there is no cache to look for a backbone in: `active-perceiver export` makes an agent's folder that "
            "holds its own; or set ACTIVE_PERCEIVER_CACHE to a folder, or pip install platformdirs"
        ) from None
    return Path(platformdirs.user_cache_dir("active-perceiver"))


def pooled(maps: NDArray[np.floating]) -> NDArray[np.float32]:
    """Global average of feature maps, (N, C, h, w) -> (N, C) float32."""
    return maps.mean(axis=(2, 3), dtype=np.float32)


def middle_weights(rows: int, columns: int) -> NDArray[np.float32]:
    """How much each cell of a target picture's map counts, (rows, columns): 1 in the middle, where the object is."""
    y, x = ((np.arange(count, dtype=np.float32) + 0.5) / count * 2 - 1 for count in (rows, columns))
    return np.exp(-(y[:, None] ** 2 + x[None] ** 2) / (2 * FOCUS**2)).astype(np.float32)


def pooled_middle(maps: NDArray[np.floating]) -> NDArray[np.float32]:
    """Average of target pictures' maps over their middle, (N, C, h, w) -> (N, C) float32: not what lies around."""
    weights = middle_weights(*maps.shape[2:])
    weights /= weights.sum()
    middles = [np.tensordot(one.astype(np.float32), weights, axes=2) for one in maps]
    return np.array(middles, np.float32).reshape(maps.shape[:2])  # there may be no maps at all


class Backbone:
    """A frozen feature extractor.

    Args:
        path: an ONNX file as `load_backbone` makes it.
        threads: CPU threads of one inference; None for one per core.

    Attributes:
        name: one of `BACKBONES`.
        channels: features per cell, C.
        image_size: images are scaled to squares of this many pixels.
        map_size: cells along a side of the map, `image_size / 16`.
        path: the ONNX file.

    Raises:
        ModelFileError: if the file is missing or is no backbone.
    """

    def __init__(self, path: Path | str, threads: int | None = None) -> None:
        self.path = Path(path)
        self._session = open_session(self.path, threads, "backbone")
        self.name: str = self._session.get_modelmeta().custom_metadata_map["name"]
        self.image_size: int = self._session.get_inputs()[0].shape[1]
        self.channels: int = self._session.get_outputs()[0].shape[1]
        self.map_size = self.image_size // STRIDE
        # Names the weights: features of two backbones with the same fingerprint are the same.
        self.fingerprint = hashlib.sha256(self.path.read_bytes()).hexdigest()[:16]

    def maps(self, images: Sequence[NDArray[np.uint8]]) -> NDArray[np.float32]:
        """Feature maps of images of any size; they are fitted into squares, see `square_image`.

        Args:
            images: N of (H, W, 3) uint8 RGB.

        Returns:
            (N, C, map_size, map_size) float32.

        Raises:
            BackboneError: if an image is not (H, W, 3) uint8.
        """
        result = np.empty((len(images), self.channels, self.map_size, self.map_size), np.float32)
        for start in range(0, len(images), BATCH):
            batch = np.stack([self._square(image) for image in images[start : start + BATCH]])
            result[start : start + BATCH] = self._session.run(None, {"images": batch})[0]
        return result

    def _square(self, image: NDArray[np.uint8]) -> NDArray[np.uint8]:
        if not isinstance(image, np.ndarray) or image.dtype != np.uint8 or image.shape[2:] != (3,) or not image.size:
            given = f"{image.dtype} {image.shape}" if isinstance(image, np.ndarray) else type(image).__name__
            raise BackboneError(f"an image must be (height, width, 3) uint8 RGB, got {given}; see `decode_image`")
        return square_image(image, self.image_size)


def load_backbone(
    name: str = "efficientnet_lite0",
    folder: Path | str | None = None,
    image_size: int = IMAGE_SIZE,
    threads: int | None = None,
) -> Backbone:
    """Load a backbone: from an agent's folder, else from the cache, else by converting its published weights.

    Args:
        name: one of `BACKBONES`.
        folder: used if it contains backbone.onnx, as an exported agent's folder does.
        image_size: side in pixels to which images are scaled; a multiple of 32.
        threads: CPU threads of one inference; None for one per core.

    Raises:
        BackboneError: if there is no such backbone, the one in the folder is another, or it would have to be made
            and cannot be (no torch, no weights).
    """
    check_backbone(name, image_size)
    if folder is not None and (path := Path(folder) / FILE_NAME).exists():
        backbone = _open(path, threads)
        if (backbone.name, backbone.image_size) != (name, image_size):
            raise BackboneError(
                f"{path} is {backbone.name} for {backbone.image_size} pixels; {name} for {image_size} is asked for"
            )
        return backbone
    path = cached_path(name, image_size)
    if path.exists():
        try:
            return Backbone(path, threads)
        except ModelFileError:
            pass  # damaged in the cache: made again
    _convert(name, image_size, path)
    return Backbone(path, threads)


def check_backbone(name: str, image_size: int = IMAGE_SIZE) -> None:
    """Make sure that there can be such a backbone.

    Raises:
        BackboneError: if its name is unknown or the size does not suit its strides.
    """
    if name not in BACKBONES:
        raise BackboneError(f"there is no backbone '{name}'; there are {', '.join(BACKBONES)}")
    if image_size < 32 or image_size % 32:
        raise BackboneError(f"the image size must be a multiple of 32, got {image_size}; 320 is the usual one")


def cached_path(name: str, image_size: int = IMAGE_SIZE) -> Path:
    """Where the cache keeps a converted backbone, whether it is there or not."""
    return cache_folder() / "backbones" / f"{name}-{image_size}.onnx"


def _open(path: Path, threads: int | None) -> Backbone:
    try:
        return Backbone(path, threads)
    except ModelFileError as error:
        raise BackboneError(str(error)) from None


def _convert(name: str, image_size: int, path: Path) -> None:
    """Write the ONNX file of a backbone, checked against torch.

    Raises:
        BackboneError: if torch or onnx are not installed, or the weights are not to be had.
    """
    try:
        from active_perceiver.vision.onnx_export import backbone_onnx
    except ImportError as error:
        raise BackboneError(
            f"the backbone {name} is not in the cache ({path}), and making it needs {error.name}: run once "
            "where `pip install 'active-perceiver[train]'` was done, or copy backbone.onnx into the agent's folder"
        ) from None
    data = backbone_onnx(BACKBONES[name].build(), name, image_size)
    try:
        with replacing(path) as temporary:
            temporary.write_bytes(data)
    except OSError as error:
        raise BackboneError(
            f"{path} cannot be written ({error.strerror}); set ACTIVE_PERCEIVER_CACHE to a folder that can"
        ) from None
