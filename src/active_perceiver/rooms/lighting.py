"""Baking: how much light arrives at every vertex of a room, bounced light included."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from active_perceiver.progress import Report, quiet
from active_perceiver.rooms.compiled import Surfaces, compile_room, triangle_areas
from active_perceiver.rooms.direct_light import direct_irradiance
from active_perceiver.rooms.raycast import SURFACE_OFFSET, Hits
from active_perceiver.rooms.room import Room
from active_perceiver.rooms.smoothing import SurfaceGraph
from active_perceiver.rooms.vectors import cosine_directions, dot

# A vertex is sampled this far towards the middle of its faces: one on a wall's edge must not see past the wall.
PULL_INWARD = 0.12
# A vertex that sees mostly the inner sides of surfaces lies inside a solid; its light is its neighbours'.
SOUND_SHARE = 0.5
# Colours are averaged over this width when light bounces; metres.
BOUNCE_FOOTPRINT = 0.1
SMOOTHING_ROUNDS = 4
# Average brightness of the surfaces of a room in a picture, before tone mapping.
MIDDLE_GREY = 0.22
DIRECT_SAMPLES = 4


@dataclass(frozen=True, eq=False)
class BakedRoom:
    """A room with its light.

    Attributes:
        room: what was baked.
        surfaces: its geometry and materials as arrays.
        indirect: (V, 3) float32 irradiance at each vertex from everything but the sun and the lamps themselves.
        total: (V, 3) float32 irradiance with them.
        radiosity: (V, 3) float32, what each vertex sends on of `total`.
        exposure: factor that brings the room's radiance to the brightness of a well exposed picture.
        seed: of the bake; views are seeded by it and their pose.
    """

    room: Room
    surfaces: Surfaces
    indirect: NDArray[np.float32]
    total: NDArray[np.float32]
    radiosity: NDArray[np.float32]
    exposure: float
    seed: int

    @property
    def object_names(self) -> tuple[str, ...]:
        """What the numbers in an instance mask stand for."""
        return self.surfaces.object_names


def bake(
    room: Room,
    rays: int = 96,
    bounces: int = 4,
    seed: int = 0,
    progress: Report = quiet,
) -> BakedRoom:
    """Compute the light in a room.

    Args:
        room: what to light.
        rays: rays per vertex; blotches are gone from 64 on.
        bounces: how often light is passed on between surfaces.
        seed: of the rays.
        progress: called with the rays per vertex done and to do.

    Returns:
        The room with irradiance at every vertex of its tessellated mesh.
    """
    surfaces = compile_room(room)
    rng = np.random.default_rng(seed)
    points = _inward_points(surfaces)
    direct = direct_irradiance(room, surfaces, points, surfaces.normals, rng, DIRECT_SAMPLES)
    seen, glow, sound = _gather(room, surfaces, points, rays, rng, progress)
    is_sound = (sound >= SOUND_SHARE)[:, None]
    trust = (is_sound[:, 0] + 1e-3 * sound).astype(np.float32)
    graph = SurfaceGraph(surfaces.positions, surfaces.normals, surfaces.faces)
    direct = np.where(is_sound, direct, graph.smooth(direct, trust, SMOOTHING_ROUNDS))

    reflectance = _reflectance(surfaces)
    weight = (1 / np.maximum(sound * rays, 1.0)).astype(np.float32)
    indirect = glow * weight[:, None]
    for _ in range(bounces):
        sent = np.vstack([reflectance * (indirect + direct), np.zeros((1, 3), np.float32)])
        received = np.zeros_like(indirect)
        for targets in seen:
            received += np.take(sent, targets, axis=0)
        indirect = (glow + received) * weight[:, None]
        # Within the loop only the unknown vertices are replaced; smoothing again and again would wash light away.
        indirect = np.where(is_sound, indirect, graph.smooth(indirect, trust, SMOOTHING_ROUNDS))
    indirect = graph.smooth(indirect, trust, SMOOTHING_ROUNDS)
    total = indirect + direct
    radiosity = reflectance * total
    return BakedRoom(room, surfaces, indirect, total, radiosity, _exposure(surfaces, radiosity), seed)


def _inward_points(surfaces: Surfaces) -> NDArray[np.float32]:
    """Where each vertex is sampled, (V, 3): a little towards the middle of the faces around it."""
    middles = surfaces.positions[surfaces.faces].mean(axis=1)
    count = len(surfaces.positions)
    corner = surfaces.faces.ravel()
    faces_around = np.maximum(np.bincount(corner, minlength=count), 1)
    mean = np.stack(
        [np.bincount(corner, np.repeat(middles[:, axis], 3), count) / faces_around for axis in range(3)], axis=1
    )
    shift = PULL_INWARD * (mean - surfaces.positions)
    # Only along the surface: on a sphere the middle of the faces lies below the vertex.
    shift = shift - surfaces.normals * dot(shift, surfaces.normals)[:, None]
    return (surfaces.positions + shift).astype(np.float32)


def _gather(
    room: Room,
    surfaces: Surfaces,
    points: NDArray[np.float32],
    rays: int,
    rng: np.random.Generator,
    progress: Report,
) -> tuple[list[NDArray[np.int32]], NDArray[np.float32], NDArray[np.float32]]:
    """Send cosine-distributed rays from every vertex.

    Returns:
        For each ray number the vertex each vertex sees (V,), V itself standing for none; the sum of pi times the
        radiance of the sky and of glowing surfaces seen (V, 3); the share of rays that did not hit an inner side.
    """
    count = len(points)
    origins = points + surfaces.normals * SURFACE_OFFSET
    shift = rng.random((count, 2), np.float32)
    glow = np.zeros((count, 3), np.float32)
    outer = np.zeros(count, np.float32)
    seen = []
    sky = np.asarray(room.sky, np.float32)
    for ray in range(rays):
        # The R2 sequence, shifted for each vertex: even over the hemisphere, no pattern over the surface.
        share = (shift[:, 0] + ray * 0.7548776662466927) % 1.0
        turn = (shift[:, 1] + ray * 0.5698402909980532) % 1.0
        directions = cosine_directions(surfaces.normals, share, turn)
        hits = surfaces.caster.hits(origins, directions)
        missed = hits.triangle < 0
        glow[missed] += np.pi * sky
        part = surfaces.part_of_face[hits.triangle]
        glows = ~missed & (surfaces.parts.emission[part] > 0)
        inner = ~missed & ~glows & (dot(hits.normal, directions) > 0)
        outer += ~inner
        targets = _nearby_vertex(surfaces, hits, rng)
        # Lamps were sampled directly already.
        shines = np.flatnonzero(glows & ~surfaces.parts.is_lamp[part])
        if len(shines):
            glow[shines] += np.pi * _emitted(surfaces, hits.subset(shines))
        targets[missed | inner | glows] = count
        seen.append(targets)
        progress(ray + 1, rays)
    return seen, glow, (outer / rays).astype(np.float32)


def _nearby_vertex(surfaces: Surfaces, hits: Hits, rng: np.random.Generator) -> NDArray[np.int32]:
    """One corner of each triangle hit, chosen by its barycentric weight: right on average, a third of the work."""
    draw = rng.random(len(hits.triangle), np.float32)
    corner = (draw < hits.u + hits.v).astype(np.int64) + ((draw >= hits.u) & (draw < hits.u + hits.v))
    return surfaces.faces[hits.triangle, corner]


def _emitted(surfaces: Surfaces, hits: Hits) -> NDArray[np.float32]:
    part = surfaces.part_of_face[hits.triangle]
    uv = surfaces.interpolate(surfaces.uvs, hits)
    footprint = BOUNCE_FOOTPRINT * surfaces.uv_density[hits.triangle]
    return surfaces.base_colour(part, uv, footprint) * surfaces.parts.emission[part][:, None]


def _reflectance(surfaces: Surfaces) -> NDArray[np.float32]:
    """How much of the light at each vertex is passed on, (V, 3)."""
    count = len(surfaces.positions)
    part_of_vertex, density = np.zeros(count, np.int32), np.zeros(count, np.float32)
    for corner in range(3):
        part_of_vertex[surfaces.faces[:, corner]] = surfaces.part_of_face
        density[surfaces.faces[:, corner]] = surfaces.uv_density
    colour = surfaces.base_colour(part_of_vertex, surfaces.uvs, BOUNCE_FOOTPRINT * density)
    colour[surfaces.parts.emission[part_of_vertex] > 0] = 0
    # Metals reflect like mirrors, not like chalk; some of it still ends up everywhere.
    kept = 1 - 0.5 * surfaces.parts.metalness[part_of_vertex]
    return np.asarray(colour * kept[:, None], np.float32)


def _exposure(surfaces: Surfaces, radiosity: NDArray[np.float32]) -> float:
    """Factor that brings the area-weighted geometric mean of the surfaces' radiance to a middle grey."""
    area = triangle_areas(surfaces.positions, surfaces.faces)
    area *= surfaces.parts.emission[surfaces.part_of_face] == 0
    radiance = (radiosity / np.pi).mean(axis=1)[surfaces.faces].mean(axis=1)
    lit = (radiance > 1e-4) & (area > 0)
    if not lit.any():
        return 1.0
    return float(MIDDLE_GREY / np.exp(np.average(np.log(radiance[lit]), weights=area[lit])))
