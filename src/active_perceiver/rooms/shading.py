"""What light a surface sends to the camera: matt, glossy, metallic and lacquered materials."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from active_perceiver.rooms.direct_light import light_samples
from active_perceiver.rooms.lighting import BakedRoom
from active_perceiver.rooms.raycast import SURFACE_OFFSET
from active_perceiver.rooms.vectors import cosine_directions, dot, unit

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
    """

    position: NDArray[np.float32]
    normal: NDArray[np.float32]
    view: NDArray[np.float32]
    part: NDArray[np.int32]
    colour: NDArray[np.float32]
    indirect: NDArray[np.float32]


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
    metal = table.metalness[points.part][:, None]
    coat = table.coat[points.part]
    roughness = table.roughness[points.part]
    facing = np.clip(-dot(points.normal, points.view), 0, 1)
    base_reflection = 0.08 * table.specular[points.part][:, None] * (1 - metal) + points.colour * metal
    grazing = ((1 - facing) ** 5)[:, None]
    fresnel = base_reflection + (np.maximum(1 - roughness[:, None], base_reflection) - base_reflection) * grazing
    coat_fresnel = coat * (0.04 + 0.96 * (1 - facing) ** 5)

    irradiance = _near_field(baked, points, rng)
    highlight = np.zeros_like(irradiance)
    for light in light_samples(baked.room, baked.surfaces, points.position, points.normal, rng):
        irradiance[light.index] += light.irradiance
        at = light.index
        lobe = _microfacet(points.normal[at], points.view[at], light.direction, roughness[at])
        lobe = fresnel[at] * (lobe * (roughness[at] > MIRROR_UP_TO))[:, None]
        highlight[at] += lobe * light.irradiance
    glossy = _reflected(baked, points, np.where(coat > 0, COAT_ROUGHNESS, roughness), exposure, rng)
    ambient = irradiance / np.pi
    smooth = (roughness < GLOSSY_UP_TO)[:, None] & ((fresnel.max(1) + coat_fresnel) > FAINTEST_REFLECTION)[:, None]
    bare = fresnel * np.where(smooth & (coat == 0)[:, None], glossy, 0.8 * ambient)
    lacquer = coat_fresnel[:, None] * np.where(smooth | (coat > 0)[:, None], glossy, ambient)
    matt = (1 - metal) * (1 - coat_fresnel)[:, None] * ambient
    return matt, bare + lacquer + np.minimum(highlight, BRIGHTEST_HIGHLIGHT / exposure)


def _near_field(baked: BakedRoom, points: SurfacePoints, rng: np.random.Generator) -> NDArray[np.float32]:
    """Baked irradiance, sharpened by one ray for what is close: contact shadows finer than the mesh."""
    surfaces = baked.surfaces
    count = len(points.position)
    directions = cosine_directions(points.normal, rng.random(count, np.float32), rng.random(count, np.float32))
    hits = surfaces.caster.hits(points.position + points.normal * SURFACE_OFFSET, directions)
    near = np.flatnonzero((hits.triangle >= 0) & (hits.distance < NEAR) & (dot(hits.normal, directions) < 0))
    irradiance = points.indirect.copy()
    # Towards the end of its reach the ray counts less: no rim where it ends.
    share = NEAR_STRENGTH * (1 - hits.distance[near, None] / NEAR)
    sent = np.take(baked.radiosity, surfaces.faces[hits.triangle[near], 0], axis=0)
    irradiance[near] += share * (np.minimum(sent, irradiance[near]) - irradiance[near])
    return irradiance


def _reflected(
    baked: BakedRoom, points: SurfacePoints, roughness: NDArray[np.float32], exposure: float, rng: np.random.Generator
) -> NDArray[np.float32]:
    """Radiance (N, 3) that one ray about the mirror direction finds; zeros where the surface is rough."""
    surfaces = baked.surfaces
    result = np.zeros_like(points.position)
    index = np.flatnonzero(roughness < GLOSSY_UP_TO)
    if len(index) == 0:
        return result
    normal, view, rough = points.normal[index], points.view[index], roughness[index]
    spread = (0.7 * rough**2)[:, None] * rng.standard_normal((len(index), 3), np.float32)
    directions = view - 2 * dot(view, normal)[:, None] * normal + spread
    # A ray bent below the surface would see the inside of the object.
    below = dot(directions, normal)
    directions -= np.minimum(below - 0.01, 0)[:, None] * normal
    directions = unit(directions)
    hits = surfaces.caster.hits(points.position[index] + normal * SURFACE_OFFSET, directions)
    radiance = np.tile(np.asarray(baked.room.sky, np.float32), (len(index), 1))
    found = np.flatnonzero(hits.triangle >= 0)
    hits = hits.subset(found)
    part = surfaces.part_of_face[hits.triangle]
    uv = surfaces.interpolate(surfaces.uvs, hits)
    colour = surfaces.base_colour(part, uv, REFLECTION_FOOTPRINT * surfaces.uv_density[hits.triangle])
    emission = surfaces.parts.emission[part]
    # Rough surfaces get their lamp highlights from the shadow rays.
    emission = np.where(surfaces.parts.is_lamp[part] & (rough[found] > MIRROR_UP_TO), 0, emission)
    sent = surfaces.interpolate(baked.total, hits) / np.pi
    glows = surfaces.parts.emission[part] > 0
    radiance[found] = colour * np.where(glows[:, None], emission[:, None], sent)
    result[index] = np.minimum(radiance, BRIGHTEST_REFLECTION / exposure)
    return result


def _microfacet(
    normal: NDArray[np.float32],
    view: NDArray[np.float32],
    light: NDArray[np.float32],
    roughness: NDArray[np.float32],
) -> NDArray[np.float32]:
    """GGX lobe (N,) for irradiance, without Fresnel: D times visibility (Hammon's approximation)."""
    half = unit(light - view)
    alpha2 = np.maximum(roughness**4, 1e-5)
    cosine = np.clip(dot(normal, half), 0, 1)
    distribution = alpha2 / (np.pi * (cosine**2 * (alpha2 - 1) + 1) ** 2)
    to_light = np.clip(dot(normal, light), 0, 1)
    to_eye = np.clip(-dot(normal, view), 0, 1)
    alpha = np.sqrt(alpha2)
    mixed = 2 * to_light * to_eye * (1 - alpha) + (to_light + to_eye) * alpha
    return distribution * 0.5 / np.maximum(mixed, 1e-4)
