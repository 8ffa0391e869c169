"""A Room: parts (mesh, material, the object they belong to), lights, and where a robot may stand."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from indoor_rooms.geometry.mesh import Mesh
from indoor_rooms.materials.material import Material


@dataclass(frozen=True)
class Part:
    """One mesh of one material. Parts with the same `object_name` are one object in the instance mask."""

    object_name: str
    mesh: Mesh
    material: Material


@dataclass(frozen=True)
class Sun:
    """Parallel light: direction (3,) from the sun into the room, colour (3,) linear RGB, irradiance strength."""

    direction: tuple[float, float, float]
    colour: tuple[float, float, float]
    strength: float


@dataclass(frozen=True)
class Lamp:
    """An area light (a disc, a rectangle or a sphere) whose glowing mesh is also one of the room's parts.

    Attributes:
        object_name: name of the part that glows (it does not shadow its own light).
        centre: (3,) metres.
        edges: two (3,) edge vectors of a rectangle facing along their cross product, or None for a sphere.
        radius: sphere's radius in metres (ignored for a rectangle).
        radiance: (3,) linear RGB radiance.
    """

    object_name: str
    centre: tuple[float, float, float]
    edges: tuple[tuple[float, float, float], tuple[float, float, float]] | None
    radius: float
    radiance: tuple[float, float, float]


@dataclass(frozen=True)
class Room:
    """A furnished 3D room.

    Attributes:
        name: layout's name and seed, for example "kitchen_1".
        size: width (x), depth (y), height (z) in metres; the floor spans (0, 0) to (width, depth) at z = 0.
        parts: everything there is, walls included.
        targets: object name -> category, for the objects that can be searched.
        sun: direct sunlight, or None.
        sky: (3,) linear RGB radiance of what lies outside.
        lamps: area lights.
        obstacles: (label, polygon (K, 2)) pairs: what stands on the floor, seen from above, for free space and
            floor plan.
    """

    name: str
    size: tuple[float, float, float]
    parts: tuple[Part, ...]
    targets: dict[str, str]
    sun: Sun | None
    sky: tuple[float, float, float]
    lamps: tuple[Lamp, ...]
    obstacles: tuple[tuple[str, NDArray[np.float64]], ...]
