"""A pinhole camera in a baked room: picture, instance mask and depth of one pose."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from active_perceiver.rooms.lighting import BakedRoom
from active_perceiver.rooms.raycast import Hits
from active_perceiver.rooms.shading import SurfacePoints, shade
from active_perceiver.rooms.tone import remove_noise, tone_map
from active_perceiver.rooms.vectors import dot, unit

NOTHING = -1
# Nothing in a picture is brighter than this many times white before pixels are averaged: no jagged bright edges.
BRIGHTEST = 3.0
# A picture is shaded this many rows at a time: the arrays of a band stay in the processor's cache.
BAND_ROWS = 50
# The sky and what lies outside a window are shown at most this bright: a picture, not a white hole.
BRIGHTEST_OUTSIDE = 1.3
# Neighbouring rays share their light if their surfaces differ less than this (cosine of the angle of normals).
SAME_SURFACE = 0.97


@dataclass(frozen=True, eq=False)
class Rendering:
    """What the camera sees.

    Attributes:
        image: (H, W, 3) uint8 sRGB.
        mask: (H, W) int32 index into the room's `object_names`, -1 where nothing is.
        depth: (H, W) float32 metres along the viewing axis, infinite where nothing is.
    """

    image: NDArray[np.uint8]
    mask: NDArray[np.int32]
    depth: NDArray[np.float32]


def camera_axes(heading: float, tilt: float) -> NDArray[np.float32]:
    """The camera's right, up and forward unit vectors, rows of a (3, 3) float32 array.

    Args:
        heading: degrees clockwise seen from above; 0 looks along +y, 90 along +x.
        tilt: degrees, positive looks up.
    """
    turn, lift = math.radians(heading), math.radians(tilt)
    right = [math.cos(turn), -math.sin(turn), 0.0]
    forward = [math.sin(turn) * math.cos(lift), math.cos(turn) * math.cos(lift), math.sin(lift)]
    up = np.cross(right, forward)
    return np.array([right, up, forward], np.float32)


def render(
    baked: BakedRoom,
    position: Sequence[float],
    heading: float,
    tilt: float = 0.0,
    image_size: int = 300,
    fov: float = 75.0,
    samples: int = 4,
    denoise: bool = True,
    exposure: float = 1.0,
) -> Rendering:
    """Take a picture.

    The result depends on the arguments alone, not on what was rendered before.

    Args:
        baked: the room.
        position: x, y, z of the camera in metres.
        heading: degrees clockwise seen from above; 0 looks along +y, 90 along +x.
        tilt: degrees, positive looks up.
        image_size: side of the square picture in pixels.
        fov: horizontal and vertical field of view in degrees, between 0 and 180.
        samples: rays per pixel, a square number.
        denoise: whether to remove the noise of soft shadows and reflections.
        exposure: brightness relative to the room's own exposure.

    Raises:
        ValueError: if `samples` is not a square number, or size or field of view are out of range.
    """
    grid = math.isqrt(samples)
    if samples < 1 or grid * grid != samples:
        raise ValueError(f"rays per pixel must be a square number (1, 4, 9, ...), got {samples}")
    if image_size < 1 or not 0 < fov < 180:
        raise ValueError(f"need an image size of at least 1 and a field of view in 0..180, got {image_size}, {fov}")
    surfaces = baked.surfaces
    axes = camera_axes(heading, tilt)
    rng = _view_rng(baked.seed, position, heading, tilt)
    plane, along_axis = _image_plane(image_size, fov, grid)
    right, up, forward = axes
    # Not a matrix product: its rounding depends on how many threads share it.
    directions = plane[:, :1] * right + plane[:, 1:2] * up + plane[:, 2:] * forward
    origin = np.asarray(position, np.float32)
    hits = surfaces.caster.hits(np.broadcast_to(origin, directions.shape), directions)
    mask, depth = _mask_and_depth(baked, hits, along_axis, samples)

    pixel = 2 * math.tan(math.radians(fov) / 2) / image_size / grid
    gain = baked.exposure * exposure
    layers = []
    band = BAND_ROWS * image_size * samples
    for start in range(0, len(directions), band):
        rows = slice(start, start + band)
        lit = _light(baked, hits.subset(rows), directions[rows], origin, pixel, samples, gain, rng)
        layers.append([_pixel_mean(layer, samples) for layer in lit])
    picture, albedo, normal = (
        np.concatenate(layer).reshape(image_size, image_size, 3) for layer in zip(*layers, strict=True)
    )
    if denoise:
        picture = remove_noise(picture, albedo, normal)
    side = (image_size, image_size)
    return Rendering(tone_map(picture), mask.reshape(side), depth.reshape(side))


def _pixel_mean(values: NDArray[np.float32], samples: int) -> NDArray[np.float32]:
    """Mean of each pixel's rays, (P, 3) from (P * samples, 3)."""
    total = values[0::samples].copy()
    for ray in range(1, samples):
        total += values[ray::samples]
    return total / np.float32(samples)


def _view_rng(seed: int, position: Sequence[float], heading: float, tilt: float) -> np.random.Generator:
    values = [round(float(value) * 10_000) for value in (*position, heading, tilt)]
    return np.random.default_rng([seed, *(value % 2**32 for value in values)])


