"""The objects of an AI2-THOR room as targets: which there are, where a view shows them, and pictures of them alone.

An object is in a view if the instance segmentation says so. AI2-THOR's `visible` is something else: within reach of
the agent's arm (1.5 m, https://ai2thor.allenai.org/ithor/documentation/environment-state/).
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from active_perceiver.robots.ai2thor import ThorError, event_image
from active_perceiver.scenes.image_modes import TRANSPARENT_BACKGROUND

# An object that covers less of the view than this counts as not visible, as in the bundled scenes.
SMALLEST_VISIBLE = 0.0005
PICTURES = 12
"""As many pictures of a target at most; every third one is held out."""
# A clean view shows the object at least so large (the longer side, fraction of the view), ...
SMALLEST_CLEAN = 0.08
# ... and with as much of its box filled as in most views from near, where it is hidden least.
LEAST_FILLED = 0.85
# Around a picture's object, as a fraction of its longer side.
MARGIN = 0.1


class NoTargetsError(ThorError):
    """A room that has nothing of what is asked for."""


@dataclass(frozen=True)
class Instance:
    """An object of a room.

    Attributes:
        name: of the target: the type, or type and number ("Mug_1", "Mug_2") where there are several.
        object_id: AI2-THOR's name for it, such as "Mug|-01.76|+00.90|-00.62".
        category: AI2-THOR's type.
    """

    name: str
    object_id: str
    category: str


@dataclass(frozen=True, eq=False)
class InstanceViews:
    """Where one view, or each of several, shows the instances.

    Attributes:
        boxes: (..., T, 4) float32 centre x, centre y, width, height as fractions of the view; NaN where not visible.
        filled: (..., T) float32, the part of each box that belongs to the object; 0 where not visible.
    """

    boxes: NDArray[np.float32]
    filled: NDArray[np.float32]


def room_instances(
    objects: Iterable[Mapping[str, Any]], types: Sequence[str], *, all_types: bool
) -> tuple[Instance, ...]:
    """The objects that will be targets.

    Args:
        objects: `event.metadata["objects"]`.
        types: AI2-THOR's object types; all that an agent could pick up if empty.
        all_types: whether each of the types must be there.

    Returns:
        Sorted by type in the order given, then by AI2-THOR's name, so that numbers stay the same.

    Raises:
        NoTargetsError: if a type, or all of them, are not in the room; the message lists those that are.
    """
    known = [(str(entry["objectType"]), str(entry["objectId"])) for entry in objects]
    wanted = list(dict.fromkeys(types)) or sorted(
        {str(entry["objectType"]) for entry in objects if entry.get("pickupable")}
    )
    there = {kind for kind, _ in known}
    missing = [kind for kind in wanted if kind not in there]
    if (missing and all_types) or len(missing) == len(wanted):
        lacks, has = ", ".join(missing) or "objects to pick up", ", ".join(sorted(there))
        raise NoTargetsError(f"this room of AI2-THOR has no {lacks}; it has {has}")
    counts = Counter(kind for kind, _ in known)
    return tuple(
        Instance(kind if counts[kind] == 1 else f"{kind}_{number}", object_id, kind)
        for kind in wanted
        for number, object_id in enumerate(sorted(name for one, name in known if one == kind), 1)
    )


def instance_views(event: Any, instances: Sequence[Instance]) -> InstanceViews:
    """Where an event's view shows the instances, exactly: a box bounds the pixels that belong to the object.

    Raises:
        ThorError: if the event has no instance segmentation.
    """
    detections = event.instance_detections2D
    if detections is None:
        raise ThorError("AI2-THOR sent no instance segmentation; start it with renderInstanceSegmentation=True")
    height, width = event_image(event).shape[:2]
    boxes = np.full((len(instances), 4), np.nan, np.float32)
    filled = np.zeros(len(instances), np.float32)
    for row, instance in enumerate(instances):
        if instance.object_id not in detections:
            continue
        pixels = int(np.count_nonzero(event.instance_masks[instance.object_id]))
        if pixels < max(1.0, SMALLEST_VISIBLE * width * height):
            continue
        # Corners in pixels, the last ones included.
        left, top, right, bottom = detections[instance.object_id]
        across, down = right + 1 - left, bottom + 1 - top
        boxes[row] = (left + across / 2) / width, (top + down / 2) / height, across / width, down / height
        filled[row] = pixels / (across * down)
    return InstanceViews(boxes, filled)


def picture_states(
    boxes: NDArray[np.float32], filled: NDArray[np.float32], places: NDArray[np.integer], image_size: int
) -> tuple[list[int], bool]:
    """The views that one object's pictures are best cut out of: from different places, the largest first.

    Clean is a view that shows the object large, not cut by the view's border, and, as far as one can tell from how
    much of its box it fills, with nothing in front of it.

    Args:
        boxes: (S, 4) the object in each view, NaN where not visible.
        filled: (S,) see `InstanceViews`.
        places: (S,) number of each view's place.
        image_size: side of the views in pixels.

    Returns:
        Up to `PICTURES` states, none if it is never visible; and whether they are clean. If no view is, it is the one
        that shows it largest, uncut if there is such a one.
    """
    visible = ~np.isnan(boxes).any(-1)
    if not visible.any():
        return [], False
    area = np.where(visible, boxes[:, 2] * boxes[:, 3], 0)
    edge = 1.5 / image_size
    with np.errstate(invalid="ignore"):
        low, high = boxes[:, :2] - boxes[:, 2:] / 2, boxes[:, :2] + boxes[:, 2:] / 2
        uncut = visible & (low > edge).all(-1) & (high < 1 - edge).all(-1)
        clean = uncut & (boxes[:, 2:].max(-1) >= SMALLEST_CLEAN)
    if clean.any():
        near = clean & (area >= np.median(area[clean]))
        clean &= filled >= LEAST_FILLED * np.median(filled[near])
    if not clean.any():
        among = uncut if uncut.any() else visible
        return [int(np.where(among, area, 0).argmax())], False
    by_size = [int(state) for state in np.argsort(-area, kind="stable") if clean[state]]
    first_of_place = {int(places[state]): state for state in reversed(by_size)}
    return [state for state in by_size if first_of_place[int(places[state])] == state][:PICTURES], True


def training_first(pictures: Sequence[bytes]) -> tuple[tuple[bytes, ...], int]:
    """Pictures in the order of a target, and how many are held out: every third, so that both have large ones."""
    held_out = list(pictures[2::3])
    trained = [picture for number, picture in enumerate(pictures) if number % 3 != 2]
    return (*trained, *held_out), len(held_out)


def object_picture(event: Any, instance: Instance) -> NDArray[np.uint8] | None:
    """The object of an event's view alone: cut out square, with a margin, on plain light grey; None if not visible.

    What belongs to the object the instance segmentation says to the pixel.
    """
    if event.instance_detections2D is None or instance.object_id not in event.instance_detections2D:
        return None
    left, top, right, bottom = event.instance_detections2D[instance.object_id]
    mask = np.asarray(event.instance_masks[instance.object_id])[top : bottom + 1, left : right + 1]
    alone = np.where(mask[..., None], event_image(event)[top : bottom + 1, left : right + 1], TRANSPARENT_BACKGROUND)
    down, across = mask.shape
    side = max(down, across) + 2 * int(np.ceil(MARGIN * max(down, across)))
    picture = np.full((side, side, 3), TRANSPARENT_BACKGROUND, np.uint8)
    above, before = (side - down) // 2, (side - across) // 2
    picture[above : above + down, before : before + across] = alone
    return picture
