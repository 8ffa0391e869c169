"""A body behind rosbridge for tests, and a camera whose colours tell where it is."""

import contextlib
import dataclasses
import time

import numpy as np

from active_perceiver.robots.base import Limits
from active_perceiver.robots.ros.config import Camera, Connection, Joint, RosConfig, Velocity, Wheels
from active_perceiver.simulation.diff_drive import NO_NOISE, DiffDriveSim
from active_perceiver.simulation.ros_bridge import SimulatedBridge

SETTINGS = RosConfig(
    camera=Camera("/camera/image/compressed", rate=20, max_image_age=1.0),
    velocity=Velocity("/cmd_vel"),
    odometry=Wheels("/odom"),
    tilt=Joint("/tilt_controller/command", seconds=0.2, rest=0.5, sign=-1),
    tilts=(-30.0, 0.0, 30.0),
    step=0.4,
    actions="eight",
    settle=0.1,
    limits=Limits(
        speed=1.0,
        angular_velocity=180,
        distance=3,
        odometry_age=1.0,
        position_tolerance=0.02,
        heading_tolerance=2,
        stall=0.6,
    ),
    connection=Connection(timeout=8, attempts=0, pause=0.2),
)


def with_(settings=SETTINGS, **changes):
    """The settings with changes; a dictionary changes a part of a part."""
    made = {
        key: dataclasses.replace(getattr(settings, key), **value) if isinstance(value, dict) else value
        for key, value in changes.items()
    }
    return dataclasses.replace(settings, **made)


# A motion of seconds, long enough for something to go wrong in it.
LONG = with_(step=2.5, tilts=(0.0,), tilt=None, limits={"speed": 0.5})


def view(x, z, heading, tilt):
    """Heading in red, tilt in green, z in blue; wider than high."""
    colour = (round(heading * 255 / 360) % 256, round(tilt + 128), round(100 + 50 * z))
    return np.full((32, 48, 3), np.clip(colour, 0, 255), np.uint8)


def anywhere(x, z):
    return True


class Paced(DiffDriveSim):
    """A body that does not slip, and whose time stands still until the next command when that is late.

    So a test says where it gets to, however busy the machine is.
    """

    PACE = 0.2  # seconds of its time for one command

    def __init__(self, free=anywhere):
        super().__init__(0.0, 0.0, 0.0, free, NO_NOISE, 0)
        self._left = 0.0

    def drive(self, speed, angular_velocity):
        super().drive(speed, angular_velocity)
        self._left = self.PACE

    def wait(self, seconds):
        seconds = min(seconds, self._left)
        self._left -= seconds
        super().wait(seconds)


@contextlib.contextmanager
def served(settings=SETTINGS, *, free=anywhere, camera=view, body=None, speedup=2.0):
    """A bridge in front of a body at 0, 0 that does not slip."""
    body = body or Paced(free)
    with SimulatedBridge(body, camera, settings, speedup=speedup) as bridge:
        yield bridge


def comes_to_rest(body, seconds=10.0):
    """Whether the body stands still before long."""
    end = time.monotonic() + seconds
    while body.moving and time.monotonic() < end:
        time.sleep(0.02)
    return not body.moving


class Tripwire:
    """A body's `free` that lets it go anywhere, and calls something once when it passes a z."""

    def __init__(self, z, then):
        self.z, self.then, self.passed = z, then, False

    def __call__(self, x, z):
        if z > self.z and not self.passed:
            self.passed = True
            self.then()
        return True
