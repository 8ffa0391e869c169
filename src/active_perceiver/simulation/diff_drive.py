"""The body of a simulated robot: two driven wheels that slip, odometry that believes the wheels, walls that stop it.

It is a `base.Base` of its own, whose time passes only when somebody waits.

The body turns on the spot and drives straight ahead and back, as a TurtleBot does (the paper's section IV-C). Time is
cut into short steps. What the wheels do is what is commanded, within what the motors can; what the robot does is
that, wrong by errors that stay for the whole search (a wheel that is worn, a floor that is smooth) and others that
come and go. The odometry counts what the wheels do, so it drifts away from the truth.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, fields

import numpy as np

from active_perceiver.errors import UserError
from active_perceiver.robots.base import Odometry

# Metres per second squared, and degrees per second squared, that the motors can do.
SPEEDING, SPINNING = 1.0, 180.0
# Seconds of one step of the simulation.
STEP = 0.02

Free = Callable[[float, float], bool]


class DiffDriveError(UserError, ValueError):
    """A body that cannot be, or not there."""


@dataclass(frozen=True)
class OdometryNoise:
    """How wrong the odometry is; all standard deviations. The defaults are those of a TurtleBot on a smooth floor.

    Attributes:
        distance: of the share by which every way is too long or short, for a whole search.
        angle: the same of every turn.
        veer: degrees by which it turns unawares for each metre driven, for a whole search.
        roughness: metres beside and along the way after one metre driven, from moment to moment.
        jerk: degrees of heading after turning by 90 degrees, from moment to moment.
    """

    distance: float = 0.02
    angle: float = 0.015
    veer: float = 1.5
    roughness: float = 0.01
    jerk: float = 1.0

    def __post_init__(self) -> None:
        for field in fields(self):
            value = getattr(self, field.name)
            if not 0 <= value <= 20:
                raise DiffDriveError(f"slip's {field.name} must be in 0..20, got {value}")


NO_NOISE = OdometryNoise(0.0, 0.0, 0.0, 0.0, 0.0)
"""Wheels that do what they say, and odometry that is right."""


class DiffDriveSim:
    """A round body on a floor; the state of a simulation.

    Args:
        x: metres.
        z: metres.
        heading: degrees, clockwise seen from above, 0 along z.
        free: whether the body's middle may be at a place (x, z).
        odometry_noise: how wrong the odometry is.
        seed: what is random follows from it.

    Attributes:
        x, z, heading: where it truly is; heading in 0..360.
        time: seconds since it was made.
        collisions: how often it ran into something.
    """

    def __init__(
        self,
        x: float,
        z: float,
        heading: float,
        free: Free,
        odometry_noise: OdometryNoise | None = None,
        seed: int | None = None,
    ) -> None:
        if not free(x, z):
            raise DiffDriveError(
                f"a robot cannot stand at x {x:.2f} m, z {z:.2f} m: something is there; start elsewhere"
            )
        odometry_noise = odometry_noise or OdometryNoise()
        self.x, self.z, self.heading = x, z, heading % 360
        self.time = 0.0
        self.collisions = 0
        self._free = free
        self._random = np.random.default_rng(seed)
        stays = self._random.standard_normal(3)
        self._longer, self._turned_more, self._veer = stays * (
            odometry_noise.distance,
            odometry_noise.angle,
            odometry_noise.veer,
        )
        self._slip = odometry_noise
        self._wanted = (0.0, 0.0)
        self._speed = self._turning = 0.0
        self._counted = (0.0, 0.0, 0.0)
        self._bumped = 0  # 1 ahead, -1 behind

    def drive(self, speed: float, angular_velocity: float) -> None:
        """Ask for velocities: metres per second, and degrees per second clockwise; the motors need a moment.

        Having run into something it does not drive on, as a bumper sees to, until it is told to stop or to drive the
        other way.
        """
        if speed * self._bumped <= 0:
            self._bumped = 0
        self._wanted = (0.0 if self._bumped else speed, angular_velocity)

    @property
    def moving(self) -> bool:
        """Whether the wheels turn, or are told to."""
        return any((*self._wanted, self._speed, self._turning))

    def odometry(self) -> Odometry:
        """Where the wheels say that it is, counted from where it began, its heading then being 0."""
        x, z, heading = self._counted
        return Odometry(x, z, heading, self.time)

    def now(self) -> float:
        """Its time."""
        return self.time

    def wait(self, seconds: float) -> None:
        """Let time pass."""
        end = self.time + seconds
        while self.time < end - 1e-9:
            self._step(min(STEP, end - self.time))

    def _step(self, seconds: float) -> None:
        self.time += seconds
        speed, angular_velocity = self._wanted
        self._speed += float(np.clip(speed - self._speed, -SPEEDING * seconds, SPEEDING * seconds))
        self._turning += float(np.clip(angular_velocity - self._turning, -SPINNING * seconds, SPINNING * seconds))
        way, turn = self._speed * seconds, self._turning * seconds
        if not way and not turn:
            return
        rough, beside, jerk = self._random.standard_normal(3)
        roughness = self._slip.roughness * math.sqrt(abs(way))
        true_way = way * (1 + self._longer) + roughness * rough
        true_turn = turn * (1 + self._turned_more) + way * self._veer
        true_turn += self._slip.jerk * math.sqrt(abs(turn) / 90) * jerk
        middle = math.radians(self.heading + true_turn / 2)
        x = self.x + true_way * math.sin(middle) + roughness * beside * math.cos(middle)
        z = self.z + true_way * math.cos(middle) - roughness * beside * math.sin(middle)
        if way and not self._free(x, z):
            # The wheels are held: they do not count what is not driven.
            self.collisions += 1
            self._bumped = 1 if way > 0 else -1
            self._wanted = (0.0, self._wanted[1])
            way = self._speed = 0.0
        elif way:
            self.x, self.z = x, z
        self.heading = (self.heading + true_turn) % 360
        counted_x, counted_z, counted = self._counted
        middle = math.radians(counted + turn / 2)
        self._counted = (counted_x + way * math.sin(middle), counted_z + way * math.cos(middle), counted + turn)
