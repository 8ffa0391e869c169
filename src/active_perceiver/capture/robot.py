"""`scenes capture robot`: a robot drives to the poses of a table and photographs what it sees there.

The folder is what `scenes import photos` reads, at any moment: each photograph is there when it was taken, and
`poses.csv` names those that are. It says the poses that were meant; how far the robot was beside them is what its
odometry got wrong. `capture.json` tells that a capture wrote the folder, and what it is to hold in the end.
"""

from __future__ import annotations

import json
import logging
import math
import re
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from active_perceiver.capture.tour import LONGEST, PlacesError, Tour, seen_from
from active_perceiver.datasets.photos.pose_table import PoseTable, write_poses
from active_perceiver.robots import NavigatingRobot
from active_perceiver.robots.motion import driving
from active_perceiver.scenes.angles import signed_angle
from active_perceiver.scenes.images import encode_image
from active_perceiver.scenes.lattice import nearest_tilt
from active_perceiver.utils.files import OutputExistsError, replacing
from active_perceiver.utils.progress import ProgressBar, progress_bar

LOG = logging.getLogger(__name__)

FORMAT = "active-perceiver-capture"
SIGN, POSES = "capture.json", "poses.csv"
JPEG_QUALITY = 92
# Degrees by which the robot's tilt may differ from the wanted one.
TILT_OFF = 5.0
NAME = re.compile(r"[\w() -][\w(). -]*\.jpe?g", re.IGNORECASE)


@dataclass(frozen=True)
class Captured:
    """How it went.

    Attributes:
        taken: photographs of this run.
        there: photographs in the folder now.
        blocked: those that could not be taken because no way to their places was found, in the table's order.
        left: those that are still to be taken.
        next: where the robot stands now to go on, a number of the table; None if it is back where it began.
    """

    taken: int
    there: int
    blocked: tuple[str, ...]
    left: tuple[str, ...]
    next: int | None


def photograph_places(
    robot: NavigatingRobot,
    table: PoseTable,
    folder: Path,
    *,
    at: str | None = None,
    at_once: int | None = None,
    force: bool = False,
    resume: bool = False,
    progress: ProgressBar = progress_bar,
) -> Captured:
    """Take a photograph at each pose of a table, place after place, and drive back to where the robot began.

    What the odometry gets wrong adds up. So after some places the robot may be asked to drive to the next one and to
    wait there, for somebody to put it exactly on that mark; `at` then says where it stands. A place that cannot be
    reached is left out. Whatever ends this, what was taken is kept.

    Args:
        robot: it stands at a pose of the table; entered as a context manager.
        table: poses and the names of their photographs.
        folder: the folder to write; what else is in it, as pictures of targets, stays as it is.
        at: the photograph at whose pose it stands; the first of the table if None.
        at_once: end after so many places, at the next one.
        force: take all photographs of an earlier capture anew.
        resume: take those that are missing.
        progress: opens a progress bar.

    Returns:
        How it went.

    Raises:
        PlacesError: if the robot has not the tilts of the poses, a place is far from all others, there is no
            photograph `at`, or one has a name that no file should have.
        OutputExistsError: if the folder holds photographs and nothing says what to do with them, or they are others.
        UserError: if the robot cannot go on; it says why.
    """
    tilts = _tilts_of(robot, table)
    if at_once is not None and at_once < 1:
        raise PlacesError(f"places at once are 1 or more, got {at_once}")
    if at is not None and at not in table.files:
        raise PlacesError(f"{table.path} has no photograph {at[:80]!r}; name the one at whose pose the robot stands")
    standing = 0 if at is None else table.files.index(at)
    poses = seen_from(table.poses, standing)
    poses[:, 3] = tilts
    tour = Tour(poses)
    _check_ways(tour, table, standing)
    album = _Album.begin(folder, table, force=force, resume=resume)
    journey = _Journey(robot, tour, poses, standing)
    taken, places = 0, 0
    following: int | None = None
    try:
        with progress("photographs") as report:
            while views := journey.next_place(album.missing()):
                if places == at_once:
                    following = views[0]
                    journey.look_towards(following)
                    break
                places += 1
                for number in views:
                    if journey.look_towards(number):
                        album.keep(number, robot.look())
                        taken += 1
                        report(len(album.there), len(table.files), table.files[number])
            else:
                journey.go_home()
    except (Exception, KeyboardInterrupt):
        LOG.warning(
            "%d of %d photographs are in %s; put the robot back to where it began, or on another mark that --at "
            "names, and go on with --resume", len(album.there), len(table.files), folder,
        )  # fmt: skip
        raise
    missing = album.missing()
    blocked = [number for number in missing if journey.unreachable(number)]
    left = [number for number in missing if number not in blocked]
    names = np.array(table.files)
    return Captured(taken, len(album.there), tuple(names[blocked].tolist()), tuple(names[left].tolist()), following)


