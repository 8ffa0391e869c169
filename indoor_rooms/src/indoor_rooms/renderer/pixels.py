"""From the camera's rays to the light of its pixels: several rays where there are edges, one elsewhere."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from indoor_rooms.renderer.compiled import Surfaces
from indoor_rooms.renderer.lens import Lens, PixelRays, RayHits
from indoor_rooms.renderer.lighting import BakedRoom
from indoor_rooms.renderer.shading import SurfacePoints, shade
from indoor_rooms.renderer.vectors import columns, dot, put, rows

# Nothing in a picture is brighter than this many times white before pixels are averaged: no jagged bright edges.
BRIGHTEST = 3.0
# So many points are shaded at a time: their arrays stay in the processor's cache.
BAND = 32_768
# The sky and what lies outside a window are shown at most this bright: a picture, not a white hole.
BRIGHTEST_OUTSIDE = 1.3
# A pixel with one ray reads textures at two places along the longer side of what it covers: how far from its centre
# in pixels, and how wide a texel may be; the two levels of detail are blended.
PROBES = ((-0.25, 0.545), (0.25, 0.77))
# Rays of a pixel share their light if their surfaces differ less than this (cosine of the angle of normals).
SAME_LIGHT = 0.97


def light_pixels(
    baked: BakedRoom, lens: Lens, rays: PixelRays, gain: float, rng: np.random.Generator
) -> tuple[NDArray[np.float32], NDArray[np.float32], NDArray[np.float32]]:
    """Exposed radiance, albedo and normal of every pixel, (P, 3) each.

    Args:
        baked: the room.
        lens: of the camera.
        rays: what it sees.
        gain: exposure.
        rng: of soft shadows and glossy reflections.
    """
    first, further = rays.first, rays.further
    one = np.ones(len(first.part), bool)
    one[rays.edges] = False
    one = np.flatnonzero(one)
    colour = np.zeros_like(first.view)
    several = _colour(baked.surfaces, lens, first, rays.edges)
    if lens.grid > 1:
        single = _pixel_colour(baked.surfaces, lens, first, one)
    else:
        single = _colour(baked.surfaces, lens, first, one)
    put(colour, rays.edges, several)
    put(colour, one, single)
    matt, reflection = _light(baked, first, colour, np.flatnonzero(first.part >= 0), gain, rng)
    layers = (
        _sent(baked, first.part, colour, matt, reflection, gain),
        np.minimum(colour, 1),
        first.normal.copy(order="K"),
    )
    _show_sky(baked, first.part, layers, gain)
    if len(rays.edges):
        leader = np.repeat(rays.edges, lens.grid**2 - 1)
        colour = _colour(baked.surfaces, lens, further, np.arange(len(further.part)))
        alike = further.part == first.part[leader]
        alike &= dot(further.normal, rows(first.normal, leader)) > SAME_LIGHT
        matt, reflection = rows(matt, leader), rows(reflection, leader)
        own = np.flatnonzero(~alike & (further.part >= 0))
        own_light = _light(baked, further, colour, own, gain, rng)
        for target, source in zip((matt, reflection), own_light, strict=True):
            put(target, own, rows(source, own))
        more = _sent(baked, further.part, colour, matt, reflection, gain), np.minimum(colour, 1), further.normal
        _show_sky(baked, further.part, more, gain)
        for layer, extra in zip(layers, more, strict=True):
            for channel in range(3):
                total = layer[rays.edges, channel] + extra[:, channel].reshape(len(rays.edges), -1).sum(axis=1)
                layer[rays.edges, channel] = total / np.float32(lens.grid**2)
    return layers


def _colour(surfaces: Surfaces, lens: Lens, met: RayHits, index: NDArray[np.int64]) -> NDArray[np.float32]:
    """Base colour at the points that rays `index` (M,) met, (M, 3)."""
    # Levels are rounded down; a different push for each of a pixel's rays blends neighbouring ones.
    samples = lens.grid**2
    push = (2 ** ((np.arange(samples) + 0.5) / samples) / lens.grid).astype(np.float32)
    footprint = _footprint(surfaces, lens, met, index) * push[met.spot[index]]
    return surfaces.base_colour(met.part[index], rows(met.uv, index), footprint)


def _footprint(surfaces: Surfaces, lens: Lens, met: RayHits, index: NDArray[np.int64]) -> NDArray[np.float32]:
    """Width in uv units of what the pixels of rays `index` (M,) cover, (M,)."""
    facing = np.maximum(-dot(rows(met.normal, index), rows(met.view, index)), np.float32(0.1))
    width = surfaces.uv_density[met.hits.triangle[index]] * met.distance[index] * np.float32(lens.pixel)
    return np.asarray(width / np.sqrt(facing), np.float32)


def _pixel_colour(surfaces: Surfaces, lens: Lens, met: RayHits, index: NDArray[np.int64]) -> NDArray[np.float32]:
    """Base colour (M, 3) averaged over the pixels of rays `index` (M,), which see one surface each."""
    colour = rows(surfaces.parts.colour, met.part[index])
    textured = np.flatnonzero((met.part[index] >= 0) & (surfaces.parts.texture[met.part[index]] >= 0))
    if len(textured) == 0:
        return colour
    index = index[textured]
    right, down = _growth(surfaces, lens, met, index)
    wide = right[0] ** 2 + right[1] ** 2 > down[0] ** 2 + down[1] ** 2
    centre = [np.float32(0.5) - place for place in lens.spots[:, met.spot[index]]]
    footprint = _footprint(surfaces, lens, met, index)
    total = np.zeros_like(rows(colour, textured))
    for offset, level in PROBES:
        x = centre[0] + np.where(wide, np.float32(offset), np.float32(0))
        y = centre[1] + np.where(wide, np.float32(0), np.float32(offset))
        uv = columns(*(met.uv[index, axis] + right[axis] * x + down[axis] * y for axis in range(2)))
        total += surfaces.base_colour(met.part[index], uv, footprint * np.float32(level))
    put(colour, textured, total / np.float32(len(PROBES)))
    return colour


def _growth(
    surfaces: Surfaces, lens: Lens, met: RayHits, index: NDArray[np.int64]
) -> list[list[NDArray[np.float32]]]:
    """How u and v (M,) each change over one pixel to the right, and over one pixel down, at rays `index` (M,)."""
    view, normal = rows(met.view, index), rows(met.hits.normal, index)
    away = dot(view, normal)
    away = np.where(np.abs(away) < 1e-9, np.float32(1e-9), away)
    scale = met.depth[index] * np.float32(lens.pixel)
    gradients = np.take(surfaces.uv_gradients, met.hits.triangle[index], axis=0)
    growth = []
    for axis in (lens.axes[0], -lens.axes[1]):
        # The ray's end slides along the surface: sideways with the pixel, and along the ray to stay on it.
        slide = dot(normal, axis[None]) / away
        both = (gradients[:, :3], gradients[:, 3:])
        growth.append([(dot(gradient, axis[None]) - dot(gradient, view) * slide) * scale for gradient in both])
    return growth


def _light(
    baked: BakedRoom,
    met: RayHits,
    colour: NDArray[np.float32],
    index: NDArray[np.int64],
    gain: float,
    rng: np.random.Generator,
) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
    """Light for the base colour, and radiance reflected, at rays `index`; zeros elsewhere. (N, 3) each."""
    matt, reflection = np.zeros_like(colour), np.zeros_like(colour)
    for start in range(0, len(index), BAND):
        band = index[start : start + BAND]
        hits = met.hits.subset(band)
        points = SurfacePoints(
            position=rows(met.position, band),
            normal=rows(met.normal, band),
            view=rows(met.view, band),
            part=met.part[band],
            colour=rows(colour, band),
            indirect=baked.surfaces.interpolate(baked.indirect, hits),
            vertex=baked.surfaces.faces[hits.triangle, 0],
        )
        for target, source in zip((matt, reflection), shade(baked, points, gain, rng), strict=True):
            put(target, band, source)
    return matt, reflection


def _sent(
    baked: BakedRoom,
    part: NDArray[np.int32],
    colour: NDArray[np.float32],
    matt: NDArray[np.float32],
    reflection: NDArray[np.float32],
    gain: float,
) -> NDArray[np.float32]:
    """Exposed radiance towards the camera, (N, 3)."""
    table = baked.surfaces.parts
    glow = np.where(table.is_lamp, table.emission, np.minimum(table.emission, np.float32(BRIGHTEST_OUTSIDE / gain)))
    sent = colour * matt
    sent += reflection
    glowing = np.flatnonzero(glow[part])
    put(sent, glowing, rows(colour, glowing) * glow[part[glowing]][:, None])
    sent *= np.float32(gain)
    return np.minimum(sent, np.float32(BRIGHTEST), out=sent)


def _show_sky(
    baked: BakedRoom,
    part: NDArray[np.int32],
    layers: tuple[NDArray[np.float32], NDArray[np.float32], NDArray[np.float32]],
    gain: float,
) -> None:
    """Radiance, albedo and normal where nothing was hit."""
    missed = part < 0
    if missed.any():
        sky = np.asarray(baked.room.sky, np.float32) * np.float32(gain)
        radiance, albedo, normal = layers
        radiance[missed] = sky * min(1.0, BRIGHTEST_OUTSIDE / max(float(sky.max()), 1e-6))
        albedo[missed], normal[missed] = 1, 0
