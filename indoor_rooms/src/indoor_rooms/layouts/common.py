"""What all layouts share: ledges on furniture and sills, windows, things on walls, whether a robot gets about."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np
from numpy.typing import NDArray

from indoor_rooms.free_space import FreeSpaceError, free_positions
from indoor_rooms.furniture import fixtures, soft
from indoor_rooms.layouts.placement import Ledge, NoRoomError, RoomBuilder
from indoor_rooms.layouts.shell import Window
from indoor_rooms.layouts.walls import FloorLayout, Wall
from indoor_rooms.materials.material import Material
from indoor_rooms.materials.surfaces import BLACK_PLASTIC, BRASS, CHROME
from indoor_rooms.materials.themes import Theme, curtain_of, pick_one
from indoor_rooms.room import Lamp, Room, Sun

# A robot that comes no closer than this to where a thing stands cannot be said to have reached it; metres.
WITHIN_REACH = 1.1
FEWEST_PLACES = 30
# A robot that stands no farther from the middle of a thing can look at it from near; metres.
NEAR_ENOUGH = 1.25
# How far sill and curtains reach into the room, metres.
WINDOW_REACH = 0.22


def make_window(
    plan: FloorLayout, wall: Wall, rng: np.random.Generator, low: tuple[float, float], height: float
) -> Window:
    """A window somewhere in a wall, of a size that suits it.

    The wall there is taken, and the floor below but for a radiator: sill and curtains reach into the room.

    Raises:
        NoRoomError: if the wall has no room for one.
    """
    width = float(rng.uniform(1.0, min(1.9, wall.length * 0.5)))
    along = plan.hanging_place(wall, width + 0.5, rng, out=WINDOW_REACH)
    if along is None:
        raise NoRoomError(f"no window fits into the {wall.name} wall")
    plan.take(wall.rectangle(along, width + 0.5, 0.0, WINDOW_REACH))
    sill = float(rng.uniform(*low))
    return Window(
        wall, along, width, sill, min(height - 0.28, sill + float(rng.uniform(1.0, 1.25))), 3 if width > 1.5 else 2
    )


def sill_ledge(window: Window) -> Ledge:
    """Where things stand on a window's sill, which reaches back to the sash."""
    back = fixtures.WALL_THICKNESS - 0.066
    return wall_ledge(
        window.wall,
        (window.along, (window.sill - back) / 2, window.low + 0.0005),
        (window.width - 0.12, window.sill + back - 0.02),
        "sill",
        "sill",
        window.high - window.low - 0.1,
    )


def wall_ledge(
    wall: Wall,
    place: tuple[float, float, float],
    size: tuple[float, float],
    furniture: str,
    kind: str,
    headroom: float = np.inf,
) -> Ledge:
    """The top of furniture along a wall.

    Args:
        wall: at which it stands.
        place: of its middle: along the wall, out from it and above the floor, metres.
        size: along the wall and out from it, metres.
        furniture: its name.
        kind: of ledge: what may lie on it.
        headroom: metres above it.
    """
    (along, out, height), (width, depth) = place, size
    first, last = wall.point(along - width / 2, out), wall.point(along + width / 2, out)
    return Ledge(furniture, kind, first[:2], last[:2], height, depth, headroom)


def dress_window(builder: RoomBuilder, window: Window, theme: Theme, rng: np.random.Generator, floor: bool) -> None:
    """Curtains or a blind; curtains reach the floor only where nothing stands below."""
    wall = window.wall
    place, turn = wall.point(wall.length / 2), wall.turn
    if rng.random() < 0.6:
        cloth = curtain_of(pick_one(rng, ("#efe9dc", "#e4e0d6", theme.accent, theme.fabric)))
        rod = pick_one(rng, (BLACK_PLASTIC, CHROME, BRASS))
        builder.add("curtain", soft.curtains(window.opening, cloth, rod, "floor" if floor else "sill"), place, turn)
    else:
        share = float(rng.uniform(0.15, 0.45))
        builder.add(
            "blinds",
            soft.blinds(window.opening, pick_one(rng, ("#f2efe8", "#d8d2c4", "#b9c2c6")), share),
            place,
            turn,
        )


def hang_pictures(
    builder: RoomBuilder,
    plan: FloorLayout,
    frame: Material,
    rng: np.random.Generator,
    count: int,
    walls: Iterable[Wall],
) -> None:
    """Framed pictures wherever a wall is free at eye height."""
    candidates = list(walls)
    for number in range(1, count + 1):
        wall = pick_one(rng, candidates)
        width, height = ((0.95, 0.66), (0.6, 0.8), (0.5, 0.5), (1.1, 0.55))[int(rng.integers(4))]
        along = plan.hanging_place(wall, width, rng)
        if along is not None:
            picture = fixtures.picture(width, height, frame, int(rng.integers(12)))
            builder.add(
                f"picture_{number}", picture, wall.point(along, 0.001, float(rng.uniform(1.55, 1.68))), wall.turn
            )


def places_in(builder: RoomBuilder, plan: FloorLayout) -> NDArray[np.float64]:
    """Where a robot can stand, (P, 2) metres.

    Raises:
        NoRoomError: if there are less than `FEWEST_PLACES` connected places.
    """
    try:
        places = free_positions(bare_room(builder, plan, 2.5))
    except FreeSpaceError as error:
        raise NoRoomError(str(error)) from None
    if len(places) < FEWEST_PLACES:
        raise NoRoomError(f"only {len(places)} places for a robot")
    return places


def within_reach(builder: RoomBuilder, plan: FloorLayout, ledges: Sequence[Ledge]) -> list[Ledge]:
    """The ledges a robot can come close to, all along.

    Raises:
        NoRoomError: if a robot finds too few places.
    """
    places = places_in(builder, plan)
    reached = []
    for ledge in ledges:
        steps = np.linspace(0, 1, 5)[:, None]
        points = np.asarray(ledge.start) * (1 - steps) + np.asarray(ledge.end) * steps
        gaps = np.linalg.norm(points[:, None] - places[None], axis=-1).min(axis=1)
        if gaps.max() <= WITHIN_REACH:
            reached.append(ledge)
    return reached


def check_targets(builder: RoomBuilder, plan: FloorLayout, targets: Iterable[str]) -> None:
    """Make sure that a robot can come near every target, now that bags and balls lie on the floor.

    Raises:
        NoRoomError: if it cannot.
    """
    places = places_in(builder, plan)
    wanted = set(targets)
    points: dict[str, list[NDArray[np.float64]]] = {}
    for part in builder.parts:
        if part.object_name in wanted:
            points.setdefault(part.object_name, []).append(part.mesh.vertices[:, :2])
    for name, vertices in points.items():
        corners = np.concatenate(vertices)
        middle = (corners.min(axis=0) + corners.max(axis=0)) / 2
        if np.linalg.norm(places - middle, axis=1).min() > NEAR_ENOUGH:
            raise NoRoomError(f"a robot cannot come near the {name}")


def bare_room(
    builder: RoomBuilder,
    plan: FloorLayout,
    height: float,
    name: str = "room",
    targets: dict[str, str] | None = None,
    sun: Sun | None = None,
    sky: tuple[float, float, float] = (0.0, 0.0, 0.0),
    lamps: Sequence[Lamp] = (),
) -> Room:
    """What has been built so far as a Room."""
    return Room(
        name=name,
        size=(plan.width, plan.depth, height),
        parts=tuple(builder.parts),
        targets=targets or {},
        sun=sun,
        sky=sky,
        lamps=tuple(lamps),
        obstacles=tuple(builder.obstacles),
    )