class _Journey:
    """The robot on its tour: where it is, and how far it has turned."""

    def __init__(self, robot: NavigatingRobot, tour: Tour, poses: NDArray[np.float64], standing: int) -> None:
        self._robot, self._tour, self._poses, self._began = robot, tour, poses, standing
        self._here = int(tour.place_of[standing])
        self._heading = 0.0
        self._tilt = float(poses[standing, 3])
        self._lost: set[int] = set()

    def next_place(self, missing: list[int]) -> list[int]:
        """Go to the nearest place of missing views; those of them there, in the order in which to take them."""
        missing = [number for number in missing if number not in self._lost]
        wanted = {int(self._tour.place_of[number]) for number in missing}
        if not self._drive(wanted):
            return []
        views = [number for number in missing if self._tour.place_of[number] == self._here]
        return self._tour.views(views, self._heading, self._tilt)

    def look_towards(self, number: int) -> bool:
        """Turn to a view of this place; False, for good, if the robot cannot."""
        x, z, heading, tilt = self._poses[number].tolist()
        if not self._robot.go_to(x, z, heading, tilt):
            self._lost.add(number)
            return False
        self._turned_to(heading)
        self._tilt = tilt
        return True

    def go_home(self) -> None:
        """Back to where it began, if there is a way."""
        if self._drive({int(self._tour.place_of[self._began])}):
            self._robot.go_to(*self._poses[self._began].tolist())

    def unreachable(self, number: int) -> bool:
        """Whether a view could not be taken."""
        place = int(self._tour.place_of[number])
        return number in self._lost or self._tour.way(self._here, {place}) is None

    def _drive(self, wanted: set[int]) -> bool:
        """Drive to the nearest of these places, round what is in the way; False if there is no way to any."""
        while (way := self._tour.way(self._here, wanted)) is not None:
            if not way:
                return True
            x, z = self._tour.places[way[0]].tolist()
            from_x, from_z = self._tour.places[self._here].tolist()
            heading = driving(self._heading, math.degrees(math.atan2(x - from_x, z - from_z)))
            if self._robot.go_to(x, z, heading, self._tilt):
                self._turned_to(heading)
                self._here = way[0]
                self._tour.reached(self._here)
            else:
                self._tour.blocked(self._here, way[0])
        return False

    def _turned_to(self, heading: float) -> None:
        self._heading += signed_angle(heading - self._heading)


