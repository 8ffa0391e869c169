"""Where a base should be, in the frame of its odometry, and points that are counted from there."""

from __future__ import annotations

import math
from dataclasses import dataclass

from active_perceiver.robots.base import Odometry


@dataclass
class Pose2D:
    """A point and a heading, in the frame of the odometry: metres, and degrees clockwise, in any range."""

    x: float
    z: float
    heading: float


def ahead(here: Pose2D, metres: float, direction: float) -> Pose2D:
    """The point on a way that begins here; the heading stays.

    Args:
        here: where the way begins.
        metres: its length.
        direction: degrees clockwise from the heading: 0 ahead, 90 to the right.
    """
    angle = math.radians(here.heading + direction)
    return Pose2D(here.x + metres * math.sin(angle), here.z + metres * math.cos(angle), here.heading)


def counted_from(start: Pose2D, x: float, z: float, heading: float) -> Pose2D:
    """A point that is known as seen from a start, in the frame that the start is given in.

    Args:
        start: where x, z and heading are counted from.
        x: metres to its right.
        z: metres ahead of it.
        heading: degrees clockwise from its own.
    """
    angle = math.radians(start.heading)
    return Pose2D(
        start.x + x * math.cos(angle) + z * math.sin(angle),
        start.z - x * math.sin(angle) + z * math.cos(angle),
        start.heading + heading,
    )


def moved_towards(at: Odometry, place: Pose2D, metres: float, heading: float) -> Pose2D:
    """A point on the straight way from where the base is to a place.

    Args:
        at: where the base is.
        place: where the way leads.
        metres: from the base; the place itself, if that is nearer.
        heading: of the point, degrees.
    """
    share = metres / max(metres, math.hypot(place.x - at.x, place.z - at.z))
    return Pose2D(at.x + share * (place.x - at.x), at.z + share * (place.z - at.z), heading)
