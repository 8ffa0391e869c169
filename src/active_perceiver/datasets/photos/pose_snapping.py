"""Snapping poses to the lattice they were meant to lie on, and what has to be said about that.

Poses written down by a person or an odometry are some centimetres and degrees off. Spacing, rotation and corner of
the places, step of the headings and levels of the tilts are found from the poses themselves (`lattice_fit.py`), or
given.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from active_perceiver.datasets.photos.lattice_fit import (
    ONE_PLACE,
    Places,
    around,
    fit_headings,
    fit_places,
    fit_tilts,
)
from active_perceiver.datasets.photos.pose_table import PoseTable
from active_perceiver.scenes.scene import SceneError

# A pose farther from the lattice than this share of a step might as well belong to the next one.
_TOO_FAR = 1 / 3
# Headings turned by so many degrees against the grid of places are taken to follow it: a compass is off.
_COMPASS_ERROR = 10.0
# More photographs than this share of all on poses of others: the lattice is wrong, not the photographs.
_MOST_DOUBLES = 0.1
_LISTED = 5


@dataclass(frozen=True)
class LatticeConfig:
    """What is known of the lattice; None to find it.

    Attributes:
        spacing: metres between neighbouring places.
        heading_step: degrees between neighbouring headings, a whole number of which is a full turn.
        tilts: degrees, all levels.
    """

    spacing: float | None = None
    heading_step: float | None = None
    tilts: tuple[float, ...] | None = None

    def __post_init__(self) -> None:
        if self.spacing is not None and not 0.01 <= self.spacing <= 1000:
            raise SceneError(f"the spacing is metres between neighbouring places, from 0.01, got {self.spacing}")
        step = self.heading_step
        if step is not None and not (1 <= step <= 360 and abs(360 / step - round(360 / step)) < 1e-6):
            raise SceneError(f"the heading step is degrees that divide a full turn, as 90, 45 or 30, got {step}")
        if self.tilts is not None and not (self.tilts and all(abs(tilt) <= 90 for tilt in self.tilts)):
            raise SceneError(f"the tilts are degrees from -90 to 90, at least one, got {list(self.tilts)}")


@dataclass(frozen=True, eq=False)
class Snapped:
    """Poses on a lattice.

    Attributes:
        poses: (S, 4) float32, on the lattice; a rotated room is turned upright around its corner.
        kept: (S,) bool: False for a photograph that lies farther from its pose than another photograph.
        spacing: metres between neighbouring places; 1 if there is only one place.
        heading_step: degrees.
        moved: (S, 3) float64, by how much each was snapped: metres, degrees of heading, degrees of tilt.
        notes: what was found and done, a sentence each.
    """

    poses: NDArray[np.float32]
    kept: NDArray[np.bool_]
    spacing: float
    heading_step: float
    moved: NDArray[np.float64]
    notes: tuple[str, ...]


def snap_poses(table: PoseTable, settings: LatticeConfig) -> Snapped:
    """Snap all poses of a table.

    Of several photographs that fall on one pose the nearest is kept, and a note names the others.

    Raises:
        SceneError: if the poses lie on no lattice, one is too far from it, or many fall on the same pose.
    """
    headings, step, offset = _headings(table, settings.heading_step)
    tilt, levels = _tilts(table, settings.tilts)
    points = table.poses[:, 0] + 1j * table.poses[:, 1]
    places = _places(table, points, headings * len(levels) + tilt, settings.spacing)
    numbers = places.nearest(points)
    spacing, rotation = abs(places.axis), float(np.degrees(np.angle(places.axis)))
    # Turning the room upright turns what is clockwise from above by as much the other way.
    upright = float(around(np.array([offset + rotation]), step)[0])
    if abs(upright) <= min(_COMPASS_ERROR, step / 4):
        first, turned = 0.0, upright
    else:
        first, turned = round(upright, 1), 0.0
    cells = np.column_stack([numbers.real, numbers.imag, headings, tilt]).astype(np.int64)
    poses = np.column_stack(
        [
            places.corner.real + spacing * numbers.real,
            places.corner.imag + spacing * numbers.imag,
            ((headings + np.round((offset + rotation - upright) / step)) * step + first) % 360,
            levels[tilt],
        ]
    )
    moved = np.column_stack(
        [
            places.distances(points),
            np.abs(around(table.poses[:, 2] - offset, step)),
            np.abs(table.poses[:, 3] - levels[tilt]),
        ]
    )
    _refuse_far_ones(table, moved, spacing, step)
    kept, doubles = _nearest_of_each(table, cells, moved / [spacing, step, 90.0])
    notes = [
        _found(poses, spacing, step, levels, rotation, turned, first),
        _snapped_by(table, moved),
        *doubles,
        *_missing(cells[kept], poses[kept]),
    ]
    return Snapped(poses.astype(np.float32), kept, spacing, step, moved, tuple(notes))


def _headings(table: PoseTable, step: float | None) -> tuple[NDArray[np.int64], float, float]:
    """Number of each heading, the step and the first heading in degrees."""
    fitted = fit_headings(table.poses[:, 2], step)
    if fitted is None:
        raise SceneError(f"{table.path}: the headings follow no even step; give --heading-step, or correct them")
    step, offset = fitted
    numbers = np.round((table.poses[:, 2] - offset) / step).astype(np.int64) % round(360 / step)
    return numbers, step, offset


def _tilts(table: PoseTable, given: tuple[float, ...] | None) -> tuple[NDArray[np.int64], NDArray[np.float64]]:
    """Number of each tilt, and the levels in degrees."""
    tilts = table.poses[:, 3]
    if given is not None:
        levels = np.unique(np.array(given, float))
        return np.abs(tilts[:, None] - levels).argmin(1), levels
    fitted = fit_tilts(tilts)
    if fitted is None:
        raise SceneError(
            f"{table.path}: the tilts, from {tilts.min():g} to {tilts.max():g} degrees, do not fall into levels; "
            "give --tilts"
        )
    return fitted


def _places(
    table: PoseTable, points: NDArray[np.complex128], views: NDArray[np.int64], spacing: float | None
) -> Places:
    middle = complex(np.median(points.real), np.median(points.imag))
    if np.abs(points - middle).max() < ONE_PLACE:
        return Places(complex(spacing or 1.0), complex(round(middle.real, 2), round(middle.imag, 2)))
    places = fit_places(points, views, spacing)
    if places is None:
        raise SceneError(f"{table.path}: the poses do not tell how far apart places are; give --spacing")
    if np.median(places.distances(points)) > 0.2 * abs(places.axis):
        raise SceneError(
            f"{table.path}: the places lie on no square grid (the nearest guess is {abs(places.axis):.2f} m apart, "
            f"and half of the places are more than {100 * np.median(places.distances(points)):.0f} cm from it); give "
            "--spacing, or the moves in moves.csv"
        )
    return places


def _refuse_far_ones(table: PoseTable, moved: NDArray[np.float64], spacing: float, step: float) -> None:
    limits = np.array([spacing * _TOO_FAR, step * _TOO_FAR, 15.0])
    far = np.flatnonzero((moved > limits).any(1))
    if not len(far):
        return
    worst = int(far[(moved[far] / limits).max(1).argmax()])
    column = int((moved[worst] / limits).argmax())
    what = (
        f"{100 * moved[worst, 0]:.0f} cm from the nearest place (they are {spacing:.2f} m apart)",
        f"{moved[worst, 1]:.0f} degrees from the nearest heading (they are {step:g} degrees apart)",
        f"{moved[worst, 2]:.0f} degrees from the nearest tilt",
    )[column]
    others = f"; so are {len(far) - 1} others" if len(far) > 1 else ""
    raise SceneError(
        f"{table.path}, line {table.lines[worst]}: {table.files[worst]} is {what}; correct the line or take it out, "
        f"or give {('--spacing', '--heading-step', '--tilts')[column]}{others}"
    )


def _nearest_of_each(
    table: PoseTable, cells: NDArray[np.int64], away: NDArray[np.float64]
) -> tuple[NDArray[np.bool_], list[str]]:
    """Which photographs are the nearest to their pose, and a note on the others."""
    kept = np.zeros(len(cells), bool)
    order = np.argsort(away.sum(1), kind="stable")
    _, first = np.unique(cells[order], axis=0, return_index=True)
    kept[order[first]] = True
    dropped = np.flatnonzero(~kept)
    if len(dropped) > _MOST_DOUBLES * len(cells):
        holder = int(np.flatnonzero(kept & (cells == cells[dropped[0]]).all(1))[0])
        raise SceneError(
            f"{table.path}: {len(dropped)} of {len(cells)} photographs fall on the pose of another, as "
            f"{table.files[dropped[0]]} on that of {table.files[holder]}; give --spacing, --heading-step and "
            "--tilts, or take one of each two out"
        )
    if not len(dropped):
        return kept, []
    names = _some([table.files[index] for index in dropped])
    return kept, [f"left out, as another photograph is nearer to the same pose: {names}"]


def _found(
    poses: NDArray[np.float64], spacing: float, step: float, levels: NDArray[np.float64], rotation: float,
    turned: float, first: float,
) -> str:  # fmt: skip
    places = len(np.unique(poses[:, :2], axis=0))
    turn = f"; the room was turned by {rotation:.1f} degrees" if abs(rotation) > 0.05 else ""
    if abs(turned) > 0.5:
        turn += f"; the headings were {turned:.1f} degrees off its grid"
    if first:
        turn += f"; the headings start at {first:g} degrees, off its grid: no move ahead leads to another place"
    apart = f"{spacing:.3g} m apart" if places > 1 else "alone"
    return (
        f"lattice: {places} places {apart}, headings every {step:g} degrees, tilts "
        f"{', '.join(f'{level:g}' for level in levels)}{turn}"
    )


def _snapped_by(table: PoseTable, moved: NDArray[np.float64]) -> str:
    median, most = np.median(moved, axis=0), moved.max(0)
    farthest = table.files[int(moved[:, 0].argmax())]
    text = (
        f"snapped in the median (at most) by {100 * median[0]:.1f} ({100 * most[0]:.1f}) cm, heading {median[1]:.1f} "
        f"({most[1]:.1f}) degrees, tilt {median[2]:.1f} ({most[2]:.1f}) degrees"
    )
    return text if most[0] < 0.005 else f"{text}; farthest {farthest}"


def _missing(cells: NDArray[np.int64], poses: NDArray[np.float64]) -> list[str]:
    """A note on views that some places lack: each heading and tilt that occurs could be there at each place."""
    there = {tuple(cell) for cell in cells.tolist()}
    heading_of = dict(zip(cells[:, 2].tolist(), poses[:, 2].tolist(), strict=True))
    tilt_of = dict(zip(cells[:, 3].tolist(), poses[:, 3].tolist(), strict=True))
    place_of = {tuple(cell[:2]): pose[:2] for cell, pose in zip(cells.tolist(), poses.tolist(), strict=True)}
    gone = [
        f"({place_of[place][0]:.2f}, {place_of[place][1]:.2f}) heading {heading_of[heading]:g} tilt {tilt_of[tilt]:g}"
        for place in place_of
        for heading in sorted(heading_of)
        for tilt in sorted(tilt_of)
        if (*place, heading, tilt) not in there
    ]
    full = len(place_of) * len(heading_of) * len(tilt_of)
    return [f"{len(gone)} of {full} views are missing: {_some(gone, '; ')}"] if gone else []


def _some(names: list[str], separator: str = ", ") -> str:
    more = f" and {len(names) - _LISTED} more" if len(names) > _LISTED else ""
    return separator.join(names[:_LISTED]) + more
