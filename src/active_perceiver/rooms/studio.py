"""Pictures of an object on its own, as a user would give them: plain background, other light than the room's."""

from __future__ import annotations

import math
import zlib
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from active_perceiver.errors import UserError
from active_perceiver.rooms.camera import camera_axes, render
from active_perceiver.rooms.curves import lathe
from active_perceiver.rooms.geometry import quad, transform
from active_perceiver.rooms.lighting import bake
from active_perceiver.rooms.materials import Material
from active_perceiver.rooms.room import Lamp, Part, Room

# Objects are scaled to this radius, so that one studio fits all; metres.
OBJECT_RADIUS = 0.1
FIELD_OF_VIEW = 30.0
FILL = 0.66
SETUPS = 4
PICTURES_PER_SETUP = 2
PICTURES = SETUPS * PICTURES_PER_SETUP
ELEVATIONS = (10.0, 45.0)
BAKE_RAYS = 32
# Product pictures are brighter than rooms: the background is to be a light grey.
EXPOSURE = 3.0
COVE_RADIUS = 1.3
COVE_HEIGHT = 1.2


class TargetError(UserError, ValueError):
    """A target the room does not hold."""


@dataclass(frozen=True)
class _View:
    heading: float
    tilt: float


def studio_pictures(room: Room, target: str, setup: int, seed: int, image_size: int = 300) -> list[NDArray[np.uint8]]:
    """Photograph one of a room's objects alone.

    Args:
        room: which holds the object.
        target: the object's name.
        setup: number of the lighting, 0 to `SETUPS` - 1.
        seed: of light, background and directions.
        image_size: side of the pictures in pixels.

    Returns:
        `PICTURES_PER_SETUP` pictures, (image_size, image_size, 3) uint8.

    Raises:
        TargetError: if the room has no such object.
    """
    parts = _on_stage([part for part in room.parts if part.object_name == target], room.name, target)
    rng = np.random.default_rng([seed, setup, zlib.crc32(target.encode())])
    stage = _stage(parts, f"{room.name}-{target}-{setup}", rng)
    baked = bake(stage, rays=BAKE_RAYS, bounces=3, seed=seed)
    points = np.concatenate([part.mesh.vertices for part in parts])
    start = rng.uniform(0, 360)
    pictures = []
    for number in range(PICTURES_PER_SETUP):
        # All pictures together go round the object once, from low and high by turns.
        turn = start / SETUPS + (number * SETUPS + setup) * 360 / PICTURES
        low, high = ELEVATIONS
        elevation = low + (high - low) * ((number + setup / SETUPS + 0.25 * rng.random()) % PICTURES_PER_SETUP) / 2
        view = _View(turn % 360, -elevation)
        position = _camera_position(points, view)
        picture = render(baked, position, view.heading, view.tilt, image_size, FIELD_OF_VIEW, exposure=EXPOSURE)
        pictures.append(picture.image)
    return pictures


def _on_stage(parts: list[Part], room_name: str, target: str) -> list[Part]:
    """The object's parts scaled to `OBJECT_RADIUS` and put upright on the ground at the origin."""
    if not parts:
        raise TargetError(f"room '{room_name}' has no object '{target}'; correct its list of targets")
    points = np.concatenate([part.mesh.vertices for part in parts])
    low, high = points.min(axis=0), points.max(axis=0)
    scale = 2 * OBJECT_RADIUS / float(np.linalg.norm(high - low))
    middle = (low + high) / 2
    # A hair above the ground: coplanar faces would flicker.
    offset = (-scale * middle[0], -scale * middle[1], -scale * low[2] + 2e-4)
    return [replace(part, mesh=transform(part.mesh, offset=offset, scale=scale)) for part in parts]


def _stage(parts: list[Part], name: str, rng: np.random.Generator) -> Room:
    """A round, seamless backdrop, open above, with one soft key light."""
    grey = rng.uniform(0.62, 0.85)
    tint = 1 + 0.035 * rng.standard_normal(3)
    red, green, blue = (float(value) for value in np.clip(grey * tint, 0.5, 0.9))
    bend = [
        (COVE_RADIUS - 0.3 + 0.3 * math.sin(angle), 0.3 - 0.3 * math.cos(angle))
        for angle in np.linspace(0, math.pi / 2, 8)
    ]
    cove = lathe([(COVE_RADIUS, COVE_HEIGHT), *reversed(bend), (1e-4, 0.0)], segments=40)
    direction, height = rng.uniform(0, 2 * math.pi), math.radians(rng.uniform(40, 70))
    towards = np.array(
        [math.cos(direction) * math.cos(height), math.sin(direction) * math.cos(height), math.sin(height)]
    )
    side = np.array([-math.sin(direction), math.cos(direction), 0.0])
    across = np.cross(side, towards)  # so that the light faces the origin
    size = rng.uniform(0.15, 0.4)
    centre, first, second = 0.9 * towards, size * side, size * across
    warmth = rng.uniform(-0.12, 0.12)
    colour = (1 + warmth, 1.0, 1 - warmth)
    radiance = rng.uniform(0.8, 2.0) / size**2
    corner = centre - first / 2 - second / 2
    lamp_mesh = quad(_triple(corner), _triple(first), _triple(second))
    key = Lamp(
        "key light",
        _triple(centre),
        (_triple(first), _triple(second)),
        0.0,
        (colour[0] * radiance, colour[1] * radiance, colour[2] * radiance),
    )
    return Room(
        name=name,
        size=(2 * COVE_RADIUS, 2 * COVE_RADIUS, COVE_HEIGHT),
        parts=(
            *parts,
            Part("backdrop", cove, Material((red, green, blue), roughness=0.95, specular=0.1)),
            Part("key light", lamp_mesh, Material(colour, emission=radiance)),
        ),
        targets={},
        sun=None,
        sky=(1.0, 1.0, 1.0),
        lamps=(key,),
        obstacles=(),
    )


def _triple(vector: NDArray[np.float64]) -> tuple[float, float, float]:
    x, y, z = (float(value) for value in vector)
    return (x, y, z)


def _camera_position(points: NDArray[np.float64], view: _View) -> tuple[float, float, float]:
    """Where a camera with this direction has the points in the middle, filling `FILL` of the picture."""
    right, up, forward = camera_axes(view.heading, view.tilt).astype(np.float64)
    extent = math.tan(math.radians(FIELD_OF_VIEW) / 2)
    position = points.mean(axis=0) - 6 * OBJECT_RADIUS * forward
    for _ in range(8):
        offset = points - position
        depth = offset @ forward
        x, y = offset @ right / depth / extent, offset @ up / depth / extent
        middle = (x.max() + x.min()) / 2, (y.max() + y.min()) / 2
        fill = max(x.max() - x.min(), y.max() - y.min()) / 2
        distance = float(depth.mean())
        position = position + distance * extent * (middle[0] * right + middle[1] * up)
        position = position + forward * distance * (1 - fill / FILL)
    return _triple(position)
