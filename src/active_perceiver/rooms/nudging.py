"""Things that stand a hand's breadth from where they stood: what a day makes of a room in which people live."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from active_perceiver.errors import UserError
from active_perceiver.rooms.room import Part, Room

# Directions tried for a thing until it runs into nothing; where none is free, it stays.
TRIES = 12
# Boxes that overlap by no more than this may still be beside each other; metres.
TOUCH = 0.003


class NudgeError(UserError, ValueError):
    """A nudge that is none."""


def nudged(room: Room, most: float, seed: int) -> Room:
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
        raise NudgeError(f"things can be nudged by more than 0 and at most 0.5 m, got {most}")
    rng = np.random.default_rng([seed, 5])
    boxes = {name: _box(room, name) for name in dict.fromkeys(part.object_name for part in room.parts)}
    stays = {lamp.object_name for lamp in room.lamps}
    shifts: dict[str, NDArray[np.float64]] = {}
    for name in room.targets:
        others = [box for other, box in boxes.items() if other != name]
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


def _box(room: Room, name: str) -> NDArray[np.float64]:
    """Lowest and highest corner of a thing, (2, 3) metres."""
    points = np.concatenate([part.mesh.vertices for part in room.parts if part.object_name == name])
    return np.stack([points.min(axis=0), points.max(axis=0)]).astype(np.float64)


def _new_overlap(box: NDArray[np.float64], shift: NDArray[np.float64], others: list[NDArray[np.float64]]) -> bool:
    """Whether a thing would overlap something more that it did not overlap where it was."""
    return any(_overlap(box + shift, other) and not _overlap(box, other) for other in others)


def _overlap(one: NDArray[np.float64], other: NDArray[np.float64]) -> bool:
    return bool(((one[1] - TOUCH > other[0]) & (other[1] - TOUCH > one[0])).all())


def _inside(room: Room, box: NDArray[np.float64]) -> bool:
    return bool((box[0] >= -TOUCH).all() and (box[1] <= np.array(room.size) + TOUCH).all())


def _shifted(part: Part, shift: NDArray[np.float64] | None) -> Part:
    if shift is None:
        return part
    return replace(part, mesh=replace(part.mesh, vertices=part.mesh.vertices + shift))
