"""The settings of a robot behind rosbridge: its topics, its camera, the lattice that it moves on, its limits.

`presets/turtlebot2.yaml` explains every key; `config_file.py` reads and writes them.
"""

from __future__ import annotations

import math
import re
from dataclasses import dataclass, field

from active_perceiver.errors import UserError
from active_perceiver.robots.base import Limits
from active_perceiver.scenes import EIGHT_ACTIONS, TURTLEBOT_ACTIONS, Action

ACTIONS = {"six": TURTLEBOT_ACTIONS, "eight": EIGHT_ACTIONS}
TOPIC = re.compile(r"/[A-Za-z][A-Za-z0-9_/]*")


class RosConfigError(UserError, ValueError):
    """Settings that make no sense; the message names the key and the file."""


def same_type(one: str, other: str) -> bool:
    """Whether two names mean one type: ROS 2 writes geometry_msgs/msg/Twist where ROS 1 has geometry_msgs/Twist."""
    return one.replace("/msg/", "/") == other.replace("/msg/", "/")


def _check(rules: dict[str, bool]) -> None:
    for rule, kept in rules.items():
        if not kept:
            raise RosConfigError(rule)


def _check_topic(topic: str, kind: str, *known: str) -> None:
    _check(
        {
            f"topic must be a name such as /cmd_vel, got {topic!r}": bool(TOPIC.fullmatch(topic)),
            f"type must be {' or '.join(known)}, with or without /msg/, got {kind!r}": any(
                same_type(kind, one) for one in known
            ),
        }
    )


@dataclass(frozen=True)
class Camera:
    """The camera.

    Attributes:
        topic: of its images.
        type: of its messages, a CompressedImage with JPEG or PNG in it.
        crop: share of the shorter side that the square view takes from the image's middle; the view should have the
            field of view of the views that the agent was trained with.
        rate: images per second to ask for.
        max_image_age: seconds; when the newest image is older the robot stops.
    """

    topic: str
    type: str = "sensor_msgs/CompressedImage"
    crop: float = 1.0
    rate: float = 10.0
    max_image_age: float = 1.0

    def __post_init__(self) -> None:
        _check_topic(self.topic, self.type, "sensor_msgs/CompressedImage")
        _check(
            {
                f"crop must be in 0.1..1, got {self.crop:g}": 0.1 <= self.crop <= 1,
                f"rate must be in 1..60 images per second, got {self.rate:g}": 1 <= self.rate <= 60,
                f"max_image_age must be in 0.1..30 seconds, got {self.max_image_age:g}": 0.1
                <= self.max_image_age
                <= 30,
                "max_image_age must be at least the time of two images at the rate": self.max_image_age * self.rate
                >= 2,
            }
        )


@dataclass(frozen=True)
class Velocity:
    """Where the base takes its velocity, a Twist or TwistStamped."""

    topic: str
    type: str = "geometry_msgs/Twist"

    def __post_init__(self) -> None:
        _check_topic(self.topic, self.type, "geometry_msgs/Twist", "geometry_msgs/TwistStamped")

    @property
    def stamped(self) -> bool:
        """Whether the velocity comes with a header."""
        return self.type.endswith("Stamped")


@dataclass(frozen=True)
class Wheels:
    """Where the base tells its odometry."""

    topic: str
    type: str = "nav_msgs/Odometry"

    def __post_init__(self) -> None:
        _check_topic(self.topic, self.type, "nav_msgs/Odometry")


