"""Pictures as a phone takes them: an object on a table or floor in front of a wall, other things around it."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from indoor_rooms.geometry.mesh import quad, rotation, transform
from indoor_rooms.geometry.pieces import bounds, placed
from indoor_rooms.objects import OBJECTS
from indoor_rooms.renderer.camera_faults import CameraFaults
from indoor_rooms.room import Part, Room
from indoor_rooms.studio.scenery import Covering, Scenery
from indoor_rooms.studio.stage import OBJECT_RADIUS, Direction, Light, Shot, Stage, key_light, tint
from indoor_rooms.studio.subjects import Subject

FIELD_OF_VIEW = 50.0
FILL = (0.5, 0.62)
# How badly the phone is held: roll in degrees, and how far from the picture's middle the object is (1 at its edge).
ROLL = 8.0
OFF_CENTRE = 0.08
PHONE = CameraFaults(exposure=0.25, white_balance=0.06, vignette=0.06, blur=0.55, noise=0.02)
EXPOSURE = 1.6
# The ground's brightness (linear) for which that exposure is right.
MIDDLE_BRIGHTNESS = 0.35
AMBIENT = 0.35
STAGE_RADIUS = 1.6
WALL_HEIGHT = 1.4
# How far behind the object the wall stands, metres.
WALL_DISTANCE = (0.4, 0.7)
THINGS = (4, 7)
# The other things are at most this large compared with the object, in reality and in the picture.
LARGEST_THING = 0.8
# Metres between things.
GAP = 0.012
ATTEMPTS = 120


def snapshot_stage(
    subject: Subject,
    directions: Sequence[Direction],
    light: Light,
    scenery: Scenery,
    name: str,
    rng: np.random.Generator,
) -> Stage:
    """Puts an object among other things, and a phone in front of it.

    Args:
        subject: the object.
        directions: of the pictures; together they may span a quarter turn, lest one looks past the wall.
        light: the lamp.
        scenery: what the ground and the wall may be.
        name: of the stage.
        rng: chooses the rest.
    """
    shots = tuple(_by_hand(subject, direction, rng) for direction in directions)
    behind = subject.front + float(np.mean([direction.azimuth for direction in directions]))
    ground, wall = (options[int(rng.integers(len(options)))] for options in (scenery.grounds, scenery.walls))
    ground_part, wall_part = _surroundings(ground, wall, behind, subject.scale, rng)
    parts = [*subject.parts, ground_part, wall_part, *_things(subject, shots, behind, rng)]
    lamp_part, lamp = key_light(light, subject.front, float(rng.uniform(0.15, 0.35)))
    red, green, blue = tint(light.warmth)
    room = Room(
        name=name,
        size=(2 * STAGE_RADIUS, 2 * STAGE_RADIUS, WALL_HEIGHT),
        parts=(*parts, lamp_part),
        targets={subject.name: subject.category},
        sun=None,
        sky=(AMBIENT * red, AMBIENT * green, AMBIENT * blue),
        lamps=(lamp,),
        obstacles=(),
    )
    # The baked exposure makes every ground a middle grey; a phone keeps half of the difference.
    texture = ground_part.material.texture
    brightness = MIDDLE_BRIGHTNESS if texture is None else float(texture.mean())
    return Stage(room, shots, EXPOSURE * (brightness / MIDDLE_BRIGHTNESS) ** 0.5, PHONE)


def _by_hand(subject: Subject, direction: Direction, rng: np.random.Generator) -> Shot:
    x, y = rng.uniform(-OFF_CENTRE, OFF_CENTRE, 2)
    return subject.shot(
        direction, FIELD_OF_VIEW, float(rng.uniform(*FILL)), centre=(x, y), roll=float(rng.uniform(-ROLL, ROLL))
    )


def _surroundings(
    ground: Covering,
    wall: Covering,
    heading: float,
    scale: float,
    rng: np.random.Generator,
) -> tuple[Part, Part]:
    """Ground and wall, the wall across the way a camera with this heading looks; textures as large as they are."""
    distance, width = float(rng.uniform(*WALL_DISTANCE)), 2 * STAGE_RADIUS
    across, up = (width, 0.0, 0.0), (0.0, 0.0, WALL_HEIGHT)
    meshes = (
        quad((-width / 2, -width / 2, 0.0), across, (0.0, distance + width / 2, 0.0), ground[1] / scale),
        quad((-width / 2, distance, 0.0), across, up, wall[1] / scale),
    )
    flat, upright = (transform(mesh, rotate=(0.0, 0.0, -heading)) for mesh in meshes)
    return Part("ground", flat, ground[0]()), Part("wall", upright, wall[0]())


def _things(subject: Subject, shots: Sequence[Shot], heading: float, rng: np.random.Generator) -> list[Part]:
    """Other things behind and beside the object, none of its kind, none touching or hiding it."""
    parts: list[Part] = []
    standing = [_circle(subject.points)]
    kinds = [str(kind) for kind in rng.permutation(sorted(OBJECTS)) if kind != subject.category]
    wanted = int(rng.integers(THINGS[0], THINGS[1] + 1))
    for _ in range(ATTEMPTS):
        if len(standing) > wanted or not kinds:
            break
        kind = kinds.pop(0)
        pieces = OBJECTS[kind](rng)
        low, high = bounds(mesh for mesh, _ in pieces)
        largest = 2 * OBJECT_RADIUS * LARGEST_THING / float(np.linalg.norm(high - low))
        x, y = rng.uniform(-0.26, 0.26), rng.uniform(-0.06, 0.3)
        across, away, _ = rotation(about_z=-heading) @ (x, y, 0.0)
        moved = placed(pieces, (across, away, 1e-4), float(rng.uniform(0, 360)), min(subject.scale, largest))
        points = np.concatenate([mesh.vertices for mesh, _ in moved])
        circle = _circle(points)
        if all(_apart(circle, other) for other in standing) and _stays_aside(points, subject.points, shots):
            standing.append(circle)
            parts += [Part(f"{kind} beside", mesh, material) for mesh, material in moved]
        else:
            kinds.append(kind)
    return parts


def _circle(points: NDArray[np.float64]) -> NDArray[np.float64]:
    """(3,) x, y and radius of a circle around points, seen from above."""
    middle = (points[:, :2].min(axis=0) + points[:, :2].max(axis=0)) / 2
    return np.array([*middle, np.linalg.norm(points[:, :2] - middle, axis=1).max()])


def _apart(one: NDArray[np.float64], other: NDArray[np.float64]) -> bool:
    return bool(np.hypot(*(one[:2] - other[:2])) > one[2] + other[2] + GAP)


def _stays_aside(points: NDArray[np.float64], subject: NDArray[np.float64], shots: Sequence[Shot]) -> bool:
    """Whether a thing is in one of the pictures, and in none before the object or as large as it."""
    seen = False
    for shot in shots:
        thing, whole = shot.project(points), shot.project(subject)
        low, high = (np.clip(corner, -1, 1) for corner in (thing.min(axis=0)[:2], thing.max(axis=0)[:2]))
        first, last = whole.min(axis=0), whole.max(axis=0)
        overlaps = bool((low < last[:2] + 0.03).all() and (high > first[:2] - 0.03).all())
        if thing[:, 2].min() < 0.05 or (overlaps and thing[:, 2].min() < last[2]):
            return False
        if np.prod(high - low) > LARGEST_THING * np.prod((last - first)[:2]):
            return False
        seen = seen or bool(np.prod(high - low) > 0.01)
    return seen
