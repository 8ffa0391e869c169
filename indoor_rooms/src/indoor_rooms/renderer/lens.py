"""The camera's rays: where each goes, and what it meets."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from indoor_rooms.renderer.compiled import Surfaces
from indoor_rooms.renderer.raycast import Hits
from indoor_rooms.renderer.vectors import columns, dot, unit


@dataclass(frozen=True, eq=False)
class Lens:
    """Where each pixel's rays go.

    Attributes:
        image_size: side of the square picture in pixels.
        fov: field of view in degrees.
        grid: rays along a pixel's side; a pixel has grid x grid spots for rays.
        position: (3,) of the camera.
        axes: (3, 3) rows right, up, forward.
    """

    image_size: int
    fov: float
    grid: int
    position: NDArray[np.float32]
    axes: NDArray[np.float32]

    @property
    def pixel(self) -> float:
        """Width of a pixel at a depth of one metre; metres."""
        return 2 * math.tan(math.radians(self.fov) / 2) / self.image_size

    @property
    def spots(self) -> NDArray[np.float32]:
        """(2, grid x grid) where in a pixel its rays go, from its left and its upper edge, 0..1."""
        row, column = np.divmod(np.arange(self.grid**2), self.grid)
        # A sheared grid: no two rays of a pixel share a row or a column, so edges get more steps.
        across = (column + (row + 0.5) / self.grid) / self.grid
        down = (row + (column + 0.5) / self.grid) / self.grid
        return np.stack([across, down]).astype(np.float32)

    def directions(
        self, pixels: NDArray[np.int64], spot: NDArray[np.int64]
    ) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
        """Unit directions (N, 3) of rays, and their cosine (N,) to the viewing axis."""
        row, column = (index.astype(np.float32) for index in np.divmod(pixels, self.image_size))
        across, down = self.spots
        half, pixel = np.float32(self.image_size / 2), np.float32(self.pixel)
        x = (column + across[spot] - half) * pixel
        y = (half - row - down[spot]) * pixel
        cosine = 1 / np.sqrt(1 + x * x + y * y)
        right, up, forward = self.axes
        # Not a matrix product: its rounding depends on how many threads share it.
        directions = columns(*((x * right[axis] + y * up[axis] + forward[axis]) * cosine for axis in range(3)))
        return directions, cosine


@dataclass(frozen=True, eq=False)
class RayHits:
    """What some of the camera's rays met.

    Attributes:
        hits: triangles and places in them; triangle 0 where nothing was hit.
        spot: (N,) of the ray within its pixel.
        view: (N, 3) unit direction of the ray.
        part: (N,) row of the part table, -1 where nothing was hit.
        normal: (N, 3) smooth unit normal on the camera's side.
        uv: (N, 2) texture coordinates.
        distance: (N,) from the camera; metres.
        depth: (N,) along the viewing axis, infinite where nothing was hit.
        position: (N, 3) metres.
    """

    hits: Hits
    spot: NDArray[np.int64]
    view: NDArray[np.float32]
    part: NDArray[np.int32]
    normal: NDArray[np.float32]
    uv: NDArray[np.float32]
    distance: NDArray[np.float32]
    depth: NDArray[np.float32]
    position: NDArray[np.float32]


@dataclass(frozen=True, eq=False)
class PixelRays:
    """The rays of a picture: the first of each pixel (P), and for the pixels `edges` (E,) all the others."""

    first: RayHits
    edges: NDArray[np.int64]
    further: RayHits


def meet(surfaces: Surfaces, lens: Lens, pixels: NDArray[np.int64], spot: NDArray[np.int64]) -> RayHits:
    """Cast rays through spots (N,) of pixels (N,)."""
    view, cosine = lens.directions(pixels, spot)
    hits = surfaces.caster.hits(np.broadcast_to(lens.position, view.shape), view)
    missed = hits.triangle < 0
    part = np.where(missed, -1, surfaces.part_of_face[hits.triangle])
    hits.triangle[missed] = 0
    attributes = surfaces.interpolate(surfaces.normals_and_uvs, hits)
    # Thin things are seen from both sides; the geometry, not the smooth normal, says from which.
    side = np.where(dot(hits.normal, view) > 0, np.float32(-1), np.float32(1))
    return RayHits(
        hits=hits,
        spot=spot,
        view=view,
        part=part,
        normal=unit(attributes[:, :3]) * side[:, None],
        uv=attributes[:, 3:],
        distance=hits.distance,
        depth=np.where(missed, np.float32(np.inf), hits.distance * cosine),
        position=view * hits.distance[:, None] + lens.position,
    )
