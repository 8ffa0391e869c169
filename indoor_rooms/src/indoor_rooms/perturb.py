"""Things that stand a hand's breadth from where they stood: what a day makes of a room in which people live."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from indoor_rooms.errors import RoomError
from indoor_rooms.room import Part, Room

# Directions tried for a thing until it runs into nothing; where none is free, it stays.
TRIES = 12
# Boxes that overlap by no more than this may still be beside each other; metres.
TOUCH = 0.003


class PerturbError(RoomError, ValueError):
    """A nudge that is none."""


def perturbed(room: Room, most: float, seed: int) -> Room:
    """A room whose targets are moved a little, each in a direction of its own, level, and not into each other.

    A thing may hang over the edge of what it stands on. What hangs on a wall, or is a lamp, stays where it is, for it
    would leave the wall, or its light.

    Args:
        room: the room.
        most: metres; each thing is moved by between half of it and all of it.
        seed: directions and distances follow from it.

    Raises:
        NudgeError: if `most` is not above 0 and at most half a metre.
    """
    if not 0 < most <= 0.5:
        raise PerturbError(f"things can be nudged by more than 0 and at most 0.5 m, got {most}")
    rng = np.random.default_rng([seed, 5])
    boxes = _boxes(room)
    stays = {lamp.object_name for lamp in room.lamps}
    shifts: dict[str, NDArray[np.float64]] = {}
    for name in room.targets:
        others = np.stack([box for other, box in boxes.items() if other != name])
        for angle, share in zip(rng.uniform(0, 2 * math.pi, TRIES), rng.uniform(0.5, 1, TRIES), strict=True):
            shift = share * most * np.array([math.sin(angle), math.cos(angle), 0.0])
            if (
                name not in stays
                and not _new_overlap(boxes[name], shift, others)
                and _inside(room, boxes[name] + shift)
            ):
                shifts[name] = shift
                boxes[name] = boxes[name] + shift
                break
    parts = tuple(_shifted(part, shifts.get(part.object_name)) for part in room.parts)
    obstacles = tuple(
        (label, polygon + shifts[label][:2] if label in shifts else polygon) for label, polygon in room.obstacles
    )
    return replace(room, parts=parts, obstacles=obstacles)


def _boxes(room: Room) -> dict[str, NDArray[np.float64]]:
    """Lowest and highest corner of each thing, (2, 3) metres."""
    boxes: dict[str, NDArray[np.float64]] = {}
    for part in room.parts:
        points = part.mesh.vertices
        box = np.stack([points.min(axis=0), points.max(axis=0)])
        known = boxes.get(part.object_name, box)
        boxes[part.object_name] = np.stack([np.minimum(box[0], known[0]), np.maximum(box[1], known[1])])
    return boxes


def _new_overlap(box: NDArray[np.float64], shift: NDArray[np.float64], others: NDArray[np.float64]) -> bool:
    """Whether a thing would overlap something more that it did not overlap where it was."""
    return bool((_overlaps(box + shift, others) & ~_overlaps(box, others)).any())


def _overlaps(box: NDArray[np.float64], others: NDArray[np.float64]) -> NDArray[np.bool_]:
    """(N,) which of (N, 2, 3) other boxes a box overlaps."""
    return ((box[1] - TOUCH > others[:, 0]) & (others[:, 1] - TOUCH > box[0])).all(axis=1)


def _inside(room: Room, box: NDArray[np.float64]) -> bool:
    return bool((box[0] >= -TOUCH).all() and (box[1] <= np.array(room.size) + TOUCH).all())


def _shifted(part: Part, shift: NDArray[np.float64] | None) -> Part:
    if shift is None:
        return part
    return replace(part, mesh=replace(part.mesh, vertices=part.mesh.vertices + shift))
