"""What a scene is: views on a pose lattice, the moves between them, and the targets that can be searched."""

from __future__ import annotations

import hashlib
from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from active_perceiver.errors import UserError
from active_perceiver.scenes.floor_plan import FloorPlan
from active_perceiver.scenes.images import decode_image
from active_perceiver.scenes.lattice import Action

UNLABELLED, PROPOSED, LABELLED = 0, 1, 2
"""What is known of a view's boxes: nothing, so that none are there; a recogniser drew them; a person, or whoever made
the scene, says so."""

# A box may stick out of the image by rounding, not more.
BOX_TOLERANCE = 1e-4


class SceneError(UserError, ValueError):
    """A scene that is not sound; the message says what is wrong and what to do."""


def _check_text(text: str, what: str) -> None:
    """Refuse what cannot be written into a file, or would spoil what is printed."""
    if len(text) > 1000 or any(ord(sign) < 32 or 0xD800 <= ord(sign) < 0xE000 for sign in text):
        raise SceneError(f"the {what} is too long or holds characters that are no text: {text!r:.80}")


@dataclass(frozen=True)
class Target:
    """An object that can be searched.

    Attributes:
        name: unique in its scene.
        pictures: encoded images of the object on its own, without context.
        category: what kind of thing it is, for example "mug".
        held_out: the last so many of the pictures are never trained with: by them is measured how well an agent does
            with a picture that it has not seen.
    """

    name: str
    pictures: tuple[bytes, ...]
    category: str = ""
    held_out: int = 0

    def __post_init__(self) -> None:
        if self.name in ("", ".", "..") or "/" in self.name:
            raise SceneError(f"a target's name must not be empty, a dot or two, or hold a slash: {self.name!r:.80}")
        _check_text(self.name, "name of a target")
        _check_text(self.category, f"category of target '{self.name}'")
        if not self.pictures:
            raise SceneError(f"target '{self.name}' has no picture; a target is searched from its picture")
        if not 0 <= self.held_out < len(self.pictures):
            raise SceneError(
                f"target '{self.name}' holds out {self.held_out} of its {len(self.pictures)} pictures; at least one "
                "must be left to train with, so it is a number from 0 to one less than there are"
            )

    @property
    def trained(self) -> int:
        """How many of the pictures, the first ones, training may use."""
        return len(self.pictures) - self.held_out

    def picture(self, index: int = 0) -> NDArray[np.uint8]:
        """Decode one picture, (H, W, 3) uint8 RGB."""
        return decode_image(self.pictures[index], f"picture {index} of target '{self.name}'")


