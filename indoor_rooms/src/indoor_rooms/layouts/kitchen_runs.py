"""A kitchen's two runs of cabinets: fridge, sink, stove and hood along the north wall, perhaps a second run.

Along the north wall from one of its ends: the fridge, then cabinets with sink and stove in either order. The second
run stands around the corner ("L"), on the wall opposite ("parallel"), or is missing ("single").
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from indoor_rooms.furniture import appliances, cabinets
from indoor_rooms.layouts.common import sill_ledge, wall_ledge
from indoor_rooms.layouts.fitted import (
    FITTED_GAP,
    REACH,
    SINK_SIDE,
    Run,
    cabinets_between,
    counter_ledge,
    splashback,
    worktop,
)
from indoor_rooms.layouts.placement import Ledge, RoomBuilder
from indoor_rooms.layouts.shell import Window
from indoor_rooms.layouts.walls import FloorLayout
from indoor_rooms.materials.themes import FRIDGES, TILES, Theme, pick_one, theme_of

FRIDGE_WIDTH, FRIDGE_END = 0.68, 0.74
STOVE_WIDTH = 0.62
SINK_WIDTH = 0.58
HOOD_LOW = 1.62


@dataclass(frozen=True)
class Design:
    """How a kitchen is arranged.

    Attributes:
        theme: colours.
        height: of the ceiling, metres.
        shape: where the second run stands: "L", "parallel" or "single".
        flipped: whether the fridge stands at the north wall's right end.
        sink: middle of the sink along the main run, metres from the end where the fridge stands.
        stove: middle of the stove, likewise.
    """

    theme: Theme
    height: float
    shape: str
    flipped: bool
    sink: float
    stove: float


def design_of(width: float, rng: np.random.Generator) -> Design:
    """A random arrangement for a main run of `width` metres."""
    shape = str(rng.choice(("L", "parallel", "single"), p=(0.5, 0.25, 0.25)))
    # Worktop before, between and after sink and stove; the corner of an L is deep.
    least = np.array([0.45, 0.42, 0.98 if shape == "L" else 0.42])
    sink, stove = SINK_WIDTH + 2 * SINK_SIDE, STOVE_WIDTH + 0.012
    spare = width - FRIDGE_END - sink - stove - least.sum()
    before, between, _ = least + spare * rng.dirichlet((2.0, 2.0, 2.0))
    first = FRIDGE_END + before
    if rng.random() < 0.6:
        sink_middle, stove_middle = first + sink / 2, first + sink + between + stove / 2
    else:
        stove_middle, sink_middle = first + stove / 2, first + stove + between + sink / 2
    height = float(rng.uniform(2.45, 2.75))
    return Design(theme_of(rng), height, shape, bool(rng.random() < 0.5), float(sink_middle), float(stove_middle))


def main_window(main: Run, design: Design, rng: np.random.Generator) -> Window | None:
    """A window above the sink, as wide as fridge, hood and the wall's end allow."""
    hood = (design.stove - STOVE_WIDTH / 2 - 0.2, design.stove + STOVE_WIDTH / 2 + 0.2)
    low, high = FRIDGE_END + 0.12, main.wall.length - 0.2
    low, high = (low, min(high, hood[0])) if design.sink < design.stove else (max(low, hood[1]), high)
    width = min(float(rng.uniform(0.95, 1.6)), high - low - 0.15)
    if width < 0.7 or rng.random() < 0.15:
        return None
    middle = float(np.clip(design.sink, low + width / 2 + 0.07, high - width / 2 - 0.07))
    return Window(
        main.wall,
        main.middle(middle),
        width,
        float(rng.uniform(1.03, 1.1)),
        min(2.16, design.height - 0.25),
        2 if width > 0.9 else 1,
        # Behind the tap there is no room for more.
        sill=0.03,
    )


