"""The object of a picture: put on a stage, with its front found, and shown from where its shape is seen."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from indoor_rooms.geometry.mesh import transform
from indoor_rooms.geometry.pieces import Pieces, bounds
from indoor_rooms.objects import OBJECTS
from indoor_rooms.room import Part
from indoor_rooms.studio.stage import OBJECT_RADIUS, Direction, Shot, aim

# Objects as flat as the first number (height by width) are photographed from above, those beyond the second upright.
FLAT, UPRIGHT = 0.15, 0.6
ELEVATIONS_OF_FLAT = (35.0, 75.0)
ELEVATIONS_OF_UPRIGHT = (10.0, 45.0)
# A generator makes several models of a thing; among this many there is likely one like that in the room.
EXAMPLES = 16


@dataclass(frozen=True)
class Subject:
    """An object at the origin of a stage.

    Attributes:
        name: of the object.
        category: its kind.
        parts: it, `OBJECT_RADIUS` large.
        scale: by which it was magnified.
        front: heading of a camera that looks at its front, degrees.
    """

    name: str
    category: str
    parts: tuple[Part, ...]
    scale: float
    front: float

    @property
    def points(self) -> NDArray[np.float64]:
        """(V, 3) its vertices."""
        return np.concatenate([part.mesh.vertices for part in self.parts])

    def shot(self, direction: Direction, fov: float, fill: float, **hand: Any) -> Shot:
        """A camera that sees it from a direction; `fov`, `fill` and `hand` as for `aim`."""
        low, high = _elevations(self.points)
        elevation = low + direction.rise * (high - low)
        return aim(self.points, self.front + direction.azimuth, elevation, fov, fill, **hand)


def on_stage(parts: Sequence[Part], name: str, category: str, turn: float = 0.0) -> Subject:
    """Scales an object's parts to `OBJECT_RADIUS` and stands it on the ground at the origin.

    Args:
        parts: of the object.
        name: of the object.
        category: its kind.
        turn: degrees by which all pictures of it are turned from its front.
    """
    low, high = bounds(part.mesh for part in parts)
    scale = 2 * OBJECT_RADIUS / float(np.linalg.norm(high - low))
    middle = (low + high) / 2
    # A hair above the ground: coplanar faces would flicker.
    offset = (-scale * middle[0], -scale * middle[1], -scale * low[2] + 2e-4)
    scaled = tuple(replace(part, mesh=transform(part.mesh, offset=offset, scale=scale)) for part in parts)
    return Subject(name, category, scaled, scale, turn - _turn(scaled, category))


def _turn(parts: Sequence[Part], category: str) -> float:
    """How far an object's front is turned from -y, degrees counter-clockwise; 0 for what no generator makes.

    Two objects of a generator have corresponding vertices: the turn that brings one's closest to the other's is it.
    """
    fits = [_fit(parts, example) for example in _examples(category)]
    _, turn = max(fits, key=lambda fit: fit[0], default=(0, 0.0))
    return turn


def _fit(parts: Sequence[Part], example: Pieces) -> tuple[int, float]:
    """How many vertices correspond, and the turn (degrees) from the example's to the parts'."""
    matching, across, along = 0, 0.0, 0.0
    for part, (mesh, _) in zip(parts, example, strict=False):
        if len(mesh.vertices) == len(part.mesh.vertices):
            (x, y), (seen_x, seen_y) = mesh.vertices[:, :2].T, part.mesh.vertices[:, :2].T
            matching += len(x)
            across += float((x * seen_y - y * seen_x).sum())
            along += float((x * seen_x + y * seen_y).sum())
    return matching, math.degrees(math.atan2(across, along))


@cache
def _examples(category: str) -> list[Pieces]:
    """Objects of a category, their middle at the origin; none if no generator makes such."""
    if category not in OBJECTS:
        return []
    examples = []
    for seed in range(EXAMPLES):
        pieces = OBJECTS[category](np.random.default_rng(seed))
        x, y, _ = bounds(mesh for mesh, _ in pieces).mean(axis=0)
        examples.append([(transform(mesh, (-x, -y, 0.0)), material) for mesh, material in pieces])
    return examples


def _elevations(points: NDArray[np.float64]) -> tuple[float, float]:
    """Between which elevations (degrees) an object shows its shape: what lies flat has to be seen from above."""
    width, depth, height = np.ptp(points, axis=0)
    uprightness = float(np.clip((height / max(width, depth) - FLAT) / (UPRIGHT - FLAT), 0, 1))
    low, high = (
        flat + uprightness * (upright - flat)
        for flat, upright in zip(ELEVATIONS_OF_FLAT, ELEVATIONS_OF_UPRIGHT, strict=True)
    )
    return low, high
