"""A room made ready for rays: one tessellated mesh, a triangle -> part table, materials as arrays."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from indoor_rooms.renderer.raycast import Hits, RayCaster
from indoor_rooms.renderer.tessellation import tessellate
from indoor_rooms.renderer.texture_lookup import TextureAtlas
from indoor_rooms.renderer.vectors import dot, put, rows
from indoor_rooms.room import Part, Room

# Parts with more surface than this carry visible gradients of light and are cut finely; square metres.
LARGE_AREA = 0.3
LARGE_PART_EDGE = 0.07
SMALL_PART_EDGE = 0.15
# Beyond this the bake takes minutes; larger rooms are cut more coarsely.
MAX_TRIANGLES = 400_000


@dataclass(frozen=True, eq=False)
class PartTable:
    """Materials of the parts, one row a part; see `Material` for what the columns mean."""

    object_index: NDArray[np.int32]
    colour: NDArray[np.float32]
    texture: NDArray[np.int64]
    roughness: NDArray[np.float32]
    metalness: NDArray[np.float32]
    specular: NDArray[np.float32]
    coat: NDArray[np.float32]
    emission: NDArray[np.float32]
    is_lamp: NDArray[np.bool_]


@dataclass(frozen=True, eq=False)
class Surfaces:
    """Everything in a room as arrays.

    Attributes:
        positions: (V, 3) float32, metres.
        normals: (V, 3) float32, unit length.
        uvs: (V, 2) float32.
        faces: (F, 3) int32.
        part_of_face: (F,) int32.
        uv_density: (F,) float32, uv units per metre.
        parts: the materials.
        object_names: index in `parts.object_index` -> name.
        atlas: the textures.
    """

    positions: NDArray[np.float32]
    normals: NDArray[np.float32]
    uvs: NDArray[np.float32]
    faces: NDArray[np.int32]
    part_of_face: NDArray[np.int32]
    uv_density: NDArray[np.float32]
    parts: PartTable
    object_names: tuple[str, ...]
    atlas: TextureAtlas

    @cached_property
    def caster(self) -> RayCaster:
        """Rays against everything."""
        return RayCaster(self.positions[self.faces])

    @cached_property
    def shadow_caster(self) -> RayCaster:
        """Rays against everything that throws shadows: what glows does not, lest a bulb shadow its own light."""
        dark = self.parts.emission[self.part_of_face] == 0
        return RayCaster(self.positions[self.faces[dark]])

    @cached_property
    def normals_and_uvs(self) -> NDArray[np.float32]:
        """(V, 5): side by side they are interpolated in one go."""
        return np.hstack([self.normals, self.uvs])

    @cached_property
    def uv_gradients(self) -> NDArray[np.float32]:
        """(F, 6) uv units per metre: how u, then v, grow along x, y and z within each triangle."""
        corners, uvs = self.positions[self.faces], self.uvs[self.faces]
        first, second = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
        across = np.cross(first, second)
        across /= np.maximum(dot(across, across), 1e-18)[:, None]
        # What grows by 1 along one edge of the triangle and by 0 along the other.
        along_first, along_second = np.cross(second, across), np.cross(across, first)
        rise_first, rise_second = uvs[:, 1] - uvs[:, 0], uvs[:, 2] - uvs[:, 0]
        gradients = [along_first * rise_first[:, [k]] + along_second * rise_second[:, [k]] for k in range(2)]
        return np.hstack(gradients).astype(np.float32)

    def __getstate__(self) -> dict[str, Any]:
        """What travels to another process: not Embree's scenes, they are built anew there."""
        return {key: value for key, value in self.__dict__.items() if not key.endswith("caster")}

    def interpolate(self, values: NDArray[np.float32], hits: Hits) -> NDArray[np.float32]:
        """Values given per vertex (V, K) at the points hit, (N, K). Every ray must have hit something."""
        corners = np.take(self.faces, hits.triangle, axis=0)
        result = np.zeros((values.shape[1], len(corners)), np.float32)
        for corner, weight in zip(corners.T, (1 - hits.u - hits.v, hits.u, hits.v), strict=True):
            for column, value in zip(result, np.take(values, corner, axis=0).T, strict=True):
                column += value * weight
        return result.T

    def base_colour(
        self, part: NDArray[np.int32], uv: NDArray[np.float32], footprint: NDArray[np.float32]
    ) -> NDArray[np.float32]:
        """Base colour (N, 3) of parts at texture coordinates; `footprint` (N,) as in `TextureAtlas.sample`."""
        colour = rows(self.parts.colour, part)
        texture = self.parts.texture[part]
        textured = np.flatnonzero(texture >= 0)
        if len(textured):
            texel = self.atlas.sample(texture[textured], rows(uv, textured), footprint[textured])
            put(colour, textured, rows(colour, textured) * texel)
        return colour


