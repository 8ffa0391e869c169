"""What is known of one view: which targets are in it and where, and who says so."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from active_perceiver.errors import UserError
from active_perceiver.scenes.box_labels import label_states, with_boxes
from active_perceiver.scenes.scene import BOX_TOLERANCE, LABELLED, PROPOSED, UNLABELLED, Scene

Box = tuple[float, float, float, float]
"""Centre x, centre y, width, height as fractions of the image, each a float32 number."""

LABEL_NAMES = ("unlabelled", "proposed", "labelled")
"""The names of the numbers in `Scene.labels`."""


class LabelError(UserError, ValueError):
    """Labels that make no sense, or that cannot be kept; the message says what is wrong and what to do."""


@dataclass(frozen=True)
class ViewLabels:
    """What is known of one view.

    Attributes:
        label: `UNLABELLED`, `PROPOSED` or `LABELLED`, see `Scene.labels`.
        boxes: of the targets that are visible, by name; none if the view is unlabelled.
    """

    label: int
    boxes: Mapping[str, Box]

    def as_json(self) -> dict[str, Any]:
        """Plain data for a JSON file."""
        return {"label": LABEL_NAMES[self.label], "boxes": {name: list(box) for name, box in self.boxes.items()}}

    @classmethod
    def from_json(cls, value: object, targets: Collection[str]) -> ViewLabels:
        """Read what `as_json` gives, from someone who may have sent anything.

        Args:
            value: parsed JSON.
            targets: names that boxes may have.

        Raises:
            LabelError: if it is anything else, or a box does not lie in the image.
        """
        if not isinstance(value, dict) or value.keys() != {"label", "boxes"} or not isinstance(value["boxes"], dict):
            raise LabelError("what is known of a view are its `label` and its `boxes`")
        if value["label"] not in LABEL_NAMES:
            raise LabelError(f"the label of a view is one of {', '.join(LABEL_NAMES)}, not {value['label']!r}")
        if unknown := sorted(value["boxes"].keys() - set(targets)):
            raise LabelError(f"there are boxes of {', '.join(map(repr, unknown))}, which the scene does not know")
        label = LABEL_NAMES.index(value["label"])
        if label == UNLABELLED and value["boxes"]:
            raise LabelError("a view that is unlabelled has no boxes; it is `proposed` or `labelled`")
        return cls(label, {name: _checked_box(name, box) for name, box in value["boxes"].items()})


def _checked_box(name: str, value: object) -> Box:
    if not isinstance(value, list) or len(value) != 4 or not all(type(number) in (int, float) for number in value):
        raise LabelError(f"the box of '{name}' must be four numbers, got {value!r}")
    # What is no number or too large for float32 is as wrong as 2.
    box = np.array([number if abs(number) < 2 else 2.0 for number in value], np.float32)
    low, high = box[:2] - box[2:] / 2, box[:2] + box[2:] / 2
    if low.min() < -BOX_TOLERANCE or high.max() > 1 + BOX_TOLERANCE or box[2:].min() <= 0:
        raise LabelError(
            f"the box of '{name}' must lie in the image: centre x, centre y, width and height as fractions of it, "
            f"got {value!r}"
        )
    return as_box(box)


def as_box(numbers: np.ndarray) -> Box:
    """Four numbers, rounded to float32, which is what a scene file keeps."""
    x, y, width, height = (float(number) for number in numbers.astype(np.float32))
    return x, y, width, height


def labels_of(scene: Scene) -> list[ViewLabels]:
    """What a scene says of each of its views."""
    return [
        ViewLabels(
            int(label),
            {name: as_box(box) for name, box in zip(scene.target_names, boxes, strict=True) if not np.isnan(box[0])},
        )
        for label, boxes in zip(label_states(scene), scene.boxes, strict=True)
    ]


def with_labels(scene: Scene, changes: Mapping[int, ViewLabels]) -> Scene:
    """The scene with other labels of some views, by number; all else, to the last bit, is as it was.

    Raises:
        SceneError: if there is no such view or target.
    """
    for state in (UNLABELLED, PROPOSED, LABELLED):
        boxes = {view: _rows(scene, known) for view, known in changes.items() if known.label == state}
        scene = with_boxes(scene, boxes, state)
    return scene


def _rows(scene: Scene, known: ViewLabels) -> np.ndarray:
    """(T, 4) boxes of a view as a scene has them."""
    boxes = np.full((len(scene.targets), 4), np.nan, np.float32)
    for name, box in known.boxes.items():
        boxes[scene.target_index(name)] = box
    return boxes
