"""What every picture of an object needs: a stage with a light, and a hand-held camera aimed at the object."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from indoor_rooms.geometry.mesh import Vector, quad
from indoor_rooms.materials.material import Material
from indoor_rooms.renderer.camera import Rendering, camera_axes, render
from indoor_rooms.renderer.camera_faults import CameraFaults
from indoor_rooms.renderer.lighting import BakedRoom
from indoor_rooms.room import Lamp, Part, Room

# Objects are scaled to this radius, so that one stage fits all; metres.
OBJECT_RADIUS = 0.1
LAMP_DISTANCE = 0.9


@dataclass(frozen=True)
class Direction:
    """From where an object is photographed.

    Attributes:
        azimuth: degrees by which the camera is turned from looking at the object's front, clockwise from above.
        rise: 0..1, between the lowest and the highest elevation from which the object shows its shape.
    """

    azimuth: float
    rise: float


@dataclass(frozen=True)
class Light:
    """A soft key light and the light all around.

    Attributes:
        azimuth: degrees, as in `Direction`: 0 shines on the object's front.
        height: degrees above the ground.
        warmth: how much more red and less blue than white, a fraction; negative is cool.
        strength: of the key light compared with that of the surroundings.
    """

    azimuth: float
    height: float
    warmth: float
    strength: float = 1.4


@dataclass(frozen=True)
class Shot:
    """One pose of a hand-held camera; `heading`, `tilt` and `fov` as in `camera.render`, `roll` in degrees."""

    position: Vector
    heading: float
    tilt: float
    fov: float
    roll: float = 0.0

    def project(self, points: NDArray[np.float64]) -> NDArray[np.float64]:
        """Where points (N, 3) appear without roll: x and y, -1..1 within the picture, and depth in metres, (N, 3)."""
        offset = (points - np.asarray(self.position)) @ camera_axes(self.heading, self.tilt).astype(np.float64).T
        return np.column_stack([offset[:, :2] / offset[:, 2:] / math.tan(math.radians(self.fov) / 2), offset[:, 2]])


@dataclass(frozen=True)
class Stage:
    """What is photographed and how.

    Attributes:
        room: the object and all around it.
        shots: from where, one a picture.
        exposure: as in `camera.render`.
        faults: of the camera, in a picture of 300 pixels a side; None for a good one.
    """

    room: Room
    shots: tuple[Shot, ...]
    exposure: float
    faults: CameraFaults | None = None


def aim(
    points: NDArray[np.float64],
    heading: float,
    elevation: float,
    fov: float,
    fill: float,
    centre: tuple[float, float] = (0.0, 0.0),
    roll: float = 0.0,
) -> Shot:
    """A camera that looks in a direction and sees some points together.

    Args:
        points: (N, 3) metres.
        heading: degrees clockwise from above, 0 looks along +y.
        elevation: degrees above the horizon from which it looks down.
        fov: degrees.
        fill: share of the picture's side that the larger of the points' width and height takes.
        centre: x and y of their middle in the picture, each -1..1.
        roll: degrees.
    """
    right, up, forward = camera_axes(heading, -elevation).astype(np.float64)
    extent = math.tan(math.radians(fov) / 2)
    position = points.mean(axis=0) - 6 * OBJECT_RADIUS * forward
    for _ in range(8):
        x, y, depth = Shot(_triple(position), heading, -elevation, fov).project(points).T
        middle = (x.max() + x.min()) / 2 - centre[0], (y.max() + y.min()) / 2 - centre[1]
        filled = max(x.max() - x.min(), y.max() - y.min()) / 2
        distance = float(depth.mean())
        position = position + distance * extent * (middle[0] * right + middle[1] * up)
        position = position + forward * distance * (1 - filled / fill)
    return Shot(_triple(position), heading % 360, -elevation, fov, roll)


def take(baked: BakedRoom, shot: Shot, image_size: int, exposure: float) -> Rendering:
    """Takes a picture; with roll it is cut out of a larger, upright one."""
    turn = math.radians(abs(shot.roll))
    # Even, so that the middle of both pictures is the same.
    margin = 2 * math.ceil(image_size * (math.cos(turn) + math.sin(turn) - 1) / 2)
    side = image_size + margin
    fov = math.degrees(2 * math.atan(math.tan(math.radians(shot.fov) / 2) * side / image_size))
    upright = render(baked, shot.position, shot.heading, shot.tilt, side, fov, exposure=exposure)
    if shot.roll == 0:
        return upright
    cut = slice(margin // 2, margin // 2 + image_size)

    def turned(layer: NDArray[Any], how: Image.Resampling) -> NDArray[Any]:
        return np.array(Image.fromarray(layer).rotate(shot.roll, how))[cut, cut]

    sharp = Image.Resampling.NEAREST
    return Rendering(
        turned(upright.image, Image.Resampling.BICUBIC), turned(upright.mask, sharp), turned(upright.depth, sharp)
    )


def key_light(light: Light, front: float, size: float) -> tuple[Part, Lamp]:
    """A square area light that shines on the origin, as a part to be seen and a lamp.

    Args:
        light: where it is and how it shines.
        front: heading of a camera that looks at the object's front, degrees.
        size: its side in metres; small ones throw harder shadows.
    """
    side, across, forward = camera_axes(front + light.azimuth, -light.height).astype(np.float64)
    centre, first, second = -LAMP_DISTANCE * forward, size * side, -size * across
    red, green, blue = tint(light.warmth)
    radiance = light.strength / size**2
    name = "key light"
    mesh = quad(_triple(centre - first / 2 - second / 2), _triple(first), _triple(second))
    return (
        Part(name, mesh, Material((red, green, blue), emission=radiance)),
        Lamp(
            name,
            _triple(centre),
            (_triple(first), _triple(second)),
            0.0,
            (red * radiance, green * radiance, blue * radiance),
        ),
    )


def tint(warmth: float) -> tuple[float, float, float]:
    """Linear RGB of white light made warmer or cooler."""
    return (1 + warmth, 1.0, 1 - warmth)


def _triple(vector: NDArray[np.float64]) -> Vector:
    x, y, z = (float(value) for value in vector)
    return (x, y, z)