def compile_room(room: Room) -> Surfaces:
    """Make a room ready for rays.

    Raises:
        ValueError: if the room has no parts.
    """
    if not room.parts:
        raise ValueError(f"room '{room.name}' has no parts; there is nothing to render")
    names = tuple(sorted({part.object_name for part in room.parts}))
    textures, texture_of_part = _distinct_textures(room.parts)
    meshes = [part.mesh for part in room.parts]
    offsets = np.cumsum([0] + [len(mesh.vertices) for mesh in meshes])
    vertices = np.concatenate([np.hstack([mesh.vertices, mesh.normals, mesh.uvs]) for mesh in meshes])
    vertices = vertices.astype(np.float64)
    faces = np.concatenate([mesh.faces + offset for mesh, offset in zip(meshes, offsets[:-1], strict=True)])
    faces = faces.astype(np.int64)
    part_of_face = np.repeat(np.arange(len(meshes)), [len(mesh.faces) for mesh in meshes])
    vertices, faces, source = _cut(room.parts, vertices, faces, part_of_face)
    normals = vertices[:, 3:6] / np.maximum(np.linalg.norm(vertices[:, 3:6], axis=1, keepdims=True), 1e-9)
    return Surfaces(
        positions=vertices[:, :3].astype(np.float32),
        normals=normals.astype(np.float32),
        uvs=vertices[:, 6:8].astype(np.float32),
        faces=faces.astype(np.int32),
        part_of_face=part_of_face[source].astype(np.int32),
        uv_density=_uv_density(vertices, faces),
        parts=_part_table(room, names, texture_of_part),
        object_names=names,
        atlas=TextureAtlas(textures),
    )


def triangle_areas(positions: NDArray[np.floating], faces: NDArray[np.integer]) -> NDArray[np.float64]:
    """Areas (F,) in square metres."""
    corners = positions[faces].astype(np.float64)
    return np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1) / 2


def _distinct_textures(parts: tuple[Part, ...]) -> tuple[list[NDArray[np.float32]], NDArray[np.int64]]:
    textures: list[NDArray[np.float32]] = []
    index_of: dict[int, int] = {}
    texture_of_part = np.full(len(parts), -1, np.int64)
    for row, part in enumerate(parts):
        texture = part.material.texture
        if texture is not None:
            if id(texture) not in index_of:
                index_of[id(texture)] = len(textures)
                textures.append(texture)
            texture_of_part[row] = index_of[id(texture)]
    return textures, texture_of_part


def _part_table(room: Room, names: tuple[str, ...], texture: NDArray[np.int64]) -> PartTable:
    materials = [part.material for part in room.parts]
    lamps = {lamp.object_name for lamp in room.lamps}
    row_of = {name: row for row, name in enumerate(names)}

    def column(field: str) -> NDArray[np.float32]:
        return np.array([getattr(material, field) for material in materials], np.float32)

    emission = column("emission")
    return PartTable(
        object_index=np.array([row_of[part.object_name] for part in room.parts], np.int32),
        colour=column("colour"),
        texture=texture,
        roughness=column("roughness"),
        metalness=column("metalness"),
        specular=column("specular"),
        coat=column("coat"),
        emission=emission,
        is_lamp=np.array([part.object_name in lamps for part in room.parts]) & (emission > 0),
    )


def _cut(
    parts: tuple[Part, ...], vertices: NDArray[np.float64], faces: NDArray[np.int64], part_of_face: NDArray[np.int64]
) -> tuple[NDArray[np.float64], NDArray[np.int64], NDArray[np.int64]]:
    """Tessellate what is large and does not glow; see `tessellate` for the result."""
    part_area = np.bincount(part_of_face, triangle_areas(vertices[:, :3], faces), len(parts))
    limit = np.where(part_area > LARGE_AREA, LARGE_PART_EDGE, SMALL_PART_EDGE)[part_of_face]
    limit[np.array([part.material.emission > 0 for part in parts])[part_of_face]] = np.inf
    cut = tessellate(vertices, faces, limit)
    added, allowed = len(cut[1]) - len(faces), MAX_TRIANGLES - len(faces)
    if added > allowed > 0:
        cut = tessellate(vertices, faces, limit * np.sqrt(added / allowed))
    return cut


def _uv_density(vertices: NDArray[np.float64], faces: NDArray[np.int64]) -> NDArray[np.float32]:
    uvs = vertices[faces, 6:8]
    side, other = uvs[:, 1] - uvs[:, 0], uvs[:, 2] - uvs[:, 0]
    uv_area = np.abs(side[:, 0] * other[:, 1] - side[:, 1] * other[:, 0]) / 2
    return np.sqrt(uv_area / np.maximum(triangle_areas(vertices[:, :3], faces), 1e-12)).astype(np.float32)
