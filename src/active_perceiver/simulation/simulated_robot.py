"""A TurtleBot in a rendered room: any pose, wheels that slip, a camera with faults; needs the extra `rooms`.

What it takes for an action is what a robot on the floor takes: a drive or a turn, closed over odometry that drifts
(see `motion.py`, `diff_drive.py`). Sideways moves, which such a body cannot do, are a turn, a drive and a turn back.
Time is the body's own: the search goes on as fast as pictures can be rendered.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from active_perceiver.capture.rendered.capture_scene import HEADINGS
from active_perceiver.errors import UserError
from active_perceiver.robots.base import Limits
from active_perceiver.robots.motion import MotionController
from active_perceiver.robots.robot import StopOnExit, check_action
from active_perceiver.robots.ros.config import ACTIONS, Joint, RosConfig
from active_perceiver.scenes import Action
from active_perceiver.scenes.lattice import LOOK, lattice_poses, nearest_tilt
from active_perceiver.simulation.diff_drive import DiffDriveSim, OdometryNoise
from active_perceiver.simulation.room import WEBCAM, LiveRoom, open_room, scene_of
from active_perceiver.simulation.ros_bridge import SimulatedBridge

__all__ = [
    "WEBCAM", "LiveRoom", "Pose", "SimulatedRobot", "bridge_in", "fitted_config", "lattice_start", "nearest_pose",
    "open_room", "random_start", "scene_of",
]  # fmt: skip

# Places drawn near a lattice's until one is free.
TRIES = 100

# Where a simulated robot's camera is tilted if the settings of a robot without a tilt joint are served.
TILT = Joint("/tilt_controller/command", seconds=0.5)
# Seconds that a picture may take to be rendered, and odometry to come, on a machine that has other things to do.
PATIENCE, SOON = 10.0, 2.0

Pose = tuple[float, float, float, float]


class SimulatedRobot(StopOnExit):
    """A robot in a room that is rendered as it looks.

    Args:
        room: where it is; its settings say what the robot can do, how far it moves and what camera it has.
        start: x, z in metres, heading and tilt in degrees; see `random_start`.
        actions: what it may do; those of the room's settings if not given.
        odometry_noise: how wrong its odometry is; the usual if not given.
        limits: of every motion.
        seed: of the slip.

    Attributes:
        body: where it truly is.
        driver: carries out its motions.

    Raises:
        BodyError: if something stands at the start.
    """

    def __init__(
        self,
        room: LiveRoom,
        start: Pose,
        *,
        actions: tuple[Action, ...] | None = None,
        odometry_noise: OdometryNoise | None = None,
        limits: Limits | None = None,
        seed: int | None = None,
    ) -> None:
        x, z, heading, tilt = start
        self.room = room
        self.body = DiffDriveSim(x, z, heading, room.free, odometry_noise, seed)
        self.driver = MotionController(self.body, limits or Limits(), room.settings.spacing)
        self._looks = 0
        self._actions = actions or room.settings.actions
        self._tilts = room.settings.tilts
        self._level = nearest_tilt(self._tilts, tilt)
        self._tilt_off = tilt - self._tilts[self._level]

    @property
    def actions(self) -> tuple[Action, ...]:
        """What it may do."""
        return self._actions

    def look(self) -> NDArray[np.uint8]:
        """What its camera sees now, (H, W, 3) uint8 RGB, rendered."""
        self._looks += 1
        image, _ = self.room.look(self.pose(), moment=self._looks)
        return image

    def pose(self) -> Pose:
        """Where it truly is, as nobody but the simulation knows."""
        return self.body.x, self.body.z, self.body.heading, self._tilts[self._level] + self._tilt_off

    def execute(self, action: Action) -> bool:
        """Drive, turn, or tilt the camera. A way that is blocked is driven back.

        Returns:
            Whether it moved.

        Raises:
            UserError: if the robot may not do this.
            MotionError: if the motion exceeded a limit; the robot was stopped.
        """
        check_action(action, self._actions)
        if action not in LOOK:
            return self.driver.execute(action)
        level = self._level + LOOK[action]
        if not 0 <= level < len(self._tilts):
            return False
        self._level = level
        return True

    @property
    def tilts(self) -> tuple[float, ...]:
        """Degrees: those of the room's lattice."""
        return self._tilts

    def go_to(self, x: float, z: float, heading: float, tilt: float) -> bool:
        """Drive to a point as seen from where it began; see `NavigatingRobot.go_to`.

        Raises:
            MotionError: if a motion exceeded a limit; the robot was stopped.
        """
        if not self.driver.travel_to(x, z, heading):
            return False
        self._level, self._tilt_off = nearest_tilt(self._tilts, tilt), 0.0
        return True

    def stop(self) -> None:
        """Stand still."""
        self.body.drive(0.0, 0.0)