def main_run(
    builder: RoomBuilder,
    plan: FloorLayout,
    main: Run,
    design: Design,
    window: Window | None,
    tile: str,
    rng: np.random.Generator,
) -> list[Ledge]:
    """Build everything along the north wall.

    Args:
        builder: takes the parts.
        plan: what stands where.
        main: the north wall's run.
        design: how the kitchen is arranged.
        window: above the sink, as from `main_window`.
        tile: colour of the splashback.
        rng: fridge, fronts, towel, wall cabinets.

    Returns:
        Its worktops and the window's sill.
    """
    wall, end = main.wall, main.wall.length
    plan.take(wall.rectangle(wall.length / 2, wall.length, 0.0, REACH + 0.03))
    builder.bare(wall, 0.0, wall.length)
    beside = "east" if not design.flipped else "west"
    for name, bare in ((beside, REACH), ("west" if beside == "east" else "east", 0.70)):
        other = plan.walls[name]
        builder.bare(other, *((0.0, bare) if name == "east" else (other.length - bare, other.length)))
        # Nothing hangs where the fridge or a wall cabinet reaches along the neighbouring wall.
        plan.hang(other, 0.36 if name == "east" else other.length - 0.36, 0.80)
    fridge = appliances.fridge(pick_one(rng, FRIDGES))
    builder.add(
        "fridge",
        fridge,
        wall.point(main.middle(FRIDGE_END - FRIDGE_WIDTH / 2 - 0.04), FITTED_GAP),
        wall.turn,
        obstacle=True,
    )
    plan.take(wall.rectangle(main.middle(FRIDGE_END / 2), FRIDGE_END, 0.0, 0.80))
    sink = (design.sink - SINK_WIDTH / 2, design.sink + SINK_WIDTH / 2)
    stove = (design.stove - STOVE_WIDTH / 2 - 0.006, design.stove + STOVE_WIDTH / 2 + 0.006)
    # In front of the corner of an L no cabinet can be opened.
    cabinets_end = end - REACH if design.shape == "L" else end - 0.01
    ledges: list[Ledge] = []
    for start, stop in ((FRIDGE_END, stove[0]), (stove[1], end - FITTED_GAP)):
        inside = start < design.sink < stop
        worktop(builder, main, start, stop, sink if inside else None)
        edges = (sink[0] - SINK_SIDE, sink[1] + SINK_SIDE)
        stretches = ((start, edges[0]), (edges[1], stop)) if inside else ((start, stop),)
        for low, high in stretches:
            cabinets_between(builder, main, low, min(high, cabinets_end), rng)
            ledges.append(counter_ledge(main, low, high, f"north {len(ledges)}"))
    middle = wall.point(main.middle(design.stove), FITTED_GAP)
    towel = design.theme.accent if rng.random() < 0.6 else None
    builder.add("stove", appliances.stove(STOVE_WIDTH, towel=towel), middle, wall.turn, obstacle=True)
    builder.add(
        "hood", appliances.hood(STOVE_WIDTH, design.height - HOOD_LOW - 0.005), (*middle[:2], HOOD_LOW), wall.turn
    )
    splashback(builder, main, FRIDGE_END, end - 0.0075, tile, window)
    _wall_cabinets(builder, main, design, window, rng)
    if window is not None:
        ledges.append(sill_ledge(window))
    return ledges


def _wall_cabinets(
    builder: RoomBuilder, main: Run, design: Design, window: Window | None, rng: np.random.Generator
) -> None:
    """Cabinets on the wall between window, hood and the ends of the run."""
    taken = [(design.stove - STOVE_WIDTH / 2 - 0.02, design.stove + STOVE_WIDTH / 2 + 0.02)]
    if window is not None:
        middle = main.middle(window.along)
        taken.append((middle - window.width / 2 - 0.12, middle + window.width / 2 + 0.12))
    start = FRIDGE_END + 0.02
    for low, high in [*sorted(taken), (main.wall.length - 0.02, main.wall.length)]:
        free = low - start
        if free >= 0.34 and rng.random() < 0.75:
            width = min(free - 0.02, 1.0)
            cabinet = cabinets.wall_cabinet(width, main.fronts, doors=2 if width > 0.6 else 1)
            # Beside the hood or in the corner, not in the middle of a stretch.
            along = main.middle(low - 0.01 - width / 2)
            builder.add("wall_cabinet", cabinet, main.wall.point(along, FITTED_GAP + 0.008, 1.50), main.wall.turn)
        start = max(start, high)


def second_run(
    builder: RoomBuilder, plan: FloorLayout, main: Run, design: Design, rng: np.random.Generator
) -> list[Ledge]:
    """Build the run around the corner or on the opposite wall, if the design has one.

    Args:
        builder: takes the parts.
        plan: what stands where.
        main: the north wall's run, whose finish it shares.
        design: how the kitchen is arranged.
        rng: length, place, fronts, whether a shelf hangs above.

    Returns:
        Its worktops and the shelf.
    """
    if design.shape == "single":
        return []
    if design.shape == "L":
        wall = plan.walls["east" if not design.flipped else "west"]
        run, start = Run(wall, design.flipped, main.fronts, main.top), REACH + 0.001
        end = float(rng.uniform(1.9, min(3.0, wall.length - 1.3)))
    else:
        run = Run(plan.walls["south"], False, main.fronts, main.top)
        length = float(rng.uniform(1.5, 2.2))
        start = float(rng.uniform(0.0, 1.0) < 0.5) * (run.wall.length - length - 0.01) + 0.005
        end = start + length
    low, high = run.span(start, end)
    plan.take(run.wall.rectangle((low + high) / 2, high - low, 0.0, REACH + 0.02))
    builder.bare(run.wall, low - 0.001, high)
    cabinets_between(builder, run, start + 0.008, end - 0.01, rng)
    worktop(builder, run, start, end)
    splashback(builder, run, start + (0.008 if design.shape == "L" else 0.0), end, pick_one(rng, TILES), None, 1.25)
    if design.shape == "parallel":
        # Of the walls at its ends one is touched: no skirting board behind the cabinets.
        for name in ("east", "west"):
            other = plan.walls[name]
            builder.bare(other, *((other.length - REACH, other.length) if name == "east" else (0.0, REACH)))
    plan.hang(run.wall, (low + high) / 2, high - low)
    ledges = []
    pieces = 2 if end - start > 1.7 else 1
    for number in range(pieces):
        first, last = (start + (end - start) * share / pieces for share in (number, number + 1))
        ledges.append(counter_ledge(run, first + 0.01, last - 0.01, f"{run.wall.name} {number}"))
    if rng.random() < 0.6:
        width = min(1.3, end - start - 0.3)
        along, height = (low + high) / 2, float(rng.uniform(1.26, 1.38))
        builder.add(
            "shelf", cabinets.shelf(width, design.theme.timber), run.wall.point(along, 0.009, height), run.wall.turn
        )
        ledges.append(wall_ledge(run.wall, (along, 0.12, height), (width - 0.08, 0.18), "shelf", "shelf"))
    return ledges
