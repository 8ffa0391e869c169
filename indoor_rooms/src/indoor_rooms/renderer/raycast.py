"""Rays against triangles, by Embree."""

from __future__ import annotations

import os
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from indoor_rooms.errors import RoomError

# Rays start this far above a surface, or they would hit it; metres.
SURFACE_OFFSET = 1e-3
FAR = 1e6


class RoomsExtraError(RoomError, ImportError):
    """The packages that render rooms are not installed."""


def _embree() -> tuple[Any, Any]:
    try:
        from embreex.mesh_construction import TriangleMesh
        from embreex.rtcore_scene import EmbreeScene
    except ImportError as error:
        raise RoomsExtraError(
            "rendering rooms needs the 'rooms' extra: pip install 'active-perceiver[rooms]'"
        ) from error
    return EmbreeScene, TriangleMesh


def open_image_denoise() -> Any:
    """The Open Image Denoise module, told to stay on the CPU.

    Raises:
        RoomsExtraError: if it is not installed.
    """
    os.environ.setdefault("OIDN_DEFAULT_DEVICE", "cpu")
    try:
        import mitsuba_oidn
    except ImportError as error:
        raise RoomsExtraError(
            "rendering rooms needs the 'rooms' extra: pip install 'active-perceiver[rooms]'"
        ) from error
    return mitsuba_oidn


@dataclass(frozen=True, eq=False)
class Hits:
    """Where rays met triangles.

    Attributes:
        triangle: (N,) int32, -1 where nothing was hit.
        u: (N,) float32 barycentric weight of the triangle's second vertex.
        v: (N,) float32 barycentric weight of its third vertex.
        distance: (N,) float32 along the ray in lengths of its direction; the ray's reach where nothing was hit.
        normal: (N, 3) float32 geometric normal, not of unit length, on the side the winding says.
    """

    triangle: NDArray[np.int32]
    u: NDArray[np.float32]
    v: NDArray[np.float32]
    distance: NDArray[np.float32]
    normal: NDArray[np.float32]

    def subset(self, index: NDArray[np.int64] | slice) -> Hits:
        """The hits of some of the rays."""
        return Hits(self.triangle[index], self.u[index], self.v[index], self.distance[index], self.normal[index])


class RayCaster:
    """An Embree scene of one triangle soup.

    Args:
        triangles: (F, 3, 3) corner positions in metres.

    Raises:
        RoomsExtraError: if Embree is not installed.
    """

    def __init__(self, triangles: NDArray[np.float32]) -> None:
        scene_class, mesh_class = _embree()
        self._scene = scene_class()
        # Embree keeps a pointer into the mesh: without this reference it is freed and rays hit garbage.
        self._mesh = mesh_class(self._scene, np.ascontiguousarray(triangles, np.float32))

    def hits(self, origins: NDArray[np.float32], directions: NDArray[np.float32], reach: float = FAR) -> Hits:
        """The first triangle each ray meets within `reach` of its start; both arrays (N, 3).

        A short reach makes rays several times faster.
        """
        if len(origins) == 0:
            empty = np.zeros(0, np.float32)
            return Hits(np.zeros(0, np.int32), empty, empty, empty, np.zeros((0, 3), np.float32))
        limit = np.full(len(origins), reach, np.float32)
        result = self._scene.run(_rays(origins), _rays(directions), dists=limit, query="INTERSECT", output=1)
        return Hits(result["primID"], result["u"], result["v"], result["tfar"], result["Ng"])

    def occluded(
        self,
        origins: NDArray[np.float32],
        directions: NDArray[np.float32],
        distances: NDArray[np.float32] | None = None,
    ) -> NDArray[np.bool_]:
        """Whether anything lies on each ray, (N,), up to `distances` (N,) or anywhere."""
        if len(origins) == 0:
            return np.zeros(0, bool)
        reach = np.full(len(origins), FAR, np.float32) if distances is None else distances.astype(np.float32)
        return self._scene.run(_rays(origins), _rays(directions), dists=reach, query="OCCLUDED") >= 0


def _rays(array: NDArray[np.float32]) -> NDArray[np.float32]:
    return np.ascontiguousarray(array, np.float32)