@dataclass(frozen=True, eq=False)
class Scene:
    """A room cut into a finite set of robot states, each with one image (the paper, section III).

    Attributes:
        name: for example "kitchen_1".
        actions: the columns of `transitions`.
        views: (S,) encoded images; decoded when asked for, see `view`.
        poses: (S, 4) float32: x, z in metres, heading and tilt in degrees.
        transitions: (S, A) int32, the next state; the state's own index where the move is blocked.
        boxes: (S, T, 4) float32: centre x, centre y, width, height as fractions of the image; NaN where not
            visible.
        targets: (T,) what can be searched, in the order of `boxes`; none if nobody marked an object, so that only the
            scene's own views can be searched for.
        image_size: side of the (square) views in pixels.
        fov: the camera's field of view in degrees.
        source: where the scene comes from, one line.
        floor_plan: the room from above, if known.
        labels: (S,) uint8, what is known of each view's boxes: `UNLABELLED`, `PROPOSED` or `LABELLED`; None if all
            are labelled.
    """

    name: str
    actions: tuple[Action, ...]
    views: Sequence[bytes]
    poses: NDArray[np.float32]
    transitions: NDArray[np.int32]
    boxes: NDArray[np.float32]
    targets: tuple[Target, ...]
    image_size: int = 300
    fov: float = 75.0
    source: str = ""
    floor_plan: FloorPlan | None = field(default=None, repr=False)
    labels: NDArray[np.uint8] | None = field(default=None, repr=False)

    def __post_init__(self) -> None:
        _check_text(self.name, "name of a scene")
        _check_text(self.source, f"source of scene '{self.name}'")
        states, names = len(self.views), self.target_names
        if states == 0:
            raise SceneError(f"scene '{self.name}' has no views")
        if len(set(names)) != len(names):
            raise SceneError(f"scene '{self.name}' names a target twice: {sorted(names)}")
        if not 1 <= self.image_size <= 10_000 or not 0 < self.fov < 360:
            raise SceneError(
                f"scene '{self.name}' has image_size {self.image_size} and fov {self.fov}; they must be 1 to 10000 "
                "pixels and more than 0 and less than 360 degrees"
            )
        if not self.actions or len(set(self.actions)) != len(self.actions):
            raise SceneError(f"scene '{self.name}' has no action, or one twice")
        shapes = {
            "poses": (self.poses, (states, 4)),
            "transitions": (self.transitions, (states, len(self.actions))),
            "boxes": (self.boxes, (states, len(names), 4)),
        }
        for label, (array, shape) in shapes.items():
            if array.shape != shape:
                raise SceneError(f"scene '{self.name}': {label} has shape {array.shape}, expected {shape}")
        if not np.isfinite(self.poses).all():
            bad = int((~np.isfinite(self.poses)).any(1).sum())
            raise SceneError(f"scene '{self.name}': {bad} poses are not finite numbers")
        if self.transitions.min() < 0 or self.transitions.max() >= states:
            raise SceneError(f"scene '{self.name}': transitions lead outside the {states} states")
        self._check_labels()
        self._check_boxes()

    def _check_labels(self) -> None:
        if self.labels is None:
            return
        if (
            self.labels.shape != (len(self.views),)
            or not np.isin(self.labels, (UNLABELLED, PROPOSED, LABELLED)).all()
        ):
            raise SceneError(
                f"scene '{self.name}': labels must be {len(self.views)} numbers, each {UNLABELLED} (unlabelled), "
                f"{PROPOSED} (proposed) or {LABELLED} (labelled)"
            )
        if not np.isnan(self.boxes[self.labels == UNLABELLED]).all():
            raise SceneError(f"scene '{self.name}' has boxes in views that are said to be unlabelled")

    def _check_boxes(self) -> None:
        missing = np.isnan(self.boxes)
        if (missing.any(-1) != missing.all(-1)).any():
            raise SceneError(f"scene '{self.name}': a box is either all NaN (not visible) or no NaN at all")
        if np.isinf(self.boxes).any():
            raise SceneError(f"scene '{self.name}': some boxes are infinite")
        boxes = self.boxes[~missing.any(-1)]
        low, high = boxes[:, :2] - boxes[:, 2:] / 2, boxes[:, :2] + boxes[:, 2:] / 2
        if (low < -BOX_TOLERANCE).any() or (high > 1 + BOX_TOLERANCE).any() or (boxes[:, 2:] <= 0).any():
            raise SceneError(
                f"scene '{self.name}': boxes must lie in 0..1 as fractions of the image (centre x, centre y, "
                "width, height) and have a positive size; pixels or corners were given?"
            )

    def __len__(self) -> int:
        return len(self.views)

    @property
    def target_names(self) -> tuple[str, ...]:
        """Names of the targets in the order of `boxes`."""
        return tuple(target.name for target in self.targets)

    @cached_property
    def areas(self) -> NDArray[np.float32]:
        """(S, T) box areas as fractions of the image; 0 where the target is not visible."""
        return np.nan_to_num(self.boxes[..., 2] * self.boxes[..., 3], nan=0.0)

    @cached_property
    def content_hash(self) -> str:
        """Hex digest of the views: the key of everything computed from them alone."""
        digest = hashlib.sha256()
        for view in self.views:
            digest.update(hashlib.sha256(view).digest())
        return digest.hexdigest()[:24]

    @cached_property
    def positions(self) -> NDArray[np.int64]:
        """(S,) index of each state's place: states that differ only in heading and tilt share it."""
        return np.unique(np.round(self.poses[:, :2], 3), axis=0, return_inverse=True)[1].ravel()

    def view(self, state: int) -> NDArray[np.uint8]:
        """Decode one state's image, (H, W, 3) uint8 RGB."""
        return decode_image(self.views[state], f"view {state} of scene '{self.name}'")

    def require_targets(self) -> None:
        """Make sure that there are objects to search for.

        Raises:
            SceneError: if there are none.
        """
        if not self.targets:
            raise SceneError(f"scene '{self.name}' has no objects to search for, only views: use --task view")

    def target_index(self, name: str) -> int:
        """Index of a target by name.

        Raises:
            SceneError: if the scene has no such target; the message lists those it has.
        """
        self.require_targets()
        if name not in self.target_names:
            known = ", ".join(self.target_names)
            raise SceneError(f"scene '{self.name}' has no target '{name}'; it has {known}")
        return self.target_names.index(name)