@lru_cache(maxsize=4)
def _image_plane(image_size: int, fov: float, grid: int) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
    """Unit directions in the camera's frame (pixels * samples, 3), a pixel's side by side; cosine to the axis."""
    row, column = np.divmod(np.arange(grid * grid), grid)
    # A sheared grid: no two samples of a pixel share a row or a column, so edges get more steps.
    across = (column + (row + 0.5) / grid) / grid
    down = (row + (column + 0.5) / grid) / grid
    extent = math.tan(math.radians(fov) / 2)
    start = np.arange(image_size)
    x = ((start[:, None] + across) / image_size * 2 - 1) * extent
    y = (1 - (start[:, None] + down) / image_size * 2) * extent
    plane = np.empty((image_size, image_size, grid * grid, 3), np.float32)
    plane[..., 0] = x[None, :, :]
    plane[..., 1] = y[:, None, :]
    plane[..., 2] = 1
    directions = unit(plane.reshape(-1, 3))
    return directions, directions[:, 2].copy()


def _mask_and_depth(
    baked: BakedRoom, hits: Hits, along_axis: NDArray[np.float32], samples: int
) -> tuple[NDArray[np.int32], NDArray[np.float32]]:
    """For each pixel the object most of its rays hit, and the depth of the first of those rays."""
    surfaces = baked.surfaces
    seen = surfaces.parts.object_index[surfaces.part_of_face[hits.triangle]]
    seen = np.where(hits.triangle < 0, NOTHING, seen).astype(np.int32).reshape(-1, samples)
    depth = np.where(hits.triangle < 0, np.inf, hits.distance * along_axis).astype(np.float32)
    votes = np.zeros(seen.shape, np.int8)
    for ray in range(samples):
        votes += seen == seen[:, [ray]]
    winner = votes.argmax(axis=1)[:, None]
    return (
        np.take_along_axis(seen, winner, axis=1)[:, 0],
        np.take_along_axis(depth.reshape(-1, samples), winner, axis=1)[:, 0],
    )


def _light(
    baked: BakedRoom,
    hits: Hits,
    directions: NDArray[np.float32],
    origin: NDArray[np.float32],
    pixel: float,
    samples: int,
    gain: float,
    rng: np.random.Generator,
) -> tuple[NDArray[np.float32], NDArray[np.float32], NDArray[np.float32]]:
    """Exposed radiance, albedo and normal of every ray, (N, 3) each."""
    surfaces, table = baked.surfaces, baked.surfaces.parts
    sky = np.asarray(baked.room.sky, np.float32)
    sky = sky * min(1.0, BRIGHTEST_OUTSIDE / max(float(sky.max()) * gain, 1e-6))
    radiance = np.tile(sky, (len(directions), 1))
    albedo, normal = np.ones_like(radiance), np.zeros_like(radiance)
    found = np.flatnonzero(hits.triangle >= 0)
    if len(found) == 0:
        return radiance * gain, albedo, normal
    every = len(found) == len(directions)
    met = hits if every else hits.subset(found)
    view = directions if every else directions[found]
    part = surfaces.part_of_face[met.triangle]
    attributes = surfaces.interpolate(surfaces.normals_and_uvs, met)
    normals, uv = attributes[:, :3], attributes[:, 3:]
    normals = unit(normals)
    # Thin things are seen from both sides; the geometry, not the smooth normal, says from which.
    normals *= np.where(dot(met.normal, view) > 0, np.float32(-1), np.float32(1))[:, None]
    facing = np.maximum(-dot(normals, view), 0.1)
    # Levels are rounded down; a different push for each of a pixel's rays blends neighbouring ones.
    push = 2 ** ((found % samples + 0.5) / samples)
    footprint = surfaces.uv_density[met.triangle] * met.distance * pixel / np.sqrt(facing) * push
    colour = surfaces.base_colour(part, uv, footprint.astype(np.float32))

    shaded, share_of = _representatives(found, part, normals, samples)
    points = SurfacePoints(
        position=origin + view[shaded] * met.distance[shaded, None],
        normal=normals[shaded],
        view=view[shaded],
        part=part[shaded],
        colour=colour[shaded],
        indirect=surfaces.interpolate(baked.indirect, met.subset(shaded)),
    )
    matt, reflection = shade(baked, points, gain, rng)
    shown = np.where(table.is_lamp, table.emission, np.minimum(table.emission, BRIGHTEST_OUTSIDE / gain))
    glow = shown[part][:, None]
    sent = colour * matt[share_of] + reflection[share_of]
    glowing = np.flatnonzero(glow[:, 0])
    sent[glowing] = colour[glowing] * glow[glowing]
    sent = np.minimum(sent * np.float32(gain), BRIGHTEST)
    colour = np.minimum(colour, 1)
    if every:
        return sent, colour, normals
    radiance *= gain
    radiance[found], albedo[found], normal[found] = sent, colour, normals
    return radiance, albedo, normal


def _representatives(
    found: NDArray[np.int64], part: NDArray[np.int32], normals: NDArray[np.float32], samples: int
) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Which rays to light: the first of each pixel, and those that meet another surface than it.

    Returns:
        Indices of the rays to light (M,), and for each ray the row of those whose light it takes (N,).
    """
    pixel = found // samples
    first = np.flatnonzero(np.diff(pixel, prepend=-1))
    leader = np.repeat(first, np.diff(np.append(first, len(pixel))))
    alike = (part == part[leader]) & (dot(normals, normals[leader]) > SAME_SURFACE)
    chosen = np.where(alike, leader, np.arange(len(found)))
    lit = chosen == np.arange(len(found))
    return np.flatnonzero(lit), (np.cumsum(lit) - 1)[chosen]
