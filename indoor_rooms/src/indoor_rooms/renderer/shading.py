"""What light a surface sends to the camera: matt, glossy, metallic and lacquered materials."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from indoor_rooms.renderer.direct_light import LAMP_SAMPLES, LightSample
from indoor_rooms.renderer.lighting import BakedRoom
from indoor_rooms.renderer.raycast import SURFACE_OFFSET
from indoor_rooms.renderer.vectors import columns, cosine_directions, dot, put, rows, unit

# Surfaces rougher than this reflect no picture of the room, only its average light.
GLOSSY_UP_TO = 0.5
# Reflections weaker than this are not worth a ray.
FAINTEST_REFLECTION = 0.015
COAT_ROUGHNESS = 0.06
# Lamps mirrored by smoother surfaces are found by the glossy ray; rougher ones need the shadow ray's direction.
MIRROR_UP_TO = 0.12
BRIGHTEST_REFLECTION = 8.0
BRIGHTEST_HIGHLIGHT = 4.0
# What lies nearer than this shades a surface more sharply than baked light can; metres.
NEAR = 0.15
NEAR_STRENGTH = 1.0
REFLECTION_FOOTPRINT = 0.01


@dataclass(frozen=True, eq=False)
class SurfacePoints:
    """Points seen by the camera.

    Attributes:
        position: (N, 3) metres.
        normal: (N, 3) unit vectors on the camera's side.
        view: (N, 3) unit vectors from the camera.
        part: (N,) rows of the part table.
        colour: (N, 3) base colour, texture included.
        indirect: (N, 3) baked irradiance.
        vertex: (N,) a vertex of the mesh nearby.
    """

    position: NDArray[np.float32]
    normal: NDArray[np.float32]
    view: NDArray[np.float32]
    part: NDArray[np.int32]
    colour: NDArray[np.float32]
    indirect: NDArray[np.float32]
    vertex: NDArray[np.int32]


def shade(
    baked: BakedRoom, points: SurfacePoints, exposure: float, rng: np.random.Generator
) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
    """Light the points.

    Args:
        baked: the room.
        points: where.
        exposure: the picture's; fireflies are clamped relative to it.
        rng: of soft shadows and glossy reflections.

    Returns:
        (N, 3) light for the base colour to be multiplied by, and (N, 3) radiance reflected at the surface.
    """
    table = baked.surfaces.parts
    metal = table.metalness[points.part]
    coat = table.coat[points.part]
    roughness = table.roughness[points.part]
    facing = np.clip(-dot(points.normal, points.view), 0, 1)
    grazing = (1 - facing) ** 2
    grazing *= grazing * (1 - facing)
    base_reflection = points.colour * metal[:, None]
    base_reflection += (np.float32(0.08) * table.specular[points.part] * (1 - metal))[:, None]
    fresnel = np.maximum((1 - roughness)[:, None], base_reflection) - base_reflection
    fresnel *= grazing[:, None]
    fresnel += base_reflection
    coat_fresnel = coat * (np.float32(0.04) + np.float32(0.96) * grazing)

    irradiance = _near_field(baked, points, rng)
    highlight = np.zeros_like(irradiance)
    rough = roughness > MIRROR_UP_TO
    for light in _light_samples(baked, points, rng):
        at = light.index
        put(irradiance, at, rows(irradiance, at) + light.irradiance)
        shiny = np.flatnonzero(rough[at])
        at, direction = at[shiny], rows(light.direction, shiny)
        lobe = _microfacet(rows(points.normal, at), rows(points.view, at), direction, roughness[at])
        lit = rows(fresnel, at) * lobe[:, None] * rows(light.irradiance, shiny)
        put(highlight, at, rows(highlight, at) + lit)
    ambient = irradiance * np.float32(1 / np.pi)
    strongest = np.maximum(np.maximum(fresnel[:, 0], fresnel[:, 1]), fresnel[:, 2])
    smooth = (roughness < GLOSSY_UP_TO) & (strongest + coat_fresnel > FAINTEST_REFLECTION)
    coated = coat > 0
    glossy = _reflected(baked, points, np.where(coated, COAT_ROUGHNESS, roughness), smooth | coated, exposure, rng)
    bare = fresnel * np.where((smooth & ~coated)[:, None], glossy, np.float32(0.8) * ambient)
    bare += coat_fresnel[:, None] * np.where((smooth | coated)[:, None], glossy, ambient)
    bare += np.minimum(highlight, np.float32(BRIGHTEST_HIGHLIGHT / exposure))
    return ((1 - metal) * (1 - coat_fresnel))[:, None] * ambient, bare


def _light_samples(baked: BakedRoom, points: SurfacePoints, rng: np.random.Generator) -> Iterator[LightSample]:
    """Light straight from the sun, and from lamps that each point chooses by what it expects of them."""
    lights = baked.lights
    yield from lights.sunlight(points.position, points.normal, rng)
    if lights.lamp_count:
        visible = np.take(baked.lamp_visible, points.vertex, axis=0)
        for _ in range(LAMP_SAMPLES):
            draws = rng.random(len(points.position), np.float32)
            lamp, weight = lights.choose_lamps(points.position, points.normal, visible, draws)
            yield lights.lamplight(lamp, points.position, points.normal, rng, weight * np.float32(1 / LAMP_SAMPLES))


def _near_field(baked: BakedRoom, points: SurfacePoints, rng: np.random.Generator) -> NDArray[np.float32]:
    """Baked irradiance, sharpened by one ray for what is close: contact shadows finer than the mesh."""
    surfaces = baked.surfaces
    count = len(points.position)
    directions = cosine_directions(points.normal, rng.random(count, np.float32), rng.random(count, np.float32))
    hits = surfaces.caster.hits(points.position + points.normal * SURFACE_OFFSET, directions, NEAR)
    near = np.flatnonzero(hits.triangle >= 0)
    near = near[dot(hits.normal[near], rows(directions, near)) < 0]
    irradiance = points.indirect.copy(order="K")
    # Towards the end of its reach the ray counts less: no rim where it ends.
    share = NEAR_STRENGTH * (1 - hits.distance[near] / NEAR)
    sent = np.take(baked.radiosity, surfaces.faces[hits.triangle[near], 0], axis=0)
    before = rows(irradiance, near)
    put(irradiance, near, before + share[:, None] * np.minimum(sent - before, 0))
    return irradiance


def _reflected(
    baked: BakedRoom,
    points: SurfacePoints,
    roughness: NDArray[np.float32],
    wanted: NDArray[np.bool_],
    exposure: float,
    rng: np.random.Generator,
) -> NDArray[np.float32]:
    """Radiance (N, 3) that one ray about the mirror direction finds; zeros where it is not wanted."""
    surfaces = baked.surfaces
    result = np.zeros_like(points.position)
    index = np.flatnonzero(wanted)
    if len(index) == 0:
        return result
    normal, rough = rows(points.normal, index), roughness[index]
    directions = rows(points.view, index)
    directions -= normal * (2 * dot(directions, normal))[:, None]
    directions += rng.standard_normal((3, len(index)), np.float32).T * (np.float32(0.7) * rough**2)[:, None]
    # A ray bent below the surface would see the inside of the object.
    below = dot(directions, normal)
    directions -= normal * np.minimum(below - np.float32(0.01), 0)[:, None]
    directions = unit(directions)
    hits = surfaces.caster.hits(rows(points.position, index) + normal * SURFACE_OFFSET, directions)
    radiance = columns(*(np.full(len(index), value, np.float32) for value in baked.room.sky))
    found = np.flatnonzero(hits.triangle >= 0)
    hits = hits.subset(found)
    part = surfaces.part_of_face[hits.triangle]
    uv = surfaces.interpolate(surfaces.uvs, hits)
    colour = surfaces.base_colour(part, uv, REFLECTION_FOOTPRINT * surfaces.uv_density[hits.triangle])
    emission = surfaces.parts.emission[part]
    # Rough surfaces get their lamp highlights from the shadow rays.
    shown = np.where(surfaces.parts.is_lamp[part] & (rough[found] > MIRROR_UP_TO), 0, emission)
    sent = surfaces.interpolate(baked.total, hits) * np.float32(1 / np.pi)
    colour *= np.where((emission > 0)[:, None], shown[:, None], sent)
    put(radiance, found, colour)
    put(result, index, np.minimum(radiance, np.float32(BRIGHTEST_REFLECTION / exposure)))
    return result


def _microfacet(
    normal: NDArray[np.float32],
    view: NDArray[np.float32],
    light: NDArray[np.float32],
    roughness: NDArray[np.float32],
) -> NDArray[np.float32]:
    """GGX lobe (N,) for irradiance, without Fresnel: D times visibility (Hammon's approximation)."""
    half = unit(light - view)
    alpha2 = np.maximum(np.square(np.square(roughness)), 1e-5)
    cosine = np.clip(dot(normal, half), 0, 1)
    distribution = alpha2 / (np.pi * (cosine**2 * (alpha2 - 1) + 1) ** 2)
    to_light = np.clip(dot(normal, light), 0, 1)
    to_eye = np.clip(-dot(normal, view), 0, 1)
    alpha = np.sqrt(alpha2)
    mixed = 2 * to_light * to_eye * (1 - alpha) + (to_light + to_eye) * alpha
    return np.asarray(distribution * 0.5 / np.maximum(mixed, 1e-4), np.float32)
