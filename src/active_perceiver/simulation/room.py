"""A room as a robot meets it: light, a camera that looks from any pose, and where one may stand."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from active_perceiver.capture.rendered.capture_scene import look
from active_perceiver.capture.rendered.config import CaptureConfig, layout_config
from active_perceiver.capture.rendered.render import origin_of
from active_perceiver.scenes import bundled_names, open_scene
from active_perceiver.utils.progress import ProgressBar, progress_bar
from indoor_rooms.free_space import clearance, free_positions
from indoor_rooms.layouts import LAYOUTS, LayoutError, make_room
from indoor_rooms.perturb import perturbed
from indoor_rooms.renderer.camera_faults import CameraFaults
from indoor_rooms.renderer.lighting import BakedRoom, bake

# As scene files are named: kitchen_1, kitchen_1_hour_dusk, kitchen_1_moved_2, kitchen_1_hour_dusk_moved_2.
NAME = re.compile(r"(?P<scene>[a-z_]+?(_\d+)?)(_hour_(?P<hour>[a-z_]+?))?(_moved_(?P<moved>\d+))?")

WEBCAM = CameraFaults()


@dataclass(frozen=True, eq=False)
class LiveRoom:
    """A room with its light.

    Attributes:
        name: of the scene whose room it is, without what is different today: "kitchen_1".
        baked: the room and its light.
        settings: of the robot and its camera, and the lattice on which scenes of such a room are captured.
        seed: of the camera's faults.
    """

    name: str
    baked: BakedRoom
    settings: CaptureConfig
    seed: int

    def look(
        self, pose: Sequence[float], targets: Sequence[str] = (), moment: int = 0
    ) -> tuple[NDArray[np.uint8], NDArray[np.float32]]:
        """What the camera sees from a pose, see `capture.look`.

        Args:
            pose: x, z in metres, heading and tilt in degrees.
            targets: T names of things.
            moment: at another moment the same camera makes other mistakes.

        Returns:
            (H, W, 3) uint8 RGB; and (T, 4) float32 boxes of the targets: centre x, centre y, width, height as
            fractions of the image, NaN where not visible.
        """
        return look(self.baked, self.settings, pose, targets, self.seed + moment)

    def free(self, x: float, z: float) -> bool:
        """Whether the robot's middle may be at x, z in metres: nothing is closer than its radius."""
        width, depth, _ = self.baked.room.size
        radius = self.settings.robot_radius
        if not (radius <= x <= width - radius and radius <= z <= depth - radius):
            return False
        place = np.array([[x, z]])
        near = [
            polygon
            for _, polygon in self.baked.room.obstacles
            if (polygon.min(axis=0) - radius < place[0]).all() and (polygon.max(axis=0) + radius > place[0]).all()
        ]
        return not near or bool(clearance(place, place, near)[0] >= radius)

    def places(self) -> NDArray[np.float64]:
        """The positions of the lattice on which scenes of the room are captured, (P, 2) x, z in metres."""
        settings = self.settings
        return free_positions(self.baked.room, settings.spacing, settings.robot_radius, settings.places)


def open_room(
    name: str,
    *,
    nudge: float = 0.0,
    seed: int = 0,
    faults: CameraFaults | None = WEBCAM,
    progress: ProgressBar = progress_bar,
) -> LiveRoom:
    """Furnish a room and compute its light, which takes some seconds.

    Args:
        name: of a bundled scene, or layout and seed, perhaps with another hour of the day or another arrangement of
            the things: "kitchen_1", "kitchen_1_hour_dusk", "kitchen_1_moved_2".
        nudge: metres by which every target is moved at most, in a direction of its own.
        seed: of the nudges and the camera's faults.
        faults: of the robot's camera, whatever the scenes were captured with; None for a perfect one.
        progress: opens a progress bar.

    Raises:
        LayoutError: if there is no such room, hour or arrangement.
        PerturbError: if things cannot be nudged so far.
    """
    layout, seed_of_room, hour, moved = _named(name)
    settings = replace(layout_config(layout), faults=faults)
    with progress(f"light of {name}") as report:
        room = make_room(layout, seed_of_room, hour=hour, moved=moved)
        if nudge:
            room = perturbed(room, nudge, seed)
        baked = bake(room, settings.bake_rays, settings.bounces, seed_of_room, report)
    return LiveRoom(scene_of(name), baked, settings, seed)


def scene_of(name: str) -> str:
    """Name of the scene whose room a room is at another hour or in another arrangement; see `open_room`.

    Raises:
        LayoutError: if there is no such room.
    """
    _named(name)
    return name.partition("_hour_")[0].partition("_moved_")[0]


def _named(name: str) -> tuple[str, int, str | None, int | None]:
    """Layout, seed, hour and arrangement."""
    found = NAME.fullmatch(name)
    scene = found["scene"] if found else ""
    layout, _, number = scene.rpartition("_")
    if found and scene in bundled_names():
        layout, seed = origin_of(open_scene(scene))
    elif found and layout in LAYOUTS and number.isdigit():
        seed = int(number)
    else:
        raise LayoutError(
            f"'{name}' is no room that can be made; name a bundled scene, or a layout ({', '.join(sorted(LAYOUTS))}) "
            "and a number, kitchen_1 for example, and perhaps an hour or an arrangement: kitchen_1_hour_dusk, "
            "kitchen_1_moved_2"
        )
    hour, moved = found.group("hour", "moved")
    return layout, seed, hour and hour.replace("_", " "), None if moved is None else int(moved)
