"""Where a target is that was seen from several poses, and from which poses it will be seen how large."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from active_perceiver.scenes.angles import signed_angle

CELL = 0.2
"""Metres between the points that are taken into consideration for where the target is."""
MARGIN = 2.0
"""Metres around the robot's places where it may be."""
NEAREST, FARTHEST = 0.3, 7.0
"""Metres from the camera between which a target is looked for."""
SHARPNESS = 3.0
"""Degrees by which a box's middle typically misses the target's."""
SUPPORT = 8.0
"""Degrees within which a sighting is of the target that is taken to be at a point."""
LIKELY_RANGE = 1.5
"""Metres away where a target is assumed to be that was seen from one place only."""
COUNTED = 3
"""How many of the largest boxes say how sure it is that the target is there."""
INSIDE = 0.9
"""How much of the image's half width a target's middle may be from the image's middle to count as well in view."""


@dataclass(frozen=True, eq=False)
class Sighting:
    """A box that was drawn in a view.

    Attributes:
        state: whose view.
        box: (4,) centre x, centre y, width, height as fractions of the image.
        score: presence probability.
    """

    state: int
    box: NDArray[np.floating]
    score: float

    @property
    def area(self) -> float:
        """As a fraction of the image."""
        return float(self.box[2] * self.box[3])


@dataclass(frozen=True, eq=False)
class Estimate:
    """Where the target is taken to be.

    Attributes:
        point: x, z and height above the camera, metres.
        size: its area in the image, as a fraction, times the square of its distance in metres.
        sightings: those that agree with it.
    """

    point: tuple[float, float, float]
    size: float
    sightings: tuple[Sighting, ...]

    @property
    def best(self) -> Sighting:
        """The one that shows the target largest."""
        return max(self.sightings, key=lambda sighting: sighting.area)

    @property
    def confidence(self) -> float:
        """Mean presence probability of the sightings that show the target largest."""
        largest = sorted(self.sightings, key=lambda sighting: -sighting.area)[:COUNTED]
        return sum(sighting.score for sighting in largest) / len(largest)


def rays(poses: NDArray[np.floating], boxes: NDArray[np.floating], fov: float) -> NDArray[np.float64]:
    """In which directions the middles of boxes lie.

    Args:
        poses: (n, 4) of the camera: x, z in metres, heading and tilt in degrees.
        boxes: (n, 4) centre x, centre y, width, height as fractions of the image.
        fov: degrees.

    Returns:
        (n, 2) degrees: bearing, clockwise from above with 0 along +z, and elevation above the horizon.
    """
    half = np.tan(np.radians(fov / 2))
    right, up = (boxes[:, 0] - 0.5) * 2 * half, (0.5 - boxes[:, 1]) * 2 * half
    tilt = np.radians(poses[:, 3].astype(float))
    ahead, above = np.cos(tilt) - up * np.sin(tilt), np.sin(tilt) + up * np.cos(tilt)
    bearing = poses[:, 2] + np.degrees(np.arctan2(right, ahead))
    return np.stack([bearing, np.degrees(np.arctan2(above, np.hypot(right, ahead)))], axis=-1)


def estimates(sightings: Sequence[Sighting], poses: NDArray[np.floating], fov: float) -> list[Estimate]:
    """All points that sightings agree on, the one with most votes first; each sighting is counted for one of them.

    Args:
        sightings: any number.
        poses: (S, 4) of all states: x, z in metres, heading and tilt in degrees.
        fov: degrees.
    """
    left, found = list(sightings), []
    while left:
        found.append(estimate(left, poses, fov))
        left = [one for one in left if one not in found[-1].sightings]
    return found


def estimate(sightings: Sequence[Sighting], poses: NDArray[np.floating], fov: float) -> Estimate:
    """Where most sightings agree that the target is.

    Every sighting votes for the points along its ray, so that a wrong one is outvoted.

    Args:
        sightings: at least one.
        poses: (S, 4) of all states.
        fov: degrees.
    """
    cameras = poses[[sighting.state for sighting in sightings]]
    directions = rays(cameras, np.array([sighting.box for sighting in sightings]), fov)
    low, high = poses[:, :2].min(axis=0) - MARGIN, poses[:, :2].max(axis=0) + MARGIN
    x, z = np.meshgrid(np.arange(low[0], high[0], CELL), np.arange(low[1], high[1], CELL), indexing="ij")
    points = np.stack([x.ravel(), z.ravel()], axis=-1)
    away = points[None] - cameras[:, None, :2]  # (n, P, 2)
    distance = np.hypot(away[..., 0], away[..., 1])
    miss = signed_angle(np.degrees(np.arctan2(away[..., 0], away[..., 1])) - directions[:, :1])
    possible = (distance > NEAREST) & (distance < FARTHEST)
    votes = possible * np.exp(-0.5 * (miss / SHARPNESS) ** 2)
    likely = np.exp(-0.5 * (distance - LIKELY_RANGE) ** 2)
    best = int((votes * (1 + 0.1 * likely)).sum(axis=0).argmax())
    agree = (np.abs(miss[:, best]) < SUPPORT) & possible[:, best]
    # A point that no ray comes near to is only met if the strongest ray is alone: then that one agrees.
    agree[int(votes[:, best].argmax())] = True
    far = distance[agree, best]
    supporters = tuple(sighting for sighting, agrees in zip(sightings, agree, strict=True) if agrees)
    return Estimate(
        point=(*points[best].tolist(), float(np.median(far * np.tan(np.radians(directions[agree, 1]))))),
        size=float(np.median([sighting.area for sighting in supporters] * far**2)),
        sightings=supporters,
    )


def expected_areas(found: Estimate, poses: NDArray[np.floating], fov: float) -> NDArray[np.float64]:
    """How large the target should be in each view, as a fraction of the image; 0 where it is not well in view.

    Args:
        found: where the target is.
        poses: (S, 4).
        fov: degrees.
    """
    half = np.tan(np.radians(fov / 2)) * INSIDE
    away = np.array(found.point[:2]) - poses[:, :2]
    heading, tilt = np.radians(poses[:, 2].astype(float)), np.radians(poses[:, 3].astype(float))
    level = away[:, 0] * np.sin(heading) + away[:, 1] * np.cos(heading)
    right = away[:, 0] * np.cos(heading) - away[:, 1] * np.sin(heading)
    ahead = level * np.cos(tilt) + found.point[2] * np.sin(tilt)
    up = found.point[2] * np.cos(tilt) - level * np.sin(tilt)
    distance = np.hypot(away[:, 0], away[:, 1])
    seen = (ahead > 0) & (np.abs(right) < half * ahead) & (np.abs(up) < half * ahead) & (distance > NEAREST)
    return np.where(seen, np.minimum(found.size / np.maximum(distance, NEAREST) ** 2, 1.0), 0.0)