@dataclass(frozen=True)
class Joint:
    """A joint of the camera that goes to the angle that is published.

    Attributes:
        topic: of the angle.
        type: of the message.
        unit: of the angle, radians or degrees.
        sign: 1 if a larger angle looks further up (tilt) or to the right (pan), -1 if further down or to the left.
        rest: the angle, in the unit, at which the camera looks level and straight ahead.
        seconds: that the joint takes from one angle to the next.
    """

    topic: str
    type: str = "std_msgs/Float64"
    unit: str = "radians"
    sign: int = 1
    rest: float = 0.0
    seconds: float = 1.0

    def __post_init__(self) -> None:
        _check_topic(self.topic, self.type, "std_msgs/Float64")
        _check(
            {
                f"unit must be radians or degrees, got {self.unit!r}": self.unit in ("radians", "degrees"),
                f"sign must be 1 or -1, got {self.sign}": self.sign in (1, -1),
                f"rest must be in -360..360, got {self.rest:g}": abs(self.rest) <= 360,
                f"seconds must be in 0..10, got {self.seconds:g}": 0 <= self.seconds <= 10,
            }
        )

    def value(self, degrees: float) -> float:
        """The angle to publish for a tilt or pan in degrees."""
        return self.rest + self.sign * (math.radians(degrees) if self.unit == "radians" else degrees)

    def degrees(self, value: float) -> float:
        """The tilt or pan in degrees that a published angle means."""
        off = self.sign * (value - self.rest)
        return math.degrees(off) if self.unit == "radians" else off


@dataclass(frozen=True)
class Connection:
    """How patiently the robot is called.

    Attributes:
        timeout: seconds in which the bridge has to answer and the first image and odometry have to come.
        attempts: to connect again after the connection was lost; with 0 the search ends there.
        pause: seconds between two attempts.
    """

    timeout: float = 5.0
    attempts: int = 5
    pause: float = 2.0

    def __post_init__(self) -> None:
        _check(
            {
                f"timeout must be in 0.2..120 seconds, got {self.timeout:g}": 0.2 <= self.timeout <= 120,
                f"attempts must be in 0..100, got {self.attempts}": 0 <= self.attempts <= 100,
                f"pause must be in 0..60 seconds, got {self.pause:g}": 0 <= self.pause <= 60,
            }
        )


@dataclass(frozen=True)
class RosConfig:
    """What a robot behind rosbridge is like.

    Attributes:
        camera: its images.
        velocity: where it takes its velocity.
        odometry: where it tells its odometry.
        tilt: the joint that tilts the camera; without one it stays at its only tilt.
        pan: a joint that is kept straight ahead.
        tilts: degrees, rising, up positive: those of the lattice that the policy was trained on.
        step: metres moved by one action.
        turn: degrees turned by one action.
        actions: six or eight; with eight it also moves sideways, by turning, driving and turning back.
        settle: seconds after a motion until a picture is sharp; only images taken later are looked at.
        stamps: whether the stamps in the messages' headers tell how old they are; false for a simulation whose clock
            does not run at the speed of ours, then the time of arrival does.
        limits: of every motion.
        connection: timeouts and attempts.
    """

    camera: Camera
    velocity: Velocity
    odometry: Wheels
    tilt: Joint | None = None
    pan: Joint | None = None
    tilts: tuple[float, ...] = (0.0,)
    step: float = 0.5
    turn: float = 90.0
    actions: str = "six"
    settle: float = 0.3
    stamps: bool = True
    limits: Limits = field(default_factory=Limits)
    connection: Connection = field(default_factory=Connection)

    def __post_init__(self) -> None:
        rising = all(low < high for low, high in zip(self.tilts, self.tilts[1:], strict=False))
        _check(
            {
                "tilts must be a rising list of degrees in -90..90": bool(self.tilts)
                and rising
                and all(abs(tilt) <= 90 for tilt in self.tilts),
                "tilts must be a single one for a robot without a tilt joint": len(self.tilts) == 1
                or self.tilt is not None,
                f"step must be above 0 and at most the limit 'distance', {self.limits.distance:g} m, got "
                f"{self.step:g}": 0 < self.step <= self.limits.distance,
                f"turn must be a part of 360 degrees in 1..180, got {self.turn:g}": 1 <= self.turn <= 180
                and 360 % self.turn == 0,
                f"actions must be six or eight, got {self.actions!r}": self.actions in ACTIONS,
                f"settle must be in 0..10 seconds, got {self.settle:g}": 0 <= self.settle <= 10,
            }
        )

    @property
    def policy_actions(self) -> tuple[Action, ...]:
        """The actions in the order of the policy's outputs."""
        return ACTIONS[self.actions]
