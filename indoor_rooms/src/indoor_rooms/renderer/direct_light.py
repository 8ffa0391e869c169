"""Light that comes straight from the sun and the lamps, with soft shadows."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from indoor_rooms.renderer.compiled import Surfaces
from indoor_rooms.renderer.raycast import SURFACE_OFFSET
from indoor_rooms.renderer.sunlight import SUN_RADIUS, SunShafts
from indoor_rooms.renderer.vectors import columns, dot, rows, tangents, unit
from indoor_rooms.room import Room

# The edges of sun patches are the sharpest shadows in a room and need more than one sample.
SUN_SAMPLES = 2
# Lamps asked by each point of a picture.
LAMP_SAMPLES = 1
# A lamp is asked at least this often for its light, relative to a lamp that is known to be in full view.
LEAST_VISIBLE = 0.07
# Light weaker than this is not worth a shadow ray.
FAINTEST = 1e-4


@dataclass(frozen=True, eq=False)
class LightSample:
    """Light that reaches some points.

    Attributes:
        index: (M,) the points.
        direction: (M, 3) float32 unit vectors towards the light.
        irradiance: (M, 3) float32, cosine included.
    """

    index: NDArray[np.int64]
    direction: NDArray[np.float32]
    irradiance: NDArray[np.float32]


class Lights:
    """The sun and the lamps of a room, ready to be sampled.

    Args:
        room: whose lights.
        surfaces: what throws shadows.
    """

    def __init__(self, room: Room, surfaces: Surfaces) -> None:
        lamps = room.lamps
        self.lamp_count = len(lamps)
        self._surfaces = surfaces
        self._centre = np.array([lamp.centre for lamp in lamps], np.float32).reshape(-1, 3)
        edges = [lamp.edges or ((0.0, 0.0, 0.0), (0.0, 0.0, 0.0)) for lamp in lamps]
        self._edges = np.array(edges, np.float32).reshape(-1, 2, 3)
        across = np.cross(self._edges[:, 0], self._edges[:, 1])
        area = np.linalg.norm(across, axis=1)
        self._round = np.array([lamp.edges is None for lamp in lamps], bool)
        self._facing = across / np.maximum(area, 1e-12)[:, None]
        self._radius = np.array([lamp.radius for lamp in lamps], np.float32)
        # A sphere looks like a disc from everywhere.
        self._area = np.where(self._round, np.pi * self._radius**2, area).astype(np.float32)
        self._radiance = np.array([lamp.radiance for lamp in lamps], np.float32).reshape(-1, 3)
        self._brightest = self._radiance.max(axis=1, initial=0)
        self._reach = np.where(
            self._round, self._radius, np.linalg.norm(self._edges, axis=2).max(axis=1, initial=0) / 2
        )
        self._sun = SunShafts(room.sun, surfaces) if room.sun is not None and room.sun.strength > 0 else None

    def sunlight(
        self, points: NDArray[np.float32], normals: NDArray[np.float32], rng: np.random.Generator
    ) -> Iterator[LightSample]:
        """Sun at points (N, 3) with unit normals (N, 3), in `SUN_SAMPLES` parts."""
        if self._sun is None:
            return
        sun = self._sun
        cosine = dot(normals, sun.towards[None])
        near = np.flatnonzero((cosine > 0) & sun.may_reach(points))
        origins = rows(points, near) + rows(normals, near) * SURFACE_OFFSET
        irradiance = columns(*(np.maximum(cosine[near], 0) * value for value in sun.irradiance / SUN_SAMPLES))
        for _ in range(SUN_SAMPLES):
            directions = unit(sun.towards + SUN_RADIUS * _normal_triples(len(near), rng))
            lit = np.flatnonzero(~self._surfaces.shadow_caster.occluded(origins, directions))
            yield LightSample(near[lit], rows(directions, lit), rows(irradiance, lit))

    def lamplight(
        self,
        lamp: NDArray[np.int64],
        points: NDArray[np.float32],
        normals: NDArray[np.float32],
        rng: np.random.Generator,
        weight: NDArray[np.float32] | None = None,
    ) -> LightSample:
        """One sample of one lamp for each point.

        Args:
            lamp: (N,) which lamp.
            points: (N, 3) metres.
            normals: (N, 3) unit vectors.
            rng: which spot of a lamp a point looks at.
            weight: (N,) factors of the light; None for 1.
        """
        origins = points + normals * SURFACE_OFFSET
        offset = self._spots(lamp, points, rng)
        offset -= origins
        squared = np.maximum(dot(offset, offset), np.float32(1e-6))
        distance = np.sqrt(squared)
        offset *= (1 / distance)[:, None]
        strength = np.maximum(dot(normals, offset), 0)
        faces = np.maximum(-dot(rows(self._facing, lamp), offset), 0)
        strength *= np.where(self._round[lamp], np.float32(1), faces)
        strength *= self._area[lamp] / squared
        # No lamp gives more than one that fills the whole sky: what almost touches one would sparkle.
        strength = np.minimum(strength, np.float32(np.pi))
        index = np.flatnonzero(strength * self._brightest[lamp] > FAINTEST)
        reach = distance[index] * np.float32(0.999)
        hidden = self._surfaces.shadow_caster.occluded(rows(origins, index), rows(offset, index), reach)
        index = index[~hidden]
        if weight is not None:
            strength *= weight
        irradiance = rows(self._radiance, lamp[index]) * strength[index][:, None]
        return LightSample(index, rows(offset, index), irradiance)

    def choose_lamps(
        self,
        points: NDArray[np.float32],
        normals: NDArray[np.float32],
        visible: NDArray[np.float32],
        draws: NDArray[np.float32],
    ) -> tuple[NDArray[np.int64], NDArray[np.float32]]:
        """For each point one lamp, with a probability in proportion to the light expected of it.

        Args:
            points: (N, 3) metres.
            normals: (N, 3) unit vectors.
            visible: (N, L) share of each lamp that was seen from nearby, 0..1.
            draws: (N,) random numbers in 0..1.

        Returns:
            (N,) lamps and (N,) one over the probability of the choice; 0 where no lamp can matter.
        """
        total = np.zeros(len(points), np.float32)
        sums = []
        for lamp in range(self.lamp_count):
            offset = self._centre[lamp] - points
            squared = dot(offset, offset) + np.float32(self._reach[lamp] ** 2)
            scale = 1 / np.sqrt(squared)
            # A lamp is lit by its nearest edge even where its middle is below the horizon.
            slack = np.float32(self._reach[lamp]) * scale
            expected = np.maximum(dot(normals, offset) * scale + slack, 0)
            if not self._round[lamp]:
                expected *= np.maximum(slack - dot(self._facing[lamp : lamp + 1], offset) * scale, 0)
            expected *= self._area[lamp] * self._brightest[lamp] / squared
            expected *= np.maximum(visible[:, lamp], np.float32(LEAST_VISIBLE))
            total += expected
            sums.append(total.copy())
        aim = draws * total
        chosen = np.zeros(len(points), np.int64)
        for passed in sums[:-1]:
            chosen += aim >= passed
        bounds = np.vstack([np.zeros_like(total), *sums])
        every = np.arange(len(points))
        share = bounds[chosen + 1, every] - bounds[chosen, every]
        return chosen, np.where(share > 0, total / np.maximum(share, np.float32(1e-20)), 0).astype(np.float32)

    def _spots(
        self, lamp: NDArray[np.int64], points: NDArray[np.float32], rng: np.random.Generator
    ) -> NDArray[np.float32]:
        """A random spot (N, 3) of each point's lamp."""
        first, second = rng.random(len(points), np.float32), rng.random(len(points), np.float32)
        spots = rows(self._centre, lamp)
        spots += rows(self._edges[:, 0], lamp) * (first - np.float32(0.5))[:, None]
        spots += rows(self._edges[:, 1], lamp) * (second - np.float32(0.5))[:, None]
        ball = np.flatnonzero(self._round[lamp])
        if len(ball):
            # The disc that faces the point.
            side, other = tangents(unit(rows(points, ball) - rows(spots, ball)))
            radius, angle = self._radius[lamp[ball]] * np.sqrt(first[ball]), np.float32(2 * np.pi) * second[ball]
            spots[ball] += side * (radius * np.cos(angle))[:, None] + other * (radius * np.sin(angle))[:, None]
        return spots


def _normal_triples(count: int, rng: np.random.Generator) -> NDArray[np.float32]:
    return rng.standard_normal((3, count), np.float32).T
