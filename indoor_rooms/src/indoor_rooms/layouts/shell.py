"""Floor, ceiling, walls, windows and door of a room, its lamps and the light that comes in."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from indoor_rooms.furniture import fixtures
from indoor_rooms.geometry.mesh import quad
from indoor_rooms.layouts.daylight import Daylight, scaled
from indoor_rooms.layouts.placement import NoRoomError, RoomBuilder
from indoor_rooms.layouts.walls import FloorLayout, Wall
from indoor_rooms.materials.material import Colour, Material, from_hex
from indoor_rooms.materials.themes import Theme, WoodTones, finish_of, paint_of, pick_one
from indoor_rooms.room import Lamp

# A door's leaf and frame, and the floor in front of it that stays free; metres.
DOOR_WIDTH, DOOR_SPACE = 1.08, 0.80
SKIRTED_FROM = 0.12


@dataclass(frozen=True)
class Window:
    """A window in a wall.

    Attributes:
        wall: in which it is.
        along: its middle along the wall, metres.
        width: metres.
        low: height of its sill.
        high: height of its top.
        panes: side by side.
        sill: how far its board reaches into the room.
    """

    wall: Wall
    along: float
    width: float
    low: float
    high: float
    panes: int = 2
    sill: float = 0.10

    @property
    def opening(self) -> fixtures.Opening:
        """Its edges (x from, x to, z from, z to), seen from the wall's middle."""
        middle = self.along - self.wall.length / 2
        return (middle - self.width / 2, middle + self.width / 2, self.low, self.high)


def raise_walls(
    builder: RoomBuilder,
    plan: FloorLayout,
    height: float,
    windows: Sequence[Window],
    theme: Theme,
    feature: Wall | None,
    floor: Material,
) -> None:
    """Build floor, ceiling, walls, their windows and skirting boards, once all that stands at the walls is there.

    Args:
        builder: takes the parts.
        plan: the room's size and walls.
        height: of the ceiling, metres.
        windows: at most one in each wall.
        theme: the walls' paints.
        feature: the wall of the theme's other colour, if it has one.
        floor: material.
    """
    width, depth = plan.width, plan.depth
    builder.add("floor", [(quad((0, 0, 0), (width, 0, 0), (0, depth, 0), 0.55), floor)])
    white = Material(from_hex("#f7f6f2"), roughness=0.95, specular=0.1)
    builder.add("ceiling", [(quad((0, depth, height), (width, 0, 0), (0, -depth, 0), 0.5), white)])
    openings = {window.wall.name: window.opening for window in windows}
    for name, wall in plan.walls.items():
        paint = paint_of(theme.feature if theme.feature and wall is feature else theme.walls)
        mesh = fixtures.wall(wall.length, height, openings.get(name))
        builder.add("wall", [(mesh, paint)], wall.point(wall.length / 2), wall.turn)
    for window in windows:
        wall = window.wall
        builder.add(
            "window",
            fixtures.window(window.opening, window.panes, window.sill),
            wall.point(wall.length / 2),
            wall.turn,
        )
    _skirt(builder, plan)


def daylight_lamps(builder: RoomBuilder, windows: Sequence[Window], light: Daylight, seed: int) -> list[Lamp]:
    """The view out of each window, and the light that comes in through it.

    Daylight comes from windows, small and bright: sampled as lamps it is free of blotches. The lamps belong to the
    views outside, which need not be as bright as the light that comes from there.
    """
    lamps = []
    for window in windows:
        wall = window.wall
        builder.add(
            "outside", fixtures.backdrop(9.0, 2.6, light.outside, seed % 5), wall.point(window.along), wall.turn
        )
        across = np.subtract(wall.point(1.0), wall.point(0.0)) * window.width
        outside = -fixtures.WALL_THICKNESS - 0.01
        lamps.append(
            Lamp(
                "outside",
                wall.point(window.along, outside, (window.low + window.high) / 2),
                ((float(across[0]), float(across[1]), 0.0), (0.0, 0.0, window.high - window.low)),
                0.0,
                light.windows,
            )
        )
    return lamps


def hang_door(
    builder: RoomBuilder,
    plan: FloorLayout,
    walls: Sequence[Wall],
    theme: Theme,
    rng: np.random.Generator,
    paints: Sequence[str] = ("#f1eee6", "#e3ddd0"),
) -> None:
    """Put a door where there is room for it, and keep the floor in front of it free.

    Args:
        builder: takes the parts.
        plan: what stands where.
        walls: where it may be.
        theme: whose wood the leaf may be of.
        rng: the leaf's look and the place.
        paints: of a leaf that is not of wood.

    Raises:
        NoRoomError: if none of the walls has room for it.
    """
    looks: tuple[str | WoodTones, ...] = (*paints, theme.wood)
    leaf = finish_of(pick_one(rng, looks), theme.seed)
    for index in rng.permutation(len(walls)):
        wall = walls[int(index)]
        along = plan.against(wall, DOOR_WIDTH, DOOR_SPACE, rng, tall=True, gap=0.04)
        if along is not None:
            builder.add("door", fixtures.door(leaf), wall.point(along, 0.001), wall.turn, obstacle=True)
            builder.bare(wall, along - 0.535, along + 0.535)
            return
    raise NoRoomError("no room for a door")


def _skirt(builder: RoomBuilder, plan: FloorLayout) -> None:
    """Skirting boards along the walls but where `builder.bare` says that there are none."""
    for wall in plan.walls.values():
        start = 0.0
        # Boards meet in the corners without crossing: those along x end before those along y.
        ends = 0.016 if wall.name in ("north", "south") else 0.0
        taken = [*sorted(builder.bare_stretches(wall)), (wall.length, wall.length)]
        for low, high in taken:
            first, last = max(start, ends), min(low, wall.length - ends)
            if last - first > SKIRTED_FROM:
                board = fixtures.baseboard(last - first)
                builder.add("baseboard", board, wall.point((first + last) / 2, 0.0, 0.0005), wall.turn)
            start = max(start, high)


def ceiling_panel(
    builder: RoomBuilder, x: float, y: float, height: float, size: float, colour: Colour, strength: float
) -> Lamp:
    """A square lamp under the ceiling."""
    radiance = scaled(colour, 9.0 * strength)
    housing, face = fixtures.ceiling_lamp(size, radiance)
    builder.add("ceiling_lamp", housing, (x, y, height))
    builder.add("ceiling_lamp_glow", face, (x, y, height))
    edges = ((size, 0.0, 0.0), (0.0, -size, 0.0))
    return Lamp("ceiling_lamp_glow", (x, y, height - 0.045), edges, 0.0, radiance)


def pendant(
    builder: RoomBuilder,
    x: float,
    y: float,
    height: float,
    low: float,
    shade: Material,
    colour: Colour,
    strength: float,
) -> Lamp:
    """A lamp hanging down to `low`, over a table."""
    radius = 0.045
    radiance = scaled(colour, 60.0 * strength)
    fixed, glowing = fixtures.pendant_lamp(height - low, shade, radiance, radius)
    builder.add("pendant_lamp", fixed, (x, y, height))
    builder.add("pendant_bulb", glowing, (x, y, height))
    return Lamp("pendant_bulb", (x, y, low + 0.025 + radius), None, radius, radiance)
