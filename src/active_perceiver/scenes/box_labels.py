"""Boxes put into a scene view by view: what comes back from a labelling tool or page."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike

from active_perceiver.scenes.image_files import ImageError
from active_perceiver.scenes.images import image_suffix
from active_perceiver.scenes.scene import LABELLED, UNLABELLED, Scene, SceneError


def with_boxes(scene: Scene, boxes_by_view: Mapping[int, ArrayLike], state: int = LABELLED) -> Scene:
    """The scene with other boxes in some views; the other views stay as they are.

    Args:
        scene: is not changed.
        boxes_by_view: for a view's index its (T, 4) boxes: centre x, centre y, width, height as fractions of the
            image, NaN where a target is not visible.
        state: what is known of these views now: `LABELLED`, `PROPOSED`, or `UNLABELLED` (all their boxes are NaN).

    Raises:
        SceneError: if the scene has no such view, or the boxes are not sound.
    """
    boxes = scene.boxes.copy()
    labels = np.full(len(scene), LABELLED, np.uint8) if scene.labels is None else scene.labels.copy()
    for view, given in boxes_by_view.items():
        if not 0 <= view < len(scene):
            raise SceneError(f"scene '{scene.name}' has {len(scene)} views, none has the number {view}")
        array = np.asarray(given, np.float32)
        if array.shape != boxes.shape[1:]:
            raise SceneError(
                f"the boxes of view {view} have shape {array.shape}, expected {boxes.shape[1:]}: one box for each "
                f"target of scene '{scene.name}'"
            )
        boxes[view] = array
        labels[view] = state
    # None, "all are labelled", and an array that says so are the same; files stay as they were without need.
    return replace(scene, boxes=boxes, labels=None if (labels == LABELLED).all() else labels)


def label_states(scene: Scene) -> np.ndarray:
    """(S,) uint8, `Scene.labels` with None written out."""
    return np.full(len(scene), LABELLED, np.uint8) if scene.labels is None else scene.labels


def labelled_views(scene: Scene) -> np.ndarray:
    """(S,) bool, the views whose boxes are known, be it only by proposals."""
    return label_states(scene) != UNLABELLED


def view_file_names(scene: Scene) -> tuple[str, ...]:
    """The name of each view's image file in a folder made by `scenes export coco`.

    Raises:
        SceneError: if a view is no image that such a folder can hold.
    """
    names = []
    for state, view in enumerate(scene.views):
        try:
            names.append(f"view_{state:05d}.{image_suffix(view)}")
        except ImageError as error:
            raise SceneError(f"view {state} of scene '{scene.name}': {error}") from None
    return tuple(names)
