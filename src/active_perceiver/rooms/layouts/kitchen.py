"""Kitchens: a fitted run with fridge, sink and stove along one wall, perhaps a second one; a table with chairs.

Along the north wall from one of its ends: the fridge, then cabinets with sink and stove in either order. The second
run stands around the corner ("L"), on the wall opposite ("parallel"), or is missing ("single").
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from active_perceiver.rooms.furniture import appliances, cabinets, fixtures
from active_perceiver.rooms.layouts.cases import stand_chest, stand_plants, stand_radiator
from active_perceiver.rooms.layouts.common import (
    bare_room,
    check_targets,
    dress_window,
    hang_pictures,
    make_window,
    sill_ledge,
    wall_ledge,
    within_reach,
)
from active_perceiver.rooms.layouts.daylight import NEUTRAL, WARM, hour_of_day
from active_perceiver.rooms.layouts.dining import dining_place
from active_perceiver.rooms.layouts.fitted import (
    FITTED_GAP,
    REACH,
    SINK_SIDE,
    Run,
    cabinets_between,
    counter_ledge,
    splashback,
    worktop,
)
from active_perceiver.rooms.layouts.placement import Ledge, NoRoomError, RoomBuilder, stream
from active_perceiver.rooms.layouts.pots import pots_on_the_stove
from active_perceiver.rooms.layouts.shell import (
    Window,
    ceiling_panel,
    daylight_lamps,
    hang_door,
    pendant,
    raise_walls,
    skirt,
)
from active_perceiver.rooms.layouts.things import Contents, lay_things
from active_perceiver.rooms.layouts.walls import Plan
from active_perceiver.rooms.looks.materials import Material
from active_perceiver.rooms.looks.surfaces import glazed
from active_perceiver.rooms.looks.themes import (
    FRIDGES,
    LACQUERS,
    STONES,
    TILES,
    Theme,
    WoodTones,
    counter_of,
    finish_of,
    floor_of,
    paint_of,
    pick_one,
    theme_of,
)
from active_perceiver.rooms.room import Room

CONTENTS = Contents(
    ("mug", "plate", "bread", "apple", "bowl", "toaster", "banana"),
    (
    "bottle", "cereal", "milk", "can", "soap", "book", "knife_block", "orange", "green_apple", "teapot", "jar",
    "lemon", "spray_bottle", "vase", "microwave", "herb_pot", "utensil_crock", "paper_roll", "pepper_mill", "radio",
    "tissue_box",
    ),
)  # fmt: skip
ON_THE_STOVE = ("pot", "pan", "kettle")

FRIDGE_WIDTH, FRIDGE_END = 0.68, 0.74
STOVE_WIDTH = 0.62
SINK_WIDTH = 0.58
HOOD_LOW = 1.62


@dataclass(frozen=True)
class _Design:
    """How a kitchen is arranged; lengths in metres along the main run, from the end where the fridge stands."""

    theme: Theme
    height: float
    shape: str
    flipped: bool
    sink: float
    stove: float


def furnish_kitchen(seed: int, attempt: int, contents: Contents = CONTENTS) -> Room:
    """A furnished kitchen.

    Args:
        seed: everything follows from it.
        attempt: another arrangement for the same seed, for when one does not work out.
        contents: what lies about.

    Raises:
        NoRoomError: if this arrangement leaves too little room for a robot or for things.
    """
    rng = stream(seed, f"kitchen {attempt}")
    width, depth = float(rng.uniform(3.9, 4.9)), float(rng.uniform(3.6, 4.4))
    plan, builder = Plan(width, depth), RoomBuilder()
    design = _design(width, rng)
    theme = design.theme
    finish, stone = _finishes(rng, theme)
    main = Run(plan.walls["north"], design.flipped, finish, stone)
    window = _main_window(main, design, rng)
    ledges = _main_run(builder, plan, main, design, window, pick_one(rng, TILES), rng)
    ledges += _second_run(builder, plan, main, design, rng)
    windows = [window] if window else []
    far = plan.walls["west" if not design.flipped else "east"]
    for wall in (far, plan.walls["south"]):
        if len(windows) < 2 and (not windows or rng.random() < 0.7):
            windows.append(make_window(plan, wall, rng, (0.85, 1.05), design.height))
    looks: tuple[str | WoodTones, ...] = ("#f1eee6", "#e3ddd0", theme.wood)
    leaf = finish_of(pick_one(rng, looks), theme.seed)
    if not hang_door(builder, plan, [plan.walls["south"], far, plan.walls["east"], plan.walls["west"]], leaf, rng):
        raise NoRoomError("no room for a door")
    middle = _furnish(builder, plan, design, ledges, windows, rng)
    paints = {name: paint_of(theme.walls) for name in plan.walls}
    if theme.feature:
        paints[far.name] = paint_of(theme.feature)
    raise_walls(builder, plan, design.height, windows, paints, floor_of(theme.floor, theme.seed))
    skirt(builder, plan)
    targets = lay_things(builder, within_reach(builder, plan, ledges), contents, seed)
    check_targets(builder, plan, targets)
    pots_on_the_stove(builder, main.wall.point(main.middle(design.stove), FITTED_GAP), seed)
    targets |= {name: name for name in ON_THE_STOVE}

    light = hour_of_day([window.wall for window in windows], rng)
    lamps = daylight_lamps(builder, windows, light, seed)
    shade = glazed(theme.accent, 0.35)
    if middle is not None:
        lamps.append(
            pendant(builder, *middle, design.height, float(rng.uniform(1.72, 1.85)), shade, WARM, light.lamps)
        )
    # Not where the pendant hangs.
    x, y = width * (0.35 if middle is not None and middle[0] > width / 2 else 0.65), depth * 0.55
    lamps.append(
        ceiling_panel(builder, x, y, design.height, 0.55, NEUTRAL if rng.random() < 0.4 else WARM, light.lamps)
    )
    return bare_room(
        builder, plan, design.height, f"kitchen_{seed}", dict(sorted(targets.items())), light.sun, light.sky, lamps
    )


def _design(width: float, rng: np.random.Generator) -> _Design:
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
    return _Design(theme_of(rng), height, shape, bool(rng.random() < 0.5), float(sink_middle), float(stove_middle))


def _finishes(rng: np.random.Generator, theme: Theme) -> tuple[Material, Material]:
    """Fronts and worktop: at most one of them of wood."""
    wooden = rng.random() < 0.35
    fronts = finish_of(theme.wood if wooden else pick_one(rng, LACQUERS), theme.seed)
    stone = pick_one(rng, STONES) if wooden or rng.random() < 0.7 else theme.wood
    return fronts, counter_of(stone, theme.seed)


def _main_window(main: Run, design: _Design, rng: np.random.Generator) -> Window | None:
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


def _main_run(
    builder: RoomBuilder,
    plan: Plan,
    main: Run,
    design: _Design,
    window: Window | None,
    tile: str,
    rng: np.random.Generator,
) -> list[Ledge]:
    """Everything along the north wall; returns its worktops and sill."""
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
    builder: RoomBuilder, main: Run, design: _Design, window: Window | None, rng: np.random.Generator
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


def _second_run(
    builder: RoomBuilder, plan: Plan, main: Run, design: _Design, rng: np.random.Generator
) -> list[Ledge]:
    """Around the corner, or on the opposite wall."""
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
        ledges.append(wall_ledge(run.wall, along, width - 0.08, 0.12, height, 0.18, "shelf", "shelf"))
    return ledges


def _furnish(
    builder: RoomBuilder,
    plan: Plan,
    design: _Design,
    ledges: list[Ledge],
    windows: list[Window],
    rng: np.random.Generator,
) -> tuple[float, float] | None:
    """Table, sideboard and what else there is; adds ledges, returns the middle of the table."""
    theme = design.theme
    walls = list(plan.walls.values())
    place = dining_place(builder, plan, theme, rng)
    if place is not None:
        ledges += place[0]
    elif design.shape == "single":
        raise NoRoomError("no room for a table")
    ledges += stand_chest(builder, plan, walls[1:], theme, "sideboard", rng)
    for window in windows:
        if window.wall.name != "north":
            ledges.append(sill_ledge(window))
            if rng.random() < 0.5:
                stand_radiator(builder, window)
            dress_window(builder, window, theme, rng, floor=False)
    found = plan.somewhere(walls[1:], 0.36, 0.36, rng)
    if found is not None:
        wall, along = found
        builder.add("bin", fixtures.bin_with_pedal(), wall.point(along, 0.20, 0.0006), wall.turn, obstacle=True)
    stand_plants(builder, plan, walls[1:], int(rng.integers(2)), rng)
    hang_pictures(builder, plan, theme.timber, rng, 2, walls[1:])
    wall = pick_one(rng, walls[1:])
    free = plan.hanging_place(wall, 0.34, rng)
    if free is not None and rng.random() < 0.7:
        builder.add("wall_clock", fixtures.clock(), wall.point(free, 0.001, 1.9), wall.turn)
    return None if place is None else place[1]
