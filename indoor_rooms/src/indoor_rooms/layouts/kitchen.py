"""Kitchens: a fitted run with fridge, sink and stove along one wall, perhaps a second one; a table with chairs."""

from __future__ import annotations

import numpy as np

from indoor_rooms.furniture import fixtures
from indoor_rooms.layouts.cases import stand_chest, stand_plants, stand_radiator
from indoor_rooms.layouts.common import bare_room, dress_window, hang_pictures, make_window, sill_ledge
from indoor_rooms.layouts.contents import Contents, lay_things
from indoor_rooms.layouts.daylight import NEUTRAL, WARM, hour_of_day
from indoor_rooms.layouts.dining import dining_place
from indoor_rooms.layouts.fitted import FITTED_GAP, Run
from indoor_rooms.layouts.kitchen_runs import Design, design_of, main_run, main_window, second_run
from indoor_rooms.layouts.placement import Ledge, NoRoomError, RoomBuilder, stream
from indoor_rooms.layouts.pots import pots_on_the_stove
from indoor_rooms.layouts.shell import Window, ceiling_panel, daylight_lamps, hang_door, pendant, raise_walls
from indoor_rooms.layouts.walls import FloorLayout
from indoor_rooms.materials.material import Material
from indoor_rooms.materials.surfaces import glazed
from indoor_rooms.materials.themes import LACQUERS, STONES, TILES, Theme, counter_of, finish_of, floor_of, pick_one
from indoor_rooms.room import Room

CONTENTS = Contents(
    ("mug", "plate", "bread", "apple", "bowl", "toaster", "banana"),
    (
    "bottle", "cereal", "milk", "can", "soap", "book", "knife_block", "orange", "green_apple", "teapot", "jar",
    "lemon", "spray_bottle", "vase", "microwave", "herb_pot", "utensil_crock", "paper_roll", "pepper_mill", "radio",
    "tissue_box",
    ),
)  # fmt: skip
ON_THE_STOVE = ("pot", "pan", "kettle")


def furnish_kitchen(seed: int, attempt: int, contents: Contents = CONTENTS, hour: str | None = None) -> Room:
    """A furnished kitchen.

    Args:
        seed: everything follows from it.
        attempt: another arrangement for the same seed, for when one does not work out.
        contents: what lies about.
        hour: of the day, see `daylight.HOURS`; it follows from the seed if None.

    Raises:
        NoRoomError: if this arrangement leaves too little room for a robot or for things.
    """
    rng = stream(seed, f"kitchen {attempt}")
    width, depth = float(rng.uniform(3.9, 4.9)), float(rng.uniform(3.6, 4.4))
    plan, builder = FloorLayout(width, depth), RoomBuilder()
    design = design_of(width, rng)
    theme = design.theme
    finish, stone = _finishes(rng, theme)
    main = Run(plan.walls["north"], design.flipped, finish, stone)
    window = main_window(main, design, rng)
    ledges = main_run(builder, plan, main, design, window, pick_one(rng, TILES), rng)
    ledges += second_run(builder, plan, main, design, rng)
    windows = [window] if window else []
    far = plan.walls["west" if not design.flipped else "east"]
    for wall in (far, plan.walls["south"]):
        if len(windows) < 2 and (not windows or rng.random() < 0.7):
            windows.append(make_window(plan, wall, rng, (0.85, 1.05), design.height))
    hang_door(builder, plan, [plan.walls["south"], far, plan.walls["east"], plan.walls["west"]], theme, rng)
    middle = _furnish(builder, plan, design, ledges, windows, rng)
    raise_walls(builder, plan, design.height, windows, theme, far, floor_of(theme.floor, theme.seed))
    targets = lay_things(builder, plan, ledges, contents, seed)
    pots_on_the_stove(builder, main.wall.point(main.middle(design.stove), FITTED_GAP), seed, contents.moved)
    targets |= {name: name for name in ON_THE_STOVE}

    light = hour_of_day([window.wall for window in windows], rng, hour)
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


def _finishes(rng: np.random.Generator, theme: Theme) -> tuple[Material, Material]:
    """Fronts and worktop: at most one of them of wood."""
    wooden = rng.random() < 0.35
    fronts = finish_of(theme.wood if wooden else pick_one(rng, LACQUERS), theme.seed)
    stone = pick_one(rng, STONES) if wooden or rng.random() < 0.7 else theme.wood
    return fronts, counter_of(stone, theme.seed)


def _furnish(
    builder: RoomBuilder,
    plan: FloorLayout,
    design: Design,
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
