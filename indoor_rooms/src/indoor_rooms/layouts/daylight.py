"""Time of day: the sun, what comes in through the windows, how it looks outside, how bright the lamps are."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from indoor_rooms.layouts.walls import Wall
from indoor_rooms.materials.material import Colour
from indoor_rooms.room import Sun

WARM: Colour = (1.0, 0.87, 0.70)
NEUTRAL: Colour = (1.0, 0.95, 0.88)
COLD: Colour = (0.92, 0.97, 1.0)


@dataclass(frozen=True)
class Daylight:
    """Light from outside, and how much the lamps add to it. Colours are linear RGB.

    Attributes:
        sun: parallel light, or None.
        sky: (3,) radiance of the sky.
        windows: (3,) radiance of a window's opening.
        outside: (3,) brightness of the view out of the window.
        lamps: strength of the lamps, 1 for those of a bright day.
    """

    sun: Sun | None
    sky: Colour
    windows: Colour
    outside: Colour
    lamps: float


@dataclass(frozen=True)
class _Hour:
    steep: tuple[float, float]
    sun: Colour | None
    windows: Colour
    outside: Colour
    lamps: float


# Heights of the sun as the fall of its light over the way into the room.
_HOURS = {
    "morning": _Hour((0.50, 0.80), (1.0, 0.86, 0.68), (6.4, 6.8, 7.4), (1.8, 1.75, 1.7), 0.8),
    "noon": _Hour((1.00, 1.50), (1.0, 0.94, 0.86), (6.8, 7.2, 7.8), (1.9, 1.9, 1.9), 0.7),
    "afternoon": _Hour((0.65, 1.00), (1.0, 0.90, 0.76), (6.6, 7.1, 7.8), (1.8, 1.8, 1.8), 0.9),
    "low sun": _Hour((0.28, 0.42), (1.0, 0.72, 0.44), (5.4, 5.2, 5.2), (1.7, 1.5, 1.25), 1.2),
    "overcast": _Hour((1.0, 1.0), None, (5.6, 6.0, 6.4), (1.35, 1.4, 1.45), 1.3),
    "dusk": _Hour((1.0, 1.0), None, (0.75, 1.0, 1.6), (0.10, 0.12, 0.19), 1.5),
}


HOURS = tuple(_HOURS)
"""Names of the hours."""


def hour_of_day(walls: Sequence[Wall], rng: np.random.Generator, name: str | None = None) -> Daylight:
    """The light at some hour.

    Args:
        walls: those with windows; the sun shines in through one of them.
        rng: chooses the hour and the direction; as much is drawn from it when the hour is given, so that nothing
            else about a room depends on that.
        name: of the hour, one of `HOURS`; left to chance if None.
    """
    drawn = HOURS[int(rng.choice(len(HOURS), p=[0.18, 0.2, 0.22, 0.12, 0.16, 0.12]))]
    hour = _HOURS[name or drawn]
    sideways, steep = rng.uniform(-0.45, 0.45), rng.uniform(*hour.steep)
    wall = walls[int(rng.integers(len(walls)))]
    into, along = (np.subtract(wall.point(*way), wall.point(0.0)) for way in ((0.0, 1.0), (1.0, 0.0)))
    x, y, _ = into + sideways * along
    sun = None if hour.sun is None else Sun((float(x), float(y), -float(steep)), hour.sun, 9.0)
    sky = tuple(0.17 * channel for channel in hour.windows)
    return Daylight(sun, (sky[0], sky[1], sky[2]), hour.windows, hour.outside, hour.lamps)


def scaled(colour: Colour, strength: float) -> Colour:
    """A colour, brighter or darker."""
    return (colour[0] * strength, colour[1] * strength, colour[2] * strength)
