"""Poses from which one object of a room is seen well, drawn at random."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from active_perceiver.capture.rendered.capture_scene import SMALLEST_VISIBLE, boxes_from_mask
from indoor_rooms.free_space import clearance
from indoor_rooms.renderer.camera import NOTHING, camera_axes
from indoor_rooms.renderer.compiled import Surfaces
from indoor_rooms.renderer.lens import Lens
from indoor_rooms.room import Room

# Metres between a place and the object's middle, seen from above.
NEAREST, FARTHEST = 0.45, 2.2
# Standard deviations of how far the camera looks past the object, degrees.
TURN, NOD = 12.0, 6.0
LOWEST, HIGHEST = -50.0, 20.0
# The object's box covers at least this fraction of the image; below 0.003 it counts as neither there nor absent.
LEAST_AREA = 0.002
# A rough look, of so many pixels a side, tells whether the object is seen. It errs a little, so it asks for more.
ROUGH_SIZE = 100
ROUGH_MARGIN = 1.25
# Places drawn for each pose wanted; most lie in furniture, behind walls, or where something hides the object.
TRIES = 40


@dataclass(frozen=True)
class Eye:
    """A camera on a robot.

    Attributes:
        height: metres above the floor.
        fov: field of view in degrees.
        radius: of the robot, metres; nothing comes closer to its middle.
    """

    height: float
    fov: float
    radius: float


def poses_towards(
    room: Room, surfaces: Surfaces, target: str, eye: Eye, count: int, rng: np.random.Generator
) -> NDArray[np.float64]:
    """Draw poses that look towards an object, not quite straight at it, and see enough of it.

    Args:
        room: where the object is.
        surfaces: of the room.
        target: the object's name.
        eye: the camera.
        count: how many.
        rng: draws them.

    Returns:
        (N, 4) x, y in metres, heading, tilt in degrees; fewer than `count` if the object is hard to see.
    """
    points = np.concatenate([part.mesh.vertices for part in room.parts if part.object_name == target])
    middle = (points.min(axis=0) + points.max(axis=0)) / 2
    number = surfaces.object_names.index(target)
    poses: list[NDArray[np.float64]] = []
    for place in _free_places(room, middle[:2], eye.radius, TRIES * count, rng):
        if len(poses) == count:
            break
        x, y, z = middle - (*place, eye.height)
        heading = np.degrees(np.arctan2(x, y)) + rng.normal(0, TURN)
        tilt = np.degrees(np.arctan2(z, np.hypot(x, y))) + rng.normal(0, NOD)
        # Rounded, so that a pose in a file is the one that was photographed.
        pose = np.round([*place, heading % 360, np.clip(tilt, LOWEST, HIGHEST)], 3)
        mask = rough_mask(surfaces, pose, eye)
        area = float(np.prod(boxes_from_mask(mask, [number])[0, 2:]))
        if area >= ROUGH_MARGIN * LEAST_AREA and (mask == number).mean() >= 2 * SMALLEST_VISIBLE:
            poses.append(pose)
    return np.array(poses).reshape(-1, 4)


def _free_places(
    room: Room, middle: NDArray[np.float64], radius: float, count: int, rng: np.random.Generator
) -> NDArray[np.float64]:
    """Those of `count` places around a point where a robot may stand, (N, 2): all distances are equally likely."""
    angle, distance = rng.uniform(0, 2 * np.pi, count), rng.uniform(NEAREST, FARTHEST, count)
    places = middle + distance[:, None] * np.stack([np.sin(angle), np.cos(angle)], axis=1)
    width, depth, _ = room.size
    inside = ((places >= radius) & (places <= (width - radius, depth - radius))).all(axis=1)
    places = places[inside]
    return places[clearance(places, places, [polygon for _, polygon in room.obstacles], radius) >= radius]


def rough_mask(surfaces: Surfaces, pose: NDArray[np.float64], eye: Eye) -> NDArray[np.int32]:
    """The instance mask of a pose, (ROUGH_SIZE, ROUGH_SIZE), one ray a pixel: some milliseconds, without light."""
    x, y, heading, tilt = pose.tolist()
    position = np.array([x, y, eye.height], np.float32)
    lens = Lens(ROUGH_SIZE, eye.fov, 1, position, camera_axes(heading, tilt))
    pixels = np.arange(ROUGH_SIZE**2)
    directions, _ = lens.directions(pixels, np.zeros_like(pixels))
    triangle = surfaces.caster.hits(np.broadcast_to(position, directions.shape), directions).triangle
    objects = surfaces.parts.object_index[surfaces.part_of_face[triangle]]
    return np.where(triangle < 0, NOTHING, objects).astype(np.int32).reshape(ROUGH_SIZE, ROUGH_SIZE)
