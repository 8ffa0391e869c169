"""Pictures of an object as a user would give them: alone on a plain background, or among other things by phone.

The setups from `TRAINING_SETUPS` on are held out: they share no light, no background and no direction with those
before.
"""

from __future__ import annotations

import math
import zlib
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from indoor_rooms.errors import RoomError
from indoor_rooms.geometry.curves import lathe
from indoor_rooms.materials.material import Colour, Material
from indoor_rooms.renderer.camera_faults import with_faults
from indoor_rooms.renderer.lighting import bake
from indoor_rooms.room import Part, Room
from indoor_rooms.studio.scenery import HELD_OUT_SCENERY, TRAINING_SCENERY, Scenery
from indoor_rooms.studio.snapshots import snapshot_stage
from indoor_rooms.studio.stage import Direction, Light, Stage, key_light, take
from indoor_rooms.studio.subjects import Subject, on_stage

FIELD_OF_VIEW = 30.0
FILL = 0.66
BAKE_RAYS = 32
BOUNCES = 3
# Product pictures are brighter than rooms; right for a background that reflects this share of the light.
EXPOSURE = 3.0
USUAL_BACKGROUND = 0.73
COVE_RADIUS = 1.3
COVE_HEIGHT = 1.2
# All of an object's pictures are turned together by up to this many degrees, for each object another.
TURN = 9.0


class TargetError(RoomError, ValueError):
    """A target the room does not hold."""


@dataclass(frozen=True)
class PictureSetup:
    """An arrangement in which an object is photographed.

    Attributes:
        directions: from where, one a picture.
        light: the lamp.
        background: colours (linear RGB) a plain one may have, or what may be around the object in a phone picture.
    """

    directions: tuple[Direction, ...]
    light: Light
    background: tuple[Colour, ...] | Scenery


TRAINING = (
    PictureSetup(
        (Direction(0, 0.15), Direction(-105, 0.6)),
        Light(azimuth=-50, height=50, warmth=0.0),
        ((0.78, 0.78, 0.78), (0.85, 0.85, 0.84)),
    ),
    PictureSetup(
        (Direction(42, 0.75), Direction(170, 0.3)),
        Light(azimuth=65, height=62, warmth=0.10),
        ((0.66, 0.65, 0.62), (0.72, 0.71, 0.69)),
    ),
    PictureSetup(
        (Direction(-52, 0.35), Direction(110, 0.85)),
        Light(azimuth=10, height=72, warmth=-0.10),
        ((0.55, 0.57, 0.6), (0.62, 0.63, 0.65)),
    ),
    PictureSetup(
        (Direction(22, 0.5), Direction(-28, 0.9)), Light(azimuth=40, height=48, warmth=0.16), TRAINING_SCENERY
    ),
)
HELD_OUT_PLAIN_COLOURS = ((0.30, 0.48, 0.62), (0.62, 0.42, 0.32), (0.40, 0.55, 0.36), (0.66, 0.58, 0.34))
HELD = (
    PictureSetup(
        (Direction(62, 0.25), Direction(-66, 0.15)),
        Light(azimuth=-95, height=42, warmth=0.2),
        HELD_OUT_PLAIN_COLOURS,
    ),
    PictureSetup(
        (Direction(-14, 0.6), Direction(34, 0.2)), Light(azimuth=-25, height=60, warmth=-0.16), HELD_OUT_SCENERY
    ),
)
TRAINING_SETUPS = len(TRAINING)
HELD_OUT_SETUPS = len(HELD)
SETUPS = TRAINING_SETUPS + HELD_OUT_SETUPS
PICTURES_PER_SETUP = 2
PICTURES = SETUPS * PICTURES_PER_SETUP
HELD_OUT = HELD_OUT_SETUPS * PICTURES_PER_SETUP


