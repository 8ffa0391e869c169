"""What a base with two driven wheels is to whoever drives it: velocities in, odometry out, and limits that hold."""

from __future__ import annotations

from dataclasses import dataclass, fields
from typing import Protocol

from active_perceiver.errors import UserError

# What the limits may be at most; the others 10.
MOST = {"speed": 1.5, "angular_velocity": 180.0, "distance": 10.0, "seconds": 120.0, "period": 0.5}


class MotionError(UserError, RuntimeError):
    """A motion that was given up; the base was stopped. The message says why and what to do."""


@dataclass(frozen=True)
class Odometry:
    """Where the wheels say that the base is.

    Attributes:
        x: metres.
        z: metres.
        heading: degrees, clockwise seen from above, 0 along z and 90 along x; in any range.
        time: seconds, of the clock that `Base.now` reads, when this was measured.
    """

    x: float
    z: float
    heading: float
    time: float


class Base(Protocol):
    """What drives and turns."""

    def drive(self, speed: float, angular_velocity: float) -> None:
        """Set the velocities: metres per second, negative backwards, and degrees per second, clockwise."""
        ...

    def odometry(self) -> Odometry:
        """The newest odometry."""
        ...

    def now(self) -> float:
        """Seconds of a clock that never goes back."""
        ...

    def wait(self, seconds: float) -> None:
        """Let time pass.

        Raises:
            Exception: if the robot should not move on, because its connection is lost for example.
        """
        ...


@dataclass(frozen=True)
class Limits:
    """What no motion exceeds, and how exact it is.

    Attributes:
        speed: metres per second.
        angular_velocity: degrees per second.
        distance: metres, of one drive.
        seconds: for one turn or one drive, of which an action has up to three, and as many again where its way is
            blocked; when they are over the base is stopped and the action given up.
        odometry_age: seconds; with older odometry nothing moves.
        stall: seconds without progress after which the way counts as blocked.
        position_tolerance: metres; so near is there.
        heading_tolerance: degrees; so little beside the heading is there.
        period: seconds between two commands; for so long the base drives unwatched.
    """

    speed: float = 0.25
    angular_velocity: float = 45.0
    distance: float = 1.5
    seconds: float = 20.0
    odometry_age: float = 0.5
    stall: float = 1.0
    position_tolerance: float = 0.01
    heading_tolerance: float = 1.0
    period: float = 0.05

    def __post_init__(self) -> None:
        for field in fields(self):
            value, most = getattr(self, field.name), MOST.get(field.name, 10.0)
            if not 0 < value <= most:
                raise MotionError(f"the limit '{field.name}' must be above 0 and at most {most:g}, got {value}")
