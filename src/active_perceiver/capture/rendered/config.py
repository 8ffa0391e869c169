"""How a room is cut into states and photographed, and how each layout is by default."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Any

from active_perceiver.errors import UserError
from active_perceiver.scenes.lattice import EIGHT_ACTIONS, TURTLEBOT_ACTIONS, Action
from indoor_rooms.renderer.camera_faults import CameraFaults


class CaptureError(UserError, ValueError):
    """A room that cannot be photographed as asked; the message says why and what to do."""


@dataclass(frozen=True)
class CaptureConfig:
    """How a room is cut into states and photographed.

    Attributes:
        actions: what the robot can do.
        spacing: metres between neighbouring positions, and moved by one action.
        places: keep only this many positions, those around the middle of the room; None for all.
        robot_radius: metres.
        camera_height: metres above the floor.
        tilts: degrees, evenly spaced; positive looks up.
        image_size: side of the views in pixels.
        fov: field of view in degrees.
        samples: rays per pixel, a square number.
        bake_rays: rays per vertex of the light's computation.
        bounces: how often light is passed on.
        webp_quality: of the encoded views, 0..100.
        faults: of the robot's camera; None for a perfect one.
    """

    actions: tuple[Action, ...] = EIGHT_ACTIONS
    spacing: float = 0.35
    places: int | None = None
    robot_radius: float = 0.2
    camera_height: float = 1.25
    tilts: tuple[float, ...] = (-30.0, 0.0, 30.0)
    image_size: int = 300
    fov: float = 75.0
    samples: int = 4
    bake_rays: int = 96
    bounces: int = 4
    webp_quality: int = 82
    faults: CameraFaults | None = None

    def __post_init__(self) -> None:
        grid = math.isqrt(max(0, self.samples))
        tilts = self.tilts
        steps = {round(after - before, 6) for before, after in pairwise(tilts)}
        checks = {
            "actions must be different ones, at least one": 0 < len(set(self.actions)) == len(self.actions),
            "spacing must be in 0.05..10 metres": 0.05 <= self.spacing <= 10,
            "places must be at least 1": self.places is None or self.places >= 1,
            "robot_radius must be in 0.01..5 metres": 0.01 <= self.robot_radius <= 5,
            "camera_height must be in 0.05..5 metres": 0.05 <= self.camera_height <= 5,
            "tilts must rise evenly, each in -90..90 degrees": tilts
            and all(-90 < tilt < 90 for tilt in tilts)
            and len(steps) < 2
            and min(steps, default=1) > 0,
            "image_size must be in 16..4096 pixels": 16 <= self.image_size <= 4096,
            "fov must be in 10..150 degrees": 10 <= self.fov <= 150,
            "samples must be a square number (1, 4, 9, ...)": self.samples >= 1 and grid * grid == self.samples,
            "bake_rays must be at least 1": self.bake_rays >= 1,
            "bounces must be 0 or more": self.bounces >= 0,
            "webp_quality must be in 0..100": 0 <= self.webp_quality <= 100,
        }
        for rule, kept in checks.items():
            if not kept:
                name = rule.split()[0]
                raise CaptureError(f"{rule}, got {getattr(self, name)}")


# Layouts that are not captured as the others are. A TurtleBot in a conference room, as in the paper: six actions, 27
# places with eight views each.
DEFAULT_CONFIGS: dict[str, CaptureConfig] = {
    "conference_room": CaptureConfig(
        actions=TURTLEBOT_ACTIONS,
        spacing=0.75,
        places=27,
        tilts=(-25.0, 0.0),
        camera_height=1.1,
        fov=70.0,
        faults=CameraFaults(),
    )
}


def layout_config(layout: str, **given: Any) -> CaptureConfig:
    """How rooms of a layout are captured if nothing else is said, with what is given and not None instead."""
    config = DEFAULT_CONFIGS.get(layout, CaptureConfig())
    return replace(config, **{name: value for name, value in given.items() if value is not None})
