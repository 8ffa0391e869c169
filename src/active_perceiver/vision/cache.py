"""The feature maps of a whole scene, computed once and kept on disk.

A view takes 2 bytes x C x h x w: 538 kB with efficientnet_lite0 and 820 kB with resnet50 at 320 pixels, so about half
a gigabyte for a room of 900 views. They are read through a memory map: only what is used comes into memory.
"""

from __future__ import annotations

import hashlib
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from active_perceiver.errors import UserError
from active_perceiver.scenes.scene import Scene
from active_perceiver.utils.files import replacing
from active_perceiver.vision.backbone import BATCH, Backbone, cache_folder, pooled, pooled_middle

if TYPE_CHECKING:
    # It draws with a library that a robot needs not have.
    from active_perceiver.utils.progress import ProgressCallback

# Part of every file's name: to be raised when the same key would mean other content.
VERSION = 1


@dataclass(frozen=True, eq=False)
class SceneFeatures:
    """What a backbone makes of a scene's views and target pictures.

    Targets may have different numbers of pictures; in the arrays each has K, the largest number, and one with
    fewer repeats its own: picture k of target t is its picture k % picture_counts[t].

    Attributes:
        view_maps: (S, C, h, w) float16, memory-mapped and read-only.
        view_features: (S, C) float32, the maps' global average.
        target_maps: (T, K, C, h, w) float16.
        target_features: (T, K, C) float32, the maps' average over the middle, see `pooled_middle`.
        picture_counts: (T,) int64, how many pictures each target really has.
        backbone: fingerprint of the backbone that made them, see `Backbone.fingerprint`.
    """

    view_maps: NDArray[np.float16]
    view_features: NDArray[np.float32]
    target_maps: NDArray[np.float16]
    target_features: NDArray[np.float32]
    picture_counts: NDArray[np.int64]
    backbone: str


def scene_features(scene: Scene, backbone: Backbone, progress: ProgressCallback | None = None) -> SceneFeatures:
    """The feature maps of a scene, from the cache if they are there.

    Files are named after the content of the images and of the backbone, appear whole or not at all, and are made
    again if damaged.

    Args:
        scene: whose views and target pictures.
        backbone: makes the maps.
        progress: called with the number of images done and of all that must be computed.

    Raises:
        ImageError: if an image of the scene cannot be decoded.
        UserError: if the cache cannot be written.
    """
    pictures = [(t, k) for t, target in enumerate(scene.targets) for k in range(len(target.pictures))]
    views = _MapFile(backbone, scene.content_hash, len(scene), scene.view)
    targets = _MapFile(
        backbone,
        _pictures_hash(scene),
        len(pictures),
        lambda i: scene.targets[pictures[i][0]].picture(pictures[i][1]),
    )
    missing = [file for file in (targets, views) if file.load() is None]
    total, done = sum(file.count for file in missing), 0
    for file in missing:
        file.compute(lambda count, before=done: progress(before + count, total) if progress else None)  # type: ignore[misc]
        done += file.count
    view_maps, view_features = views.content()
    picture_maps, _ = targets.content()
    counts = np.array([len(target.pictures) for target in scene.targets], np.int64)
    first = np.cumsum(counts) - counts
    # A scene whose views are searched for may have no targets, and no pictures.
    rows = first[:, None] + np.arange(counts.max(initial=0)) % counts[:, None]
    return SceneFeatures(
        view_maps, view_features, picture_maps[rows], pooled_middle(picture_maps)[rows], counts, backbone.fingerprint
    )


def _pictures_hash(scene: Scene) -> str:
    digest = hashlib.sha256()
    for target in scene.targets:
        for picture in target.pictures:
            digest.update(hashlib.sha256(picture).digest())
    return digest.hexdigest()[:24]


class _MapFile:
    """Two files of the cache: the maps of some images, and their averages."""

    def __init__(
        self, backbone: Backbone, images_hash: str, count: int, image: Callable[[int], NDArray[np.uint8]]
    ) -> None:
        folder = cache_folder() / "features" / f"{backbone.name}-{backbone.image_size}-{backbone.fingerprint}"
        self.maps_path = folder / f"{images_hash}-maps-{VERSION}.npy"
        self.averages_path = folder / f"{images_hash}-averages-{VERSION}.npy"
        self.count = count
        self._backbone = backbone
        self._image = image
        self._shape = (count, backbone.channels, backbone.map_size, backbone.map_size)

    def load(self) -> tuple[NDArray[np.float16], NDArray[np.float32]] | None:
        """Maps and averages; None if they are not there, are damaged or of the wrong shape."""
        try:
            maps = np.load(self.maps_path, mmap_mode="r" if self.count else None, allow_pickle=False)
            averages = np.load(self.averages_path, allow_pickle=False)
        except (OSError, ValueError, EOFError):
            return None
        sound = (maps.shape, averages.shape) == (self._shape, self._shape[:2])
        typed = (maps.dtype, averages.dtype) == (np.float16, np.float32)
        return (maps, averages) if sound and typed else None

    def content(self) -> tuple[NDArray[np.float16], NDArray[np.float32]]:
        """Maps and averages of files that were just made or found.

        Raises:
            UserError: if another process took them away.
        """
        loaded = self.load()
        if loaded is None:
            raise UserError(f"{self.maps_path} was removed or damaged while it was in use; run the command again")
        return loaded

    def compute(self, progress: Callable[[int], None]) -> None:
        """Make both files, a batch at a time; the averages last, so that they vouch for the maps."""
        try:
            with replacing(self.maps_path) as temporary:
                averages = self._write_maps(temporary, progress)
            with replacing(self.averages_path) as temporary, temporary.open("wb") as file:
                np.save(file, averages)
        except OSError as error:
            size = 2 * int(np.prod(self._shape)) / 1e6
            raise UserError(
                f"the feature cache {self.maps_path.parent} cannot be written ({error.strerror}); it needs "
                f"{size:.0f} MB. Set ACTIVE_PERCEIVER_CACHE to a folder with room"
            ) from None

    def _write_maps(self, path: Path, progress: Callable[[int], None]) -> NDArray[np.float32]:
        averages = np.empty(self._shape[:2], np.float32)
        header = {"descr": np.lib.format.dtype_to_descr(np.dtype(np.float16)), "fortran_order": False}
        with path.open("wb") as file:
            # Plain writes and not a memory map: on a full disk they raise an error instead of killing the process.
            np.lib.format.write_array_header_1_0(file, {**header, "shape": self._shape})
            for start in range(0, self.count, BATCH):
                stop = min(start + BATCH, self.count)
                maps = self._backbone.maps([self._image(index) for index in range(start, stop)]).astype(np.float16)
                averages[start:stop] = pooled(maps)
                file.write(maps.tobytes())
                progress(stop)
        return averages
