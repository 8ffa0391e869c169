"""Further views and target pictures for a recogniser to learn from: changed copies of those it may learn from."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

from active_perceiver.recognition.augmented_images import changed_picture, changed_view, picture_from_view
from active_perceiver.recognition.network import RecogniserNetwork
from active_perceiver.recognition.pairs import ABSENT, IGNORE_INDEX, PRESENT, Annotations, Split
from active_perceiver.scenes.scene import Scene
from active_perceiver.utils.prefetch import prefetch_batches
from active_perceiver.utils.progress import ProgressCallback, quiet
from active_perceiver.vision.backbone import BATCH, Backbone

# An object of which less is left in a copy of a view counts neither as there nor as absent.
LEAST_KEPT = 0.5
# What is cut out of a view to be a target picture must have covered so much of it, or it is only a blur.
SMALLEST_CROP = 0.006


@dataclass(frozen=True)
class AugmentationConfig:
    """How much further material is made."""

    views: int = 2400
    """Copies of views in all, from nearer and in other light; of each view equally many, at least one unless it is 0:
    where views are few, each is worth more copies, and where they are many, training takes no longer."""
    pictures: int = 4
    """Copies of each target picture, framed otherwise and in other light."""
    crops: int = 16
    """Target pictures cut out of views, for each target; fewer if it is large enough in fewer views."""


@dataclass(frozen=True, eq=False)
class AugmentedData:
    """Further views and pictures, prepared by the network that will learn from them.

    Attributes:
        views: (N, ...) float16.
        originals: (N,) int64: which view each is a copy of.
        boxes: (N, T, 4) float32 true boxes; zeros where the target is not visible.
        states: (N, T) int8, see `Annotations`.
        pictures: (T, M, ...) float16; of target t, the first `counts[t]` are pictures.
        counts: (T,) int64.
    """

    views: Tensor
    originals: NDArray[np.int64]
    boxes: NDArray[np.float32]
    states: NDArray[np.int8]
    pictures: Tensor
    counts: NDArray[np.int64]

    def added_to(self, data: Annotations, split: Split) -> tuple[Annotations, Split]:
        """Annotations and split of the views there were and, after them, the further ones; none is held out."""
        together = replace(
            data,
            boxes=np.concatenate([data.boxes, self.boxes]),
            states=np.concatenate([data.states, self.states]),
            places=np.concatenate([data.places, data.places[self.originals]]),
        )
        return together, replace(split, views=np.concatenate([split.views, np.zeros(len(self.originals), bool)]))


def make_augmented(
    scenes: Sequence[Scene],
    backbone: Backbone,
    network: RecogniserNetwork,
    data: Annotations,
    split: Split,
    config: AugmentationConfig,
    rng: np.random.Generator,
    progress: ProgressCallback = quiet,
) -> AugmentedData:
    """Make further material from what is not held out.

    Args:
        scenes: whose images.
        backbone: makes the feature maps.
        network: prepares them.
        data: of the scenes.
        split: what is held out: nothing is made from it.
        config: how much.
        rng: draws all changes.
        progress: called with the number of images done and of all.
    """
    size = backbone.image_size
    first_view = np.cumsum([0] + [len(scene) for scene in scenes])
    scene_of_view = np.repeat(np.arange(len(scenes)), [len(scene) for scene in scenes])

    def view(row: int) -> NDArray[np.uint8]:
        number = scene_of_view[row]
        return scenes[number].view(int(row - first_view[number]))

    learned = np.flatnonzero(~split.views & (data.states != IGNORE_INDEX).any(axis=1))
    originals = np.tile(learned, max(round(config.views / max(1, len(learned))), int(config.views > 0)))
    crops = [_views_to_crop(data, split, target, config.crops, rng) for target in range(len(data.names))]
    targets = [target for scene in scenes for target in scene.targets]
    copied = np.where(split.targets, 0, split.seen_pictures * config.pictures)
    counts = copied + [len(rows) for rows in crops]
    done, total = 0, len(originals) + int(counts.sum())

    def counted(images: Iterator[NDArray[np.uint8]]) -> Iterator[NDArray[np.uint8]]:
        nonlocal done
        for image in images:
            yield image
            done += 1
            progress(done, total, "further views and pictures")

    boxes = np.zeros((len(originals), *data.boxes.shape[1:]), np.float32)
    states = np.full(boxes.shape[:2], IGNORE_INDEX, np.int8)

    def copies_of_views() -> Iterator[NDArray[np.uint8]]:
        for number, row in enumerate(originals):
            visible = data.boxes[row, :, 2:].prod(axis=1) > 0
            there = np.where(visible[:, None], data.boxes[row], np.nan)
            image, inside, kept = changed_view(view(row), there, size, rng)
            boxes[number], states[number] = np.nan_to_num(inside), _states(data, row, inside, kept)
            yield image

    def further_pictures(target: int) -> Iterator[NDArray[np.uint8]]:
        for number in range(copied[target]):
            picture = targets[target].picture(number % int(split.seen_pictures[target]))
            yield changed_picture(picture, size, rng)
        for row in crops[target]:
            yield picture_from_view(view(row), data.boxes[row, target], size, rng)

    views = _prepared(counted(copies_of_views()), backbone, network.prepare)
    pictures = [
        _prepared(counted(further_pictures(target)), backbone, network.prepare_target)
        for target in range(len(data.names))
    ]
    return AugmentedData(views, originals, boxes, states, torch.nn.utils.rnn.pad_sequence(pictures, True), counts)


def _views_to_crop(
    data: Annotations, split: Split, target: int, most: int, rng: np.random.Generator
) -> NDArray[np.int64]:
    """Rows of views that show a target well."""
    large = data.boxes[:, target, 2:].prod(axis=1) >= SMALLEST_CROP
    rows = np.flatnonzero(large & (data.states[:, target] == PRESENT) & ~split.views)
    return rows[:0] if split.targets[target] or not most else rng.permutation(rows)[:most]


def _states(data: Annotations, row: int, inside: NDArray[np.float32], kept: NDArray[np.float32]) -> NDArray[np.int8]:
    """(T,) what a copy of a view shows of the targets of its scene."""
    gone = (data.states[row] == ABSENT) | (kept == 0.0)
    enough = (kept >= LEAST_KEPT) & (inside[:, 2:].prod(axis=1) >= data.smallest_area)
    return np.where(gone, ABSENT, np.where(enough, PRESENT, IGNORE_INDEX)).astype(np.int8)


@torch.inference_mode()
def _prepared(images: Iterator[NDArray[np.uint8]], backbone: Backbone, prepare: Callable[[Tensor], Tensor]) -> Tensor:
    """Like `training.prepared`, from images and a batch at a time: their feature maps would fill the memory."""
    parts = [prepare(torch.from_numpy(backbone.maps(batch))).half() for batch in prefetch_batches(images, BATCH)]
    if not parts:
        shape = backbone.channels, backbone.map_size, backbone.map_size
        return prepare(torch.zeros(1, *shape)).half()[:0]
    return torch.cat(parts)
