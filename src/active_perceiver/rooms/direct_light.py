"""Light that comes straight from the sun and the lamps, with soft shadows."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from active_perceiver.rooms.compiled import Surfaces
from active_perceiver.rooms.raycast import SURFACE_OFFSET
from active_perceiver.rooms.room import Lamp, Room
from active_perceiver.rooms.vectors import dot, tangents, unit

# Half the angle under which the sun is seen, a little wider than the real 0.27 degrees: softer edges. Radians.
SUN_RADIUS = 0.008
# The edges of sun patches are the sharpest shadows in a room and need more than one sample.
SUN_SAMPLES = 2
# Light weaker than this is not worth a shadow ray.
FAINTEST = 1e-4


@dataclass(frozen=True, eq=False)
class LightSample:
    """One light's contribution at some points.

    Attributes:
        index: (M,) the points this light reaches.
        direction: (M, 3) float32 unit vectors towards the light.
        irradiance: (M, 3) float32, cosine included.
    """

    index: NDArray[np.int64]
    direction: NDArray[np.float32]
    irradiance: NDArray[np.float32]


def light_samples(
    room: Room,
    surfaces: Surfaces,
    points: NDArray[np.float32],
    normals: NDArray[np.float32],
    rng: np.random.Generator,
) -> Iterator[LightSample]:
    """Sample each light of the room for each point, shadow rays included.

    Args:
        room: whose lights.
        surfaces: what throws shadows.
        points: (N, 3) metres.
        normals: (N, 3) unit vectors.
        rng: which spot of a lamp a point looks at.
    """
    origins = points + normals * SURFACE_OFFSET
    if room.sun is not None and room.sun.strength > 0:
        towards = -np.asarray(room.sun.direction, np.float32)
        towards /= np.linalg.norm(towards)
        strength = np.maximum(dot(normals, towards[None]), 0) * (room.sun.strength / SUN_SAMPLES)
        colour = np.asarray(room.sun.colour, np.float32)
        for _ in range(SUN_SAMPLES):
            directions = unit(towards + SUN_RADIUS * rng.standard_normal((len(points), 3), np.float32))
            yield _shadowed(surfaces, origins, directions, strength, colour, None)
    for lamp in room.lamps:
        spots, area, facing = _lamp_spots(lamp, points, rng)
        offset = spots - origins
        distance = np.maximum(np.sqrt(dot(offset, offset)), 1e-3)
        directions = unit(offset)
        cosine = np.maximum(dot(normals, directions), 0)
        if facing is not None:
            cosine = cosine * np.maximum(-dot(directions, facing[None]), 0)
        # No lamp gives more than one that fills the whole sky: what almost touches one would sparkle.
        strength = np.minimum(cosine * area / distance**2, np.pi)
        colour = np.asarray(lamp.radiance, np.float32)
        yield _shadowed(surfaces, origins, directions, strength, colour, distance * 0.999)


def direct_irradiance(
    room: Room,
    surfaces: Surfaces,
    points: NDArray[np.float32],
    normals: NDArray[np.float32],
    rng: np.random.Generator,
    samples: int = 1,
) -> NDArray[np.float32]:
    """Irradiance (N, 3) from the sun and the lamps, averaged over some samples of each light."""
    total = np.zeros((len(points), 3), np.float32)
    for _ in range(samples):
        for light in light_samples(room, surfaces, points, normals, rng):
            total[light.index] += light.irradiance / samples
    return total


def _lamp_spots(
    lamp: Lamp, points: NDArray[np.float32], rng: np.random.Generator
) -> tuple[NDArray[np.float32], float, NDArray[np.float32] | None]:
    """A random spot of the lamp for each point, the area it stands for, and the way the lamp faces (None: all)."""
    centre = np.asarray(lamp.centre, np.float32)
    if lamp.edges is not None:
        first, second = (np.asarray(edge, np.float32) for edge in lamp.edges)
        share = rng.random((len(points), 2), np.float32) - 0.5
        across = np.cross(first, second)
        area = float(np.linalg.norm(across))
        return centre + share[:, :1] * first + share[:, 1:] * second, area, across / area
    # A sphere looks like a disc from everywhere: sample the disc that faces the point.
    side, other = tangents(unit(points - centre))
    radius = lamp.radius * np.sqrt(rng.random(len(points), np.float32))
    angle = 2 * np.pi * rng.random(len(points), np.float32)
    spots = centre + side * (radius * np.cos(angle))[:, None] + other * (radius * np.sin(angle))[:, None]
    return spots.astype(np.float32), np.pi * lamp.radius**2, None


def _shadowed(
    surfaces: Surfaces,
    origins: NDArray[np.float32],
    directions: NDArray[np.float32],
    strength: NDArray[np.floating],
    colour: NDArray[np.float32],
    distance: NDArray[np.floating] | None,
) -> LightSample:
    index = np.flatnonzero(strength * colour.max() > FAINTEST)
    reach = None if distance is None else distance[index]
    lit = ~surfaces.shadow_caster.occluded(origins[index], directions[index], reach)
    index = index[lit]
    return LightSample(index, directions[index], (strength[index, None] * colour).astype(np.float32))