def studio_pictures(room: Room, target: str, setup: int, seed: int, image_size: int = 300) -> list[NDArray[np.uint8]]:
    """Photograph one of a room's objects away from the room.

    The pictures depend on the object, its name, the setup and the seed alone.

    Args:
        room: which holds the object.
        target: the object's name.
        setup: number of the arrangement, 0 to `SETUPS` - 1; the last `HELD_OUT_SETUPS` are not for training.
        seed: of light, background and directions.
        image_size: side of the pictures in pixels.

    Returns:
        `PICTURES_PER_SETUP` pictures, (image_size, image_size, 3) uint8.

    Raises:
        TargetError: if the room has no such object.
        ValueError: if there is no such setup.
    """
    stage = picture_stage(room, target, setup, seed)
    baked = bake(stage.room, rays=BAKE_RAYS, bounces=BOUNCES, seed=seed)
    pictures = [take(baked, shot, image_size, stage.exposure).image for shot in stage.shots]
    if stage.faults is None:
        return pictures
    faults = replace(stage.faults, blur=stage.faults.blur * image_size / 300)
    rng = np.random.default_rng([seed, zlib.crc32(target.encode()), setup, len(pictures)])
    return [with_faults(picture, faults, rng) for picture in pictures]


def picture_stage(room: Room, target: str, setup: int, seed: int) -> Stage:
    """What `studio_pictures` photographs and from where; the object has its own name there.

    Raises:
        TargetError: if the room has no such object.
        ValueError: if there is no such setup.
    """
    if not 0 <= setup < SETUPS:
        raise ValueError(f"setups are 0 to {SETUPS - 1}, got {setup}")
    parts = [part for part in room.parts if part.object_name == target]
    if not parts:
        raise TargetError(f"room '{room.name}' has no object '{target}'; correct its list of targets")
    name = zlib.crc32(target.encode())
    turn = float(np.random.default_rng([seed, name]).uniform(-TURN, TURN))
    subject = on_stage(parts, target, room.targets.get(target, target), turn)
    arrangement = (*TRAINING, *HELD)[setup]
    rng = np.random.default_rng([seed, name, setup])
    label = f"{target}-{setup}"
    if isinstance(arrangement.background, Scenery):
        return snapshot_stage(subject, arrangement.directions, arrangement.light, arrangement.background, label, rng)
    return _cove_stage(subject, arrangement.directions, arrangement.light, arrangement.background, label, rng)


def _cove_stage(
    subject: Subject,
    directions: tuple[Direction, ...],
    light: Light,
    backgrounds: tuple[Colour, ...],
    name: str,
    rng: np.random.Generator,
) -> Stage:
    """A round, seamless backdrop, open above, with one soft key light."""
    colour = np.array(backgrounds[int(rng.integers(len(backgrounds)))])
    colour = np.clip(colour * (1 + 0.03 * rng.standard_normal(3)), 0.05, 0.9)
    red, green, blue = (float(value) for value in colour)
    bend = [
        (COVE_RADIUS - 0.3 + 0.3 * math.sin(angle), 0.3 - 0.3 * math.cos(angle))
        for angle in np.linspace(0, math.pi / 2, 8)
    ]
    cove = lathe([(COVE_RADIUS, COVE_HEIGHT), *reversed(bend), (1e-4, 0.0)], segments=40)
    lamp_part, lamp = key_light(light, subject.front, float(rng.uniform(0.15, 0.4)))
    room = Room(
        name=name,
        size=(2 * COVE_RADIUS, 2 * COVE_RADIUS, COVE_HEIGHT),
        parts=(
            *subject.parts,
            Part("backdrop", cove, Material((red, green, blue), roughness=0.95, specular=0.1)),
            lamp_part,
        ),
        targets={subject.name: subject.category},
        sun=None,
        sky=(1.0, 1.0, 1.0),
        lamps=(lamp,),
        obstacles=(),
    )
    shots = tuple(subject.shot(direction, FIELD_OF_VIEW, FILL) for direction in directions)
    # The baked exposure makes every background a middle grey.
    return Stage(room, shots, EXPOSURE * float(colour.mean()) / USUAL_BACKGROUND)
