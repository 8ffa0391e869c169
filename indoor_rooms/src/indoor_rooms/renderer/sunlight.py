"""Where in a room the sun can shine at all: most points need no shadow ray towards it."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import maximum_filter

from indoor_rooms.renderer.compiled import Surfaces
from indoor_rooms.renderer.vectors import columns, dot, tangents
from indoor_rooms.room import Sun

# Half the angle under which the sun is seen, a little wider than the real 0.27 degrees: softer edges. Radians.
SUN_RADIUS = 0.008
# The sun looks at the room through a grid of this many cells a side.
GRID = 512
# Rays towards the sun leave its middle by hardly ever more than this many `SUN_RADIUS`.
WIDEST = 3.5
# A point this far behind what the sun sees first lies in its shadow; metres.
BEHIND = 0.01


class SunShafts:
    """The shafts of sunlight in a room, a little too wide.

    Args:
        sun: of the room.
        surfaces: what throws shadows.

    Attributes:
        towards: (3,) unit vector towards the sun.
        irradiance: (3,) of a surface that faces it.
    """

    def __init__(self, sun: Sun, surfaces: Surfaces) -> None:
        towards = -np.asarray(sun.direction, np.float32)
        self.towards = towards / np.linalg.norm(towards)
        self.irradiance = np.asarray(sun.colour, np.float32) * np.float32(sun.strength)
        side, other = tangents(self.towards[None])
        self._frame = np.concatenate([side, other, -self.towards[None]])
        across, down, along = self._coordinates(surfaces.positions)
        self._low = np.array([across.min(), down.min()], np.float32)
        extent = max(float(np.ptp(across)), float(np.ptp(down)), 1e-3)
        self._cell = np.float32(extent / (GRID - 1))
        start, depth = float(along.min()) - 1, float(np.ptp(along)) + 1
        row, column = (index.ravel().astype(np.float32) for index in np.indices((GRID, GRID)))
        origins = [
            (self._low[0] + row * self._cell) * side[0, axis]
            + (self._low[1] + column * self._cell) * other[0, axis]
            - start * self.towards[axis]
            for axis in range(3)
        ]
        directions = np.tile(-self.towards, (GRID * GRID, 1))
        hits = surfaces.shadow_caster.hits(columns(*origins), directions)
        reached = np.where(hits.triangle >= 0, start + hits.distance, np.inf).astype(np.float32)
        blur = int(np.ceil(WIDEST * SUN_RADIUS * depth / self._cell)) + 1
        self._deepest = maximum_filter(reached.reshape(GRID, GRID), 2 * blur + 1).ravel()

    def may_reach(self, points: NDArray[np.float32]) -> NDArray[np.bool_]:
        """Whether the sun may shine on points (N, 3); false only for those in its full shadow, (N,)."""
        across, down, along = self._coordinates(points)
        row = ((across - self._low[0]) / self._cell + np.float32(0.5)).astype(np.int32)
        column = ((down - self._low[1]) / self._cell + np.float32(0.5)).astype(np.int32)
        cell = np.clip(row, 0, GRID - 1) * GRID + np.clip(column, 0, GRID - 1)
        return along < np.take(self._deepest, cell) + np.float32(BEHIND)

    def _coordinates(self, points: NDArray[np.float32]) -> list[NDArray[np.float32]]:
        return [dot(points, axis[None]) for axis in self._frame]
