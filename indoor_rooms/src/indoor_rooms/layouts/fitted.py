"""Fitted runs of cabinets along a wall: bodies, worktops with holes for sinks, tiles behind them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from indoor_rooms.furniture import cabinets
from indoor_rooms.geometry.boxes import slab
from indoor_rooms.geometry.mesh import transform
from indoor_rooms.layouts.placement import Ledge, RoomBuilder
from indoor_rooms.layouts.shell import Window
from indoor_rooms.layouts.walls import Wall
from indoor_rooms.materials import textures
from indoor_rooms.materials.material import Material

FITTED_GAP = 0.002
REACH = cabinets.COUNTER_DEPTH + 0.02
# The sink's hole in the worktop, from the wall; and the strip of cabinet and worktop on either side.
SINK_FROM, SINK_TO, SINK_SIDE = 0.12, 0.50, 0.06
TILES_TO = 1.495


@dataclass(frozen=True)
class Run:
    """A stretch of wall with fitted cabinets, counted from one of the wall's ends.

    Attributes:
        wall: along which it stands.
        flipped: whether it is counted from the wall's right end.
        fronts: material of the cabinets.
        top: material of the worktop.
    """

    wall: Wall
    flipped: bool
    fronts: Material
    top: Material

    def span(self, start: float, end: float) -> tuple[float, float]:
        """Two places of the run as places along the wall, the left one first."""
        if self.flipped:
            return self.wall.length - end, self.wall.length - start
        return start, end

    def middle(self, place: float) -> float:
        """A place of the run along the wall."""
        return self.wall.length - place if self.flipped else place


def cabinets_between(builder: RoomBuilder, run: Run, start: float, end: float, rng: np.random.Generator) -> None:
    """Base cabinets of equal width, doors and drawers by turns."""
    low, high = run.span(start, end)
    count = max(1, round((high - low) / 0.5))
    kinds = [int(rng.choice((0, 1, 1, 3))) for _ in range(count)]
    row = cabinets.run_of_cabinets([(high - low - 0.002) / count] * count, run.fronts, kinds)
    builder.add("cabinet", row, run.wall.point(low + 0.001, FITTED_GAP), run.wall.turn)


def worktop(
    builder: RoomBuilder, run: Run, start: float, end: float, sink: tuple[float, float] | None = None
) -> None:
    """A worktop from `start` to `end` of the run, with a sink, its basin and tap from `sink[0]` to `sink[1]`."""
    low, high = run.span(start, end)
    wall = run.wall
    xs: tuple[float, ...] = (low, high)
    ys: tuple[float, ...] = (-REACH, -FITTED_GAP)
    filled = [[True]]
    if sink is not None:
        left, right = run.span(*sink)
        xs, ys = (low, left, right, high), (-REACH, -SINK_TO, -SINK_FROM, -FITTED_GAP)
        filled = [[True, True, True], [True, False, True], [True, True, True]]
        middle, out = (left + right) / 2, (SINK_FROM + SINK_TO) / 2
        builder.add("sink", cabinets.sink(right - left, SINK_TO - SINK_FROM), wall.point(middle, out), wall.turn)
        tap = wall.point(middle, 0.075, cabinets.COUNTER_HEIGHT + 0.0006)
        builder.add("faucet", cabinets.faucet(), tap, wall.turn)
        width = right - left + 2 * SINK_SIDE
        below = cabinets.base_cabinet(width - 0.002, run.fronts, 0, -1, body_height=0.70)
        builder.add("cabinet", below, wall.point(middle, FITTED_GAP), wall.turn)
    builder.add("countertop", cabinets.countertop(xs, ys, filled, run.top), wall.point(0.0), wall.turn)
    x0, y0, x1, y1 = wall.rectangle((low + high) / 2, high - low, 0.0, REACH + 0.015)
    builder.block("counter", (x0, y0), (x1, y1))


def splashback(
    builder: RoomBuilder, run: Run, start: float, end: float, tile: str, window: Window | None, top: float = TILES_TO
) -> None:
    """Tiles above a worktop, around the trim of a window."""
    tiled = Material((1.0, 1.0, 1.0), textures.tiles(tile, "#c9c5bc", 2), roughness=0.15, coat=0.4)
    low, high = run.span(start, end)
    xs: Sequence[float] = (low, high)
    zs: Sequence[float] = (cabinets.COUNTER_HEIGHT + 0.0005, top)
    filled = [[True]]
    if window is not None:
        left, right = window.along - window.width / 2 - 0.0705, window.along + window.width / 2 + 0.0705
        xs, zs = (low, left, right, high), (zs[0], window.low - 0.031, top)
        filled = [[True, True], [True, False], [True, True]]
    upright = transform(slab(xs, zs, filled, -0.001, 0.006, 1.5), rotate=(90.0, 0.0, 0.0))
    builder.add("splashback", [(upright, tiled)], run.wall.point(0.0), run.wall.turn)


def counter_ledge(run: Run, start: float, end: float, name: str) -> Ledge:
    """Where things stand on a worktop."""
    low, high = run.span(start, end)
    first, last = run.wall.point(low + 0.02, 0.33), run.wall.point(high - 0.02, 0.33)
    return Ledge(name, "counter", first[:2], last[:2], cabinets.COUNTER_HEIGHT, 0.40)