class _Album:
    """The folder: photographs as they are taken, and a table of those that are there."""

    def __init__(self, folder: Path, table: PoseTable, there: set[int]) -> None:
        self.there = there
        self._folder, self._table = folder, table

    @classmethod
    def begin(cls, folder: Path, table: PoseTable, *, force: bool, resume: bool) -> _Album:
        for name, line in zip(table.files, table.lines, strict=True):
            if not NAME.fullmatch(name):
                raise PlacesError(
                    f"{table.path}, line {line}: a photograph cannot be called {name[:80]!r}; give a name such as "
                    "IMG_0001.jpg, without a folder, or leave it out"
                )
        noted = {"format": FORMAT, "version": 1, "files": list(table.files), "poses": table.poses.tolist()}
        earlier = _noted(folder)
        if earlier is None:
            _check_foreign(folder, table)
        elif not (force or resume):
            raise OutputExistsError(
                f"{folder} holds photographs of a capture; --resume takes those that are missing, --force all anew"
            )
        elif resume and earlier != noted:
            raise OutputExistsError(
                f"{folder} was begun with other places than {table.path}; give the same table, another --out, or "
                "--force to take all photographs anew"
            )
        elif not resume:
            for path in (folder / POSES, *(folder / name for name in earlier["files"])):
                path.unlink(missing_ok=True)
        with replacing(folder / SIGN) as temporary:
            temporary.write_text(json.dumps(noted) + "\n", encoding="utf-8")
        there = {number for number, name in enumerate(table.files) if (folder / name).is_file()}
        album = cls(folder, table, there)
        if there:
            album._write_table()
        return album

    def missing(self) -> list[int]:
        """Numbers of the photographs that are still to be taken."""
        return [number for number in range(len(self._table.files)) if number not in self.there]

    def keep(self, number: int, image: NDArray[np.uint8]) -> None:
        """Write a photograph, then the table."""
        with replacing(self._folder / self._table.files[number]) as temporary:
            temporary.write_bytes(encode_image(image, "jpeg", JPEG_QUALITY))
        self.there.add(number)
        self._write_table()

    def _write_table(self) -> None:
        chosen = sorted(self.there)
        with replacing(self._folder / POSES) as temporary:
            write_poses(temporary, [self._table.files[number] for number in chosen], self._table.poses[chosen])


def _noted(folder: Path) -> dict[str, Any] | None:
    """What a capture noted in a folder; None if none did."""
    try:
        noted = json.loads((folder / SIGN).read_bytes())
        whole = noted["format"] == FORMAT and all(NAME.fullmatch(name) for name in noted["files"])
    except (OSError, ValueError, LookupError, TypeError, RecursionError):
        return None
    return noted if whole else None


def _check_foreign(folder: Path, table: PoseTable) -> None:
    """A folder that no capture wrote may hold other things, but nothing that would be replaced."""
    if folder.exists() and not folder.is_dir():
        raise OutputExistsError(f"{folder} is a file; give another --out")
    for name in (SIGN, POSES, *table.files):
        if (folder / name).exists():
            raise OutputExistsError(f"{folder} holds a {name} that no capture wrote; give another --out")


def _tilts_of(robot: NavigatingRobot, table: PoseTable) -> NDArray[np.float64]:
    """The robot's tilt for each pose."""
    wanted = table.poses[:, 3]
    nearest = np.array([robot.tilts[nearest_tilt(robot.tilts, tilt)] for tilt in wanted])
    off = np.abs(nearest - wanted)
    if off.max() > TILT_OFF:
        worst = int(off.argmax())
        raise PlacesError(
            f"{table.path}, line {table.lines[worst]}: the robot has no tilt of {wanted[worst]:g} degrees, its tilts "
            f"are {', '.join(f'{tilt:g}' for tilt in robot.tilts)}; correct the table, or the tilts of the robot's "
            "settings"
        )
    return nearest


def _check_ways(tour: Tour, table: PoseTable, standing: int) -> None:
    """Refuse places to which no robot should be sent, before it moves."""
    cut_off = tour.cut_off(int(tour.place_of[standing]))
    if len(cut_off):
        number = int((tour.place_of == cut_off[0]).argmax())
        x, z = table.poses[number, :2]
        raise PlacesError(
            f"{table.path}, line {table.lines[number]}: from where the robot stands to x {x:g}, z {z:g} there are no "
            f"places at most {LONGEST:g} m apart; x and z are metres: correct the table"
        )
