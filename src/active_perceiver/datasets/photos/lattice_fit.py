"""The lattice that imprecise poses were meant to lie on: heading step, tilts, spacing, rotation and corner.

Places are complex numbers x + i z here: then a lattice is `corner + axis * n` for whole complex numbers n, and one
complex `axis` holds both its spacing (its size) and its rotation (its angle).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

# Degrees between neighbouring headings that are tried if none is given.
HEADING_STEPS = (
    360.0,
    180.0,
    120.0,
    90.0,
    72.0,
    60.0,
    45.0,
    40.0,
    36.0,
    30.0,
    24.0,
    22.5,
    20.0,
    18.0,
    15.0,
    12.0,
    10.0,
)
# How far most headings may be from the lattice, in degrees, for it to be taken for what was meant.
_HEADING_REACH = 10.0
# Levels of tilt whose middles differ by less are told apart only if they are exact; then they differ by the second.
_TILT_GAP, _EXACT_GAP = 8.0, 5.0
# So many levels, at most, are taken for exact ones.
_EXACT_LEVELS = 12
# All photographs within so many metres were taken in one place.
ONE_PLACE = 0.15
# Pairs of this many photographs are enough to find a lattice, and fit into memory.
_PAIRED = 1500


@dataclass(frozen=True)
class Places:
    """A lattice of places.

    Attributes:
        axis: from a place to the next one to the right, x + i z in metres.
        corner: the place with the number 0 + 0 i.
    """

    axis: complex
    corner: complex

    def nearest(self, points: NDArray[np.complex128]) -> NDArray[np.complex128]:
        """The whole complex number of the place nearest to each point."""
        return _whole((points - self.corner) / self.axis)

    def distances(self, points: NDArray[np.complex128]) -> NDArray[np.float64]:
        """Metres from each point to the nearest place."""
        return np.abs(points - self.corner - self.axis * self.nearest(points))


def fit_headings(headings: NDArray[np.float64], step: float | None = None) -> tuple[float, float] | None:
    """The even step of headings and the first one.

    Of the usual steps the one is taken whose deviations are smallest in comparison with it; so a finer step is not
    taken just because everything is nearer to it.

    Args:
        headings: (S,) degrees.
        step: if it is known, degrees.

    Returns:
        Step and offset (0 <= offset < step) in degrees; None if most headings are far from every even step.
    """
    best: tuple[float, float, float] | None = None
    for tried in HEADING_STEPS if step is None else (step,):
        turns = np.exp(2j * np.pi * headings / tried)
        offset = float(np.angle(turns.mean()) / (2 * np.pi) * tried)
        away = np.abs(around(headings - offset, tried))
        if step is None and np.quantile(away, 0.9) > min(_HEADING_REACH, tried / 3):
            continue
        score = max(float(np.median(away)), 0.5) / tried  # a median, as a single mistake must not decide
        if best is None or score < best[0]:
            best = score, tried, offset % tried
    return None if best is None else best[1:]


def fit_tilts(tilts: NDArray[np.float64]) -> tuple[NDArray[np.int64], NDArray[np.float64]] | None:
    """The levels of tilt; None if they run into each other.

    Values that occur again and again and are far apart are taken as they are. Others, also whole degrees that were
    read off, are one level as far as they are closer to each other than to the next level.

    Args:
        tilts: (S,) degrees.

    Returns:
        (S,) number of each one's level, and the levels in degrees, ascending.
    """
    values = np.unique(np.round(tilts, 2))
    exact = len(values) <= min(_EXACT_LEVELS, len(tilts) / 2) and (np.diff(values) >= _EXACT_GAP).all()
    ends = np.arange(len(values) - 1) if exact else _ends_of_levels(values)
    if ends is None:
        return None
    numbers = np.searchsorted((values[ends] + values[ends + 1]) / 2, tilts).astype(np.int64)
    if exact:
        return numbers, values
    middles = np.bincount(numbers, tilts) / np.bincount(numbers)
    fives = np.round(middles / 5) * 5  # what people choose
    return numbers, np.where(np.abs(middles - fives) <= 2, fives, np.round(middles)) + 0.0


def _ends_of_levels(values: NDArray[np.float64]) -> NDArray[np.int64] | None:
    """Where in ascending values each level but the last ends: at as many of the widest gaps as can be."""
    gaps = np.diff(values)
    widest = np.argsort(-gaps, kind="stable")
    for count in range(min(len(gaps), round(180 / _TILT_GAP)), -1, -1):
        ends = np.sort(widest[:count])
        lowest, highest = values[np.concatenate([[0], ends + 1])], values[np.append(ends, len(values) - 1)]
        others = np.delete(gaps, ends).max(initial=0.0)
        clear = gaps[ends].min(initial=np.inf) >= min(2 * others, _TILT_GAP)
        apart = np.diff((lowest + highest) / 2).min(initial=np.inf) >= _TILT_GAP
        if clear and apart and (highest - lowest).max() <= 2 * _TILT_GAP:
            return ends
    return None


def fit_places(
    points: NDArray[np.complex128], views: NDArray[np.int64], spacing: float | None = None
) -> Places | None:
    """The lattice of places; its rotation is within 45 degrees.

    It is found from differences between points, near ones first: what they say of the axis tells which whole numbers
    the differences between farther points are, and these say more of the axis.

    Args:
        points: (S,) x + i z in metres, of at least two places.
        views: (S,) number of heading and tilt: points with the same number are different places.
        spacing: if it is known, metres.

    Returns:
        None if no two points tell the spacing.
    """
    first = _typical_step(points, views) or spacing
    if first is None:
        return None
    some = _sample(points, views)
    differences = (some[:, None] - some[None])[np.triu_indices(len(some), 1)]
    lengths = np.abs(differences)
    steps = differences[(lengths > 0.7 * first) & (lengths < 1.3 * first)]
    if not len(steps):
        return None
    axis = first * np.exp(1j * np.angle(((steps / np.abs(steps)) ** 4).mean()) / 4)
    if spacing is not None:
        axis *= spacing / first
    radius, extent = 1.7 * first, float(lengths.max())
    for _ in range(60):
        near = differences[lengths <= radius]
        numbers = _whole(near / axis)
        weight = float((np.abs(numbers) ** 2).sum())
        if weight:
            axis = (numbers.conj() * near).sum() / weight
        if spacing is not None:
            axis *= spacing / np.abs(axis)
        if radius > extent:
            break
        radius *= 1.25
    axis *= 1j ** -np.round(np.angle(axis) / (np.pi / 2))
    return _round(_with_corner(complex(axis), points), points, spacing)


def around(values: NDArray[np.float64], step: float) -> NDArray[np.float64]:
    """Values modulo a step, from -step/2 to step/2."""
    return (values + step / 2) % step - step / 2


def _typical_step(points: NDArray[np.complex128], views: NDArray[np.int64]) -> float | None:
    """Median distance to the nearest other place seen in the same direction."""
    nearest = []
    for view in np.unique(views):
        same = points[views == view]
        if len(same) > 1:
            flat = np.column_stack([same.real, same.imag])
            distances = cKDTree(flat).query(flat, k=min(6, len(same)))[0]
            # Nearer ones are other photographs of the same pose.
            nearest.append(np.where(distances > ONE_PLACE / 3, distances, np.inf).min(1))
    found = np.concatenate(nearest) if nearest else np.empty(0)
    found = found[np.isfinite(found)]
    return float(np.median(found)) if len(found) else None


def _sample(points: NDArray[np.complex128], views: NDArray[np.int64]) -> NDArray[np.complex128]:
    """So many points as can be paired: all of one direction before any of the next, so that neighbours are in it."""
    return points[np.argsort(views, kind="stable")[:_PAIRED]]


def _with_corner(axis: complex, points: NDArray[np.complex128]) -> Places:
    """The places along a known axis: the corner is where they are nearest to the points."""
    parts = points / axis
    phase = complex(*(np.angle(np.exp(2j * np.pi * part).mean()) / (2 * np.pi) for part in (parts.real, parts.imag)))
    numbers = _whole(parts - phase)
    lowest = complex(numbers.real.min(), numbers.imag.min())
    return Places(axis, complex((points - axis * (numbers - lowest)).mean()))


def _round(places: Places, points: NDArray[np.complex128], spacing: float | None) -> Places:
    """The same with round numbers where they fit the points as well: no rotation, centimetres."""

    def fits(other: Places) -> bool:
        before, after = (np.sqrt((one.distances(points) ** 2).mean()) for one in (places, other))
        return bool(after <= 1.02 * before + 0.0005)

    size, angle = abs(places.axis), np.angle(places.axis)
    sizes = [spacing or size] if spacing else [round(size, 2), size]
    for tried in [length * np.exp(1j * turn) for turn in (0.0, angle) for length in sizes]:
        if abs(tried) and fits(rounded := _with_corner(complex(tried), points)):
            places = rounded
            break
    corner = Places(places.axis, complex(round(places.corner.real, 2), round(places.corner.imag, 2)))
    return corner if fits(corner) else places


def _whole(numbers: NDArray[np.complex128]) -> NDArray[np.complex128]:
    return np.round(numbers.real) + 1j * np.round(numbers.imag)