def random_start(room: LiveRoom, rng: np.random.Generator, centimetres: float = 10.0, degrees: float = 8.0) -> Pose:
    """A pose near one of the lattice's: somewhere a person might have put the robot down.

    Args:
        room: where.
        rng: draws it.
        centimetres: it is up to so far beside the lattice's place, along x and along z.
        degrees: and up to so much beside one of the four headings.

    Raises:
        UserError: if there is no free place so near to the lattice.
    """
    places = room.places()
    for _ in range(TRIES):
        x, z = places[rng.integers(len(places))] + rng.uniform(-centimetres, centimetres, 2) / 100
        if room.free(x, z):
            heading = HEADINGS[rng.integers(len(HEADINGS))] + rng.uniform(-degrees, degrees)
            return float(x), float(z), float(heading % 360), float(rng.choice(room.settings.tilts))
    raise UserError(f"no free place was found within {centimetres:g} cm of the lattice of {room.name}")


def lattice_start(room: LiveRoom, state: int) -> Pose:
    """The pose of a state of the scenes that are captured in a room.

    Raises:
        UserError: if there is no such state.
    """
    poses = lattice_poses(room.places(), HEADINGS, room.settings.tilts)
    if not 0 <= state < len(poses):
        raise UserError(f"{room.name} has states 0 to {len(poses) - 1}; there is no state {state}")
    x, z, heading, tilt = (float(value) for value in poses[state])
    return x, z, heading, tilt


def nearest_pose(room: LiveRoom, pose: Pose) -> Pose:
    """The pose of the lattice that is nearest to another one, place, heading and tilt each on their own."""
    x, z, heading, tilt = pose
    places, tilts = room.places(), room.settings.tilts
    near_x, near_z = places[np.hypot(*(places - (x, z)).T).argmin()]
    return float(near_x), float(near_z), round(heading / 90) % 4 * 90.0, float(tilts[nearest_tilt(tilts, tilt)])


def fitted_config(room: LiveRoom, settings: RosConfig) -> RosConfig:
    """Settings of a robot behind rosbridge for the lattice of a room, so that agents that were trained there fit.

    Step, turns, tilts and actions become the room's, and the view is the whole picture. Topics, types and limits
    of speed stay. A robot without a tilt joint gets one if the room's lattice has several tilts. As pictures take a
    while to be rendered, by the same machine, they may be old.

    Args:
        room: whose lattice.
        settings: of a real robot.

    Raises:
        UserError: if no robot behind rosbridge has the actions of the room's agents.
    """
    lattice, camera, limits = room.settings, settings.camera, settings.limits
    names = {actions: name for name, actions in ACTIONS.items()}
    if lattice.actions not in names:
        raise UserError(f"agents of {room.name} have other actions than robots behind rosbridge: {lattice.actions}")
    return replace(
        settings,
        camera=replace(camera, crop=1.0, max_image_age=max(camera.max_image_age, PATIENCE)),
        tilt=settings.tilt or (TILT if len(lattice.tilts) > 1 else None),
        tilts=lattice.tilts,
        step=lattice.spacing,
        turn=90.0,
        actions=names[lattice.actions],
        limits=replace(
            limits, distance=max(limits.distance, 1.5 * lattice.spacing), odometry_age=max(limits.odometry_age, SOON)
        ),
        connection=replace(settings.connection, timeout=max(settings.connection.timeout, 2 * PATIENCE)),
    )


def bridge_in(
    room: LiveRoom,
    start: Pose,
    settings: RosConfig,
    *,
    odometry_noise: OdometryNoise | None = None,
    seed: int | None = None,
    speedup: float = 1.0,
    port: int = 0,
) -> SimulatedBridge:
    """A TurtleBot in a room behind rosbridge, to be entered as a context manager.

    Args:
        room: where it is.
        start: x, z in metres and heading in degrees; its camera looks level until it is told otherwise.
        settings: topics, types, the tilt joint and the rate of the camera.
        odometry_noise: how wrong its odometry is; the usual if not given.
        seed: of the slip.
        speedup: how much faster than the clock the robot moves.
        port: of the server; a free one if 0.

    Raises:
        BodyError: if something stands at the start.
    """
    seen: dict[Pose, NDArray[np.uint8]] = {}

    def view(*pose: float) -> NDArray[np.uint8]:
        # While the robot stands still there is nothing to render.
        x, z, heading, tilt = pose
        key = x, z, heading, tilt
        if key not in seen:
            image, _ = room.look(key)
            seen.clear()
            seen[key] = image
        return seen[key]

    body = DiffDriveSim(*start[:3], room.free, odometry_noise, seed)
    return SimulatedBridge(body, view, settings, speedup=speedup, port=port)
