"""Baking: how much light arrives at every vertex of a room, bounced light included."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from indoor_rooms.progress import Progress, quiet
from indoor_rooms.renderer.compiled import Surfaces, compile_room, triangle_areas
from indoor_rooms.renderer.direct_light import Lights
from indoor_rooms.renderer.raycast import SURFACE_OFFSET, Hits
from indoor_rooms.renderer.smoothing import SurfaceGraph
from indoor_rooms.renderer.vectors import cosine_directions, dot
from indoor_rooms.room import Room

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
# A vertex that stands for a square of this side gets all its rays; where vertices lie closer, smoothing averages
# over more of them and each needs fewer, down to this share of them. Metres.
FULL_RAYS_SIDE = 0.04
FEWEST_RAYS = 0.125


@dataclass(frozen=True, eq=False)
class BakedRoom:
    """A room with its light.

    Attributes:
        room: what was baked.
        surfaces: its geometry and materials as arrays.
        indirect: (V, 3) float32 irradiance at each vertex from everything but the sun and the lamps themselves.
        total: (V, 3) float32 irradiance with them.
        radiosity: (V, 3) float32, what each vertex sends on of `total`.
        lamp_visible: (V, L) float32, share of each lamp that is seen from about each vertex, 0..1.
        exposure: factor that brings the room's radiance to the brightness of a well exposed picture.
        seed: of the bake; views are seeded by it and their pose.
    """

    room: Room
    surfaces: Surfaces
    indirect: NDArray[np.float32]
    total: NDArray[np.float32]
    radiosity: NDArray[np.float32]
    lamp_visible: NDArray[np.float32]
    exposure: float
    seed: int

    @cached_property
    def lights(self) -> Lights:
        """The sun and the lamps, ready to be sampled."""
        return Lights(self.room, self.surfaces)

    @property
    def object_names(self) -> tuple[str, ...]:
        """What the numbers in an instance mask stand for."""
        return self.surfaces.object_names


def bake(
    room: Room,
    rays: int = 96,
    bounces: int = 4,
    seed: int = 0,
    progress: Progress = quiet,
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
    lights = Lights(room, surfaces)
    direct, visible = _direct(lights, points, surfaces.normals, rng)
    seen, glow, sound = _gather(room, surfaces, points, _rays_of_vertices(surfaces, rays), rng, progress)
    is_sound = (sound >= SOUND_SHARE)[:, None]
    trust = (is_sound[:, 0] + 1e-3 * sound).astype(np.float32)
    graph = SurfaceGraph(surfaces.positions, surfaces.normals, surfaces.faces)
    direct = np.where(is_sound, direct, graph.smooth(direct, trust, SMOOTHING_ROUNDS))
    visible = graph.smooth(visible, trust, 1)

    reflectance = _reflectance(surfaces)
    sent = np.zeros((len(points) + 1, 3), np.float32)
    indirect = glow
    for _ in range(bounces):
        sent[:-1] = reflectance * (indirect + direct)
        indirect = glow + seen.collect(sent)
        # Within the loop only the unknown vertices are replaced; smoothing again and again would wash light away.
        indirect = np.where(is_sound, indirect, graph.smooth(indirect, trust, SMOOTHING_ROUNDS))
    indirect = graph.smooth(indirect, trust, SMOOTHING_ROUNDS)
    total = indirect + direct
    radiosity = reflectance * total
    exposure = _exposure(surfaces, radiosity)
    return BakedRoom(room, surfaces, indirect, total, radiosity, visible, exposure, seed)


def _direct(
    lights: Lights, points: NDArray[np.float32], normals: NDArray[np.float32], rng: np.random.Generator
) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
    """Irradiance (V, 3) from the sun and the lamps, and the share (V, L) of each lamp that is seen."""
    total = np.zeros((len(points), 3), np.float32)
    visible = np.zeros((len(points), lights.lamp_count), np.float32)
    for _ in range(DIRECT_SAMPLES):
        for light in lights.sunlight(points, normals, rng):
            total[light.index] += light.irradiance
        for lamp in range(lights.lamp_count):
            light = lights.lamplight(np.full(len(points), lamp), points, normals, rng)
            total[light.index] += light.irradiance
            visible[light.index, lamp] += 1
    return total / np.float32(DIRECT_SAMPLES), visible / np.float32(DIRECT_SAMPLES)


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


def _rays_of_vertices(surfaces: Surfaces, rays: int) -> NDArray[np.int64]:
    """How many rays each vertex sends (V,): fewer where vertices lie close together."""
    area = np.repeat(triangle_areas(surfaces.positions, surfaces.faces) / 3, 3)
    side = np.sqrt(np.bincount(surfaces.faces.ravel(), area, len(surfaces.positions)))
    return np.ceil(rays * np.clip(side / FULL_RAYS_SIDE, FEWEST_RAYS, 1)).astype(np.int64)


@dataclass(frozen=True, eq=False)
class _Seen:
    """What the rays of all vertices met.

    Attributes:
        order: (V,) the vertices, those with most rays first.
        targets: for each ray number the vertices (R,) that the first R vertices of `order` see, V standing for none.
        weight: (V,) one over the number of rays that did not meet an inner side.
    """

    order: NDArray[np.int64]
    targets: list[NDArray[np.int32]]
    weight: NDArray[np.float32]

    def collect(self, sent: NDArray[np.float32]) -> NDArray[np.float32]:
        """Irradiance (V, 3) if each vertex sends radiosity (V + 1, 3), the last row being none."""
        ordered = np.zeros((len(self.order), 3), np.float32)
        for targets in self.targets:
            ordered[: len(targets)] += np.take(sent, targets, axis=0)
        received = np.empty_like(ordered)
        received[self.order] = ordered
        return np.asarray(received * self.weight[:, None], np.float32)


def _gather(
    room: Room,
    surfaces: Surfaces,
    points: NDArray[np.float32],
    rays: NDArray[np.int64],
    rng: np.random.Generator,
    progress: Progress,
) -> tuple[_Seen, NDArray[np.float32], NDArray[np.float32]]:
    """Send cosine-distributed rays from every vertex, `rays` (V,) of them.

    Returns:
        What they met; irradiance (V, 3) of the sky and of glowing surfaces other than lamps; the share (V,) of rays
        that did not hit an inner side.
    """
    count, most = len(points), int(rays.max())
    order = np.argsort(-rays, kind="stable")
    # Of the vertices in this order, so many have a first ray, a second, ...
    active = count - np.searchsorted(rays[order][::-1], np.arange(most), side="right")
    normals = surfaces.normals[order]
    origins = points[order] + normals * SURFACE_OFFSET
    shift = rng.random((2, count), np.float32)
    glow = np.zeros((count, 3), np.float32)
    outer = np.zeros(count, np.float32)
    seen = []
    sky = np.asarray(room.sky, np.float32)
    for ray in range(most):
        some = slice(0, active[ray])
        # The R2 sequence, shifted for each vertex: even over the hemisphere, no pattern over the surface.
        share = (shift[0, some] + np.float32(ray * 0.7548776662466927 % 1)) % 1
        turn = (shift[1, some] + np.float32(ray * 0.5698402909980532 % 1)) % 1
        directions = cosine_directions(normals[some], share, turn)
        hits = surfaces.caster.hits(origins[some], directions)
        missed = hits.triangle < 0
        glow[some][missed] += np.pi * sky
        part = surfaces.part_of_face[hits.triangle]
        glows = ~missed & (surfaces.parts.emission[part] > 0)
        inner = ~missed & ~glows & (dot(hits.normal, directions) > 0)
        outer[some] += ~inner
        targets = _nearby_vertex(surfaces, hits, rng)
        # Lamps were sampled directly already.
        shines = np.flatnonzero(glows & ~surfaces.parts.is_lamp[part])
        if len(shines):
            glow[shines] += np.pi * _emitted(surfaces, hits.subset(shines))
        targets[missed | inner | glows] = count
        seen.append(targets)
        progress(ray + 1, most)
    back = np.argsort(order)
    glow, outer = glow[back], outer[back]
    weight = (1 / np.maximum(outer, 1)).astype(np.float32)
    return _Seen(order, seen, weight), glow * weight[:, None], (outer / rays).astype(np.float32)


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
