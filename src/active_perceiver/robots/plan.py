"""Where a base should be, in the frame of its odometry, and points that are counted from there."""

from __future__ import annotations

import math
from dataclasses import dataclass

from active_perceiver.robots.base import Odometry


@dataclass
class Plan:
    """A point and a heading, in the frame of the odometry: metres, and degrees clockwise, in any range."""

    x: float
    z: float
    heading: float


def ahead(here: Plan, metres: float, direction: float) -> Plan:
    """The point so many metres away in a direction, degrees clockwise from the heading, which stays."""
    angle = math.radians(here.heading + direction)
    return Plan(here.x + metres * math.sin(angle), here.z + metres * math.cos(angle), here.heading)


def counted_from(start: Plan, x: float, z: float, heading: float) -> Plan:
    """The point so many metres to the right and ahead of a start, in the frame that the start is given in."""
    angle = math.radians(start.heading)
    return Plan(
        start.x + x * math.cos(angle) + z * math.sin(angle),
        start.z - x * math.sin(angle) + z * math.cos(angle),
        start.heading + heading,
    )


def moved_towards(at: Odometry, place: Plan, metres: float, heading: float) -> Plan:
    """The point so many metres from where the base is towards a place, with a heading; at most the place itself."""
    share = metres / max(metres, math.hypot(place.x - at.x, place.z - at.z))
    return Plan(at.x + share * (place.x - at.x), at.z + share * (place.z - at.z), heading)
