"""A pinhole camera in a baked room: picture, instance mask and depth of one pose."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from indoor_rooms.renderer.lens import Lens, PixelRays, RayHits, meet
from indoor_rooms.renderer.lighting import BakedRoom
from indoor_rooms.renderer.pixels import light_pixels
from indoor_rooms.renderer.tone import remove_noise, tone_map

NOTHING = -1
# Neighbouring rays meet one surface if their normals differ less than this (cosine of the angle).
SAME_SURFACE = 0.97
_ALL, _BUT_LAST, _BUT_FIRST = slice(None), slice(None, -1), slice(1, None)
# Pixels and their neighbours to the right, below, and below on either side.
_NEIGHBOURS = (
    ((_ALL, _BUT_LAST), (_ALL, _BUT_FIRST)),
    ((_BUT_LAST, _ALL), (_BUT_FIRST, _ALL)),
    ((_BUT_LAST, _BUT_LAST), (_BUT_FIRST, _BUT_FIRST)),
    ((_BUT_LAST, _BUT_FIRST), (_BUT_FIRST, _BUT_LAST)),
)


@dataclass(frozen=True)
class Quality:
    """How much is computed for each pixel.

    Attributes:
        samples: rays per pixel, a square number.
        denoise: whether to remove the noise of soft shadows and reflections.

    Raises:
        ValueError: if `samples` is not a square number.
    """

    samples: int = 4
    denoise: bool = True

    def __post_init__(self) -> None:
        if self.samples < 1 or math.isqrt(self.samples) ** 2 != self.samples:
            raise ValueError(f"rays per pixel must be a square number (1, 4, 9, ...), got {self.samples}")


USUAL_QUALITY = Quality()


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
    exposure: float = 1.0,
    quality: Quality = USUAL_QUALITY,
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
        exposure: brightness relative to the room's own exposure.
        quality: how much is computed for each pixel.

    Raises:
        ValueError: if size or field of view are out of range.
    """
    if image_size < 1 or not 0 < fov < 180:
        raise ValueError(f"need an image size of at least 1 and a field of view in 0..180, got {image_size}, {fov}")
    rng = _view_rng(baked.seed, position, heading, tilt)
    lens = Lens(
        image_size, fov, math.isqrt(quality.samples), np.asarray(position, np.float32), camera_axes(heading, tilt)
    )
    rays = _cast(baked, lens)
    picture, albedo, normal = light_pixels(baked, lens, rays, baked.exposure * exposure, rng)
    mask, depth = _mask_and_depth(baked, rays)
    side = (image_size, image_size)
    picture, albedo, normal = (layer.reshape(*side, 3) for layer in (picture, albedo, normal))
    if quality.denoise:
        picture = remove_noise(picture, albedo, normal)
    return Rendering(tone_map(picture), mask.reshape(side), depth.reshape(side))


def _view_rng(seed: int, position: Sequence[float], heading: float, tilt: float) -> np.random.Generator:
    values = [round(float(value) * 10_000) for value in (*position, heading, tilt)]
    return np.random.default_rng([seed, *(value % 2**32 for value in values)])


def _cast(baked: BakedRoom, lens: Lens) -> PixelRays:
    """One ray for each pixel, and all its rays where it or its neighbours see an edge."""
    pixels = np.arange(lens.image_size**2)
    # Neighbouring pixels use different spots of theirs: what is thinner than a pixel is not missed.
    row, column = np.divmod(pixels, lens.image_size)
    spot = (row + column) % lens.grid**2
    first = meet(baked.surfaces, lens, pixels, spot)
    samples = lens.grid**2
    edges = np.flatnonzero(_edges(first, lens)) if samples > 1 else pixels[:0]
    further = (spot[edges, None] + np.arange(1, samples)) % samples
    return PixelRays(first, edges, meet(baked.surfaces, lens, np.repeat(edges, samples - 1), further.ravel()))


def _edges(met: RayHits, lens: Lens) -> NDArray[np.bool_]:
    """Whether a pixel or one of its eight neighbours sees an edge between them, (P,)."""
    side = (lens.image_size, lens.image_size)
    part, reach = met.part.reshape(side), (met.distance * np.float32(lens.pixel)).reshape(side)
    normal, place = ([column.reshape(side) for column in array.T] for array in (met.normal, met.position))
    edges = np.zeros(side, bool)
    for here, there in _NEIGHBOURS:
        differ = part[here] != part[there]
        alike = sum(axis[here] * axis[there] for axis in normal)
        differ |= alike < SAME_SURFACE
        # One surface behind another of the same part, facing the same way.
        step = sum(axis[here] * (spot[there] - spot[here]) for axis, spot in zip(normal, place, strict=True))
        differ |= np.abs(step) > reach[here]
        edges[here] |= differ
        edges[there] |= differ
    return edges.ravel()


def _mask_and_depth(baked: BakedRoom, rays: PixelRays) -> tuple[NDArray[np.int32], NDArray[np.float32]]:
    """For each pixel the object most of its rays hit, and the depth of one of those rays."""
    objects = np.append(baked.surfaces.parts.object_index, NOTHING).astype(np.int32)
    mask, depth = objects[rays.first.part], rays.first.depth.copy()
    count = len(rays.edges)
    if count:
        seen = np.column_stack([mask[rays.edges], objects[rays.further.part].reshape(count, -1)])
        depths = np.column_stack([depth[rays.edges], rays.further.depth.reshape(count, -1)])
        votes = np.zeros(seen.shape, np.int8)
        for ray in range(seen.shape[1]):
            votes += seen == seen[:, [ray]]
        winner = votes.argmax(axis=1)
        mask[rays.edges] = seen[np.arange(count), winner]
        depth[rays.edges] = depths[np.arange(count), winner]
    return mask, depth
