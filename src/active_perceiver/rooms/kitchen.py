"""The kitchen: a fitted kitchen along two walls, a table with chairs in the middle, a sideboard by the door.

North is +y. North wall: fridge, counter with the sink under the window, stove with its hood, corner. East wall:
counter with a shelf above. South wall: sideboard under a picture, door. West wall: a second window.
"""

from __future__ import annotations

from dataclasses import dataclass

from active_perceiver.rooms import textures
from active_perceiver.rooms.boxes import slab
from active_perceiver.rooms.furniture import appliances, cabinets, fixtures, seating
from active_perceiver.rooms.geometry import quad, transform
from active_perceiver.rooms.kitchen_objects import place_objects
from active_perceiver.rooms.materials import Colour, Material, from_hex
from active_perceiver.rooms.objects.decor import floor_plant
from active_perceiver.rooms.placement import Ledge, RoomBuilder, stream
from active_perceiver.rooms.room import Lamp, Room, Sun
from active_perceiver.rooms.surfaces import wood
from active_perceiver.rooms.themes import OAK, THEMES, Theme, counter_of, finish_of, floor_of, shade_of

WIDTH, DEPTH, HEIGHT = 4.6, 4.2, 2.6
NORTH_WINDOW = (-1.05, 0.45, 1.02, 2.14)
WEST_WINDOW = (-0.65, 0.65, 0.98, 2.14)
SINK = (1.70, 2.28)
STOVE_X, STOVE_WIDTH = 3.32, 0.62
COUNTER_FROM, EAST_FROM = 0.74, 1.50
TABLE = (1.78, 1.92, 1.30, 0.80)
SIDEBOARD_X, SIDEBOARD_WIDTH = 1.45, 1.40
SHELF_Y, SHELF_Z, SHELF_WIDTH = 2.45, 1.34, 1.30
CEILING_LAMP = (3.05, 2.35, 0.55)
PENDANT_Z = 1.78
BULB_RADIUS = 0.045
WALL_GAP = 0.002
# What stands on the rug stands this high.
RUG_TOP = 0.0104


@dataclass(frozen=True)
class _Style:
    """A theme and the seed that varies grain and noise."""

    theme: Theme
    seed: int


def kitchen(seed: int) -> Room:
    """A kitchen of 4.6 x 4.2 m.

    Args:
        seed: chooses colours, the sun, the things' shapes and where they lie; 1 is the room that is shipped.

    Returns:
        The furnished room; every target's object name is its category.
    """
    style = _Style(THEMES[(seed - 1) % len(THEMES)], seed)
    builder = RoomBuilder()
    _shell(builder, style)
    _fitted_kitchen(builder, style)
    _dining_place(builder, style)
    _south_and_west(builder, style)
    targets = place_objects(builder, ledges(), (STOVE_X, DEPTH - WALL_GAP, appliances.STOVE_TOP), seed)
    lamps = _lamps(builder, style.theme)
    return Room(
        name=f"kitchen_{seed}",
        size=(WIDTH, DEPTH, HEIGHT),
        parts=tuple(builder.parts),
        targets=targets,
        sun=_sun(seed),
        sky=(1.0, 1.15, 1.35),
        lamps=lamps,
        obstacles=tuple(builder.obstacles),
    )


def ledges() -> tuple[Ledge, ...]:
    """Where things may stand. Each line has the room on its right-hand side when things' fronts face the room."""
    counter, back = cabinets.COUNTER_HEIGHT, DEPTH - 0.33
    east = WIDTH - 0.34
    table_x, table_y, table_width, _ = TABLE
    left, right = table_x - table_width / 2 + 0.04, table_x + table_width / 2 - 0.04
    top = RUG_TOP + seating.TABLE_HEIGHT
    board_y = 0.21
    window_x = WIDTH / 2
    return (
        Ledge("north left", (COUNTER_FROM + 0.04, back), (SINK[0] - 0.06, back), counter, 0.40),
        Ledge("north right", (SINK[1] + 0.06, back), (STOVE_X - STOVE_WIDTH / 2 - 0.03, back), counter, 0.40),
        Ledge("east far", (east, DEPTH - 0.66), (east, 2.56), counter, 0.38),
        Ledge("east near", (east, 2.50), (east, EAST_FROM + 0.03), counter, 0.38),
        Ledge("table south", (left, table_y - 0.22), (right, table_y - 0.22), top, 0.32),
        Ledge("table north", (right, table_y + 0.22), (left, table_y + 0.22), top, 0.32),
        Ledge("sideboard", (SIDEBOARD_X + 0.66, board_y), (SIDEBOARD_X - 0.66, board_y), 0.82, 0.34),
        Ledge("shelf", (WIDTH - 0.12, SHELF_Y + 0.6), (WIDTH - 0.12, SHELF_Y - 0.6), SHELF_Z, 0.18),
        Ledge(
            "north sill",
            (window_x - 1.0, DEPTH - 0.015),
            (window_x + 0.4, DEPTH - 0.015),
            NORTH_WINDOW[2] + 0.0005,
            0.155,
        ),
        Ledge("west sill", (0.015, DEPTH / 2 - 0.6), (0.015, DEPTH / 2 + 0.6), WEST_WINDOW[2] + 0.0005, 0.155),
    )


def _paint(theme: Theme) -> Material:
    return Material((1.0, 1.0, 1.0), textures.plaster(theme.walls), roughness=0.9, specular=0.15)


def _shell(builder: RoomBuilder, style: _Style) -> None:
    """Floor, ceiling, walls with their windows, the view outside."""
    paint = _paint(style.theme)
    floor = quad((0, 0, 0), (WIDTH, 0, 0), (0, DEPTH, 0), 0.55)
    builder.add("floor", [(floor, floor_of(style.theme.floor, style.seed))])
    ceiling = quad((0, DEPTH, HEIGHT), (WIDTH, 0, 0), (0, -DEPTH, 0), 0.5)
    builder.add("ceiling", [(ceiling, Material(from_hex("#f7f6f2"), roughness=0.95, specular=0.1))])
    builder.add("wall", [(fixtures.wall(WIDTH, HEIGHT, NORTH_WINDOW), paint)], (WIDTH / 2, DEPTH, 0.0))
    builder.add("wall", [(fixtures.wall(DEPTH, HEIGHT), paint)], (WIDTH, DEPTH / 2, 0.0), -90.0)
    builder.add("wall", [(fixtures.wall(WIDTH, HEIGHT), paint)], (WIDTH / 2, 0.0, 0.0), 180.0)
    builder.add("wall", [(fixtures.wall(DEPTH, HEIGHT, WEST_WINDOW), paint)], (0.0, DEPTH / 2, 0.0), 90.0)
    builder.add("window", fixtures.window(NORTH_WINDOW), (WIDTH / 2, DEPTH, 0.0))
    builder.add("window", fixtures.window(WEST_WINDOW), (0.0, DEPTH / 2, 0.0), 90.0, obstacle=True)
    # Each backdrop shows only behind its own window; the walls hide the rest.
    builder.add("outside", fixtures.backdrop(-0.3, 9.0, 2.6, 1.8), (WIDTH / 2, DEPTH, 0.0))
    builder.add("outside", fixtures.backdrop(0.0, 9.0, 2.6, 1.8), (0.0, DEPTH / 2, 0.0), 90.0)


def _fitted_kitchen(builder: RoomBuilder, style: _Style) -> None:
    """Fridge, counters, sink, stove, hood, wall cabinets, splashback, microwave, shelf."""
    theme = style.theme
    fronts, stone = finish_of(theme.cabinets, style.seed), counter_of(theme.counter, style.seed)
    back, side = DEPTH - WALL_GAP, WIDTH - WALL_GAP
    reach = cabinets.COUNTER_DEPTH + 0.02
    stove_left, stove_right = STOVE_X - STOVE_WIDTH / 2 - 0.006, STOVE_X + STOVE_WIDTH / 2 + 0.006
    builder.add("fridge", appliances.fridge(theme.fridge), (0.36, back, 0.0), obstacle=True)

    left_width = SINK[0] - 0.06 - COUNTER_FROM
    widths, drawers = [left_width / 2] * 2, [3, 1]
    builder.add("cabinet", cabinets.run_of_cabinets(widths, fronts, drawers), (COUNTER_FROM, back, 0.0))
    sink_width = SINK[1] - SINK[0] + 0.12
    sink_cabinet = cabinets.base_cabinet(sink_width, fronts, 0, -1, body_height=0.70)
    builder.add("cabinet", sink_cabinet, ((SINK[0] + SINK[1]) / 2, back, 0.0))
    right_width = stove_left - SINK[1] - 0.06
    last = cabinets.base_cabinet(right_width, fronts, 1)
    builder.add("cabinet", last, (SINK[1] + 0.06 + right_width / 2, back, 0.0))
    sink_ys = (DEPTH - 0.50, DEPTH - 0.12)
    top = cabinets.countertop(
        (COUNTER_FROM, SINK[0], SINK[1], stove_left),
        (DEPTH - reach, sink_ys[0], sink_ys[1], back),
        ((True, True, True), (True, False, True), (True, True, True)),
        stone,
    )
    builder.add("countertop", top)
    builder.block("counter", (COUNTER_FROM, DEPTH - 0.635), (stove_left, DEPTH))
    sink_middle = ((SINK[0] + SINK[1]) / 2, (sink_ys[0] + sink_ys[1]) / 2)
    builder.add("sink", cabinets.sink(SINK[1] - SINK[0], sink_ys[1] - sink_ys[0]), (*sink_middle, 0.0))
    builder.add("faucet", cabinets.faucet(), (sink_middle[0], DEPTH - 0.075, cabinets.COUNTER_HEIGHT + 0.0006))

    stove = appliances.stove(STOVE_WIDTH, towel=theme.accent)
    builder.add("stove", stove, (STOVE_X, back, 0.0), obstacle=True)
    builder.add("hood", appliances.hood(STOVE_WIDTH, HEIGHT - 1.625), (STOVE_X, back, 1.62))

    # The corner: one closed cabinet behind the end of the east run.
    east_run = DEPTH - reach - EAST_FROM - 0.012
    builder.add(
        "cabinet",
        cabinets.run_of_cabinets([east_run / 4] * 4, fronts, [1, 3, 1, 0]),
        (side, DEPTH - reach - 0.01, 0.0),
        -90.0,
    )
    corner_width = WIDTH - reach - stove_right
    corner = cabinets.base_cabinet(corner_width - 0.004, fronts, 0)
    builder.add("cabinet", corner, (stove_right + corner_width / 2, back, 0.0))
    top = cabinets.countertop(
        (stove_right, WIDTH - reach, side),
        (EAST_FROM - 0.012, DEPTH - reach, back),
        ((False, True), (True, True)),
        stone,
    )
    builder.add("countertop", top)
    builder.block("counter", (WIDTH - 0.635, EAST_FROM - 0.012), (WIDTH, DEPTH))
    builder.block("counter", (stove_right, DEPTH - 0.635), (WIDTH, DEPTH))
    builder.add(
        "microwave", appliances.microwave(), (WIDTH - 0.17, DEPTH - 0.17, cabinets.COUNTER_HEIGHT + 0.001), -45.0
    )

    hanging = WIDTH - stove_right - 0.02
    upper = cabinets.wall_cabinet(hanging, fronts, doors=2)
    builder.add("wall_cabinet", upper, (stove_right + 0.01 + hanging / 2, back - 0.008, 1.50))
    builder.add("wall_cabinet", cabinets.wall_cabinet(0.34, fronts), (COUNTER_FROM + 0.18, back - 0.008, 1.50))
    _splashback(builder, theme)
    board = wood(*OAK, style.seed)
    builder.add("shelf", cabinets.shelf(SHELF_WIDTH, board), (side - 0.009, SHELF_Y, SHELF_Z), -90.0)


def _splashback(builder: RoomBuilder, theme: Theme) -> None:
    """Tiles between counter and wall cabinets, around the window's trim."""
    tiled = Material((1.0, 1.0, 1.0), textures.tiles(theme.tiles, "#c9c5bc", 2), roughness=0.15, coat=0.4)
    low, high = cabinets.COUNTER_HEIGHT + 0.0005, 1.495
    hole = (WIDTH / 2 + NORTH_WINDOW[0] - 0.0705, WIDTH / 2 + NORTH_WINDOW[1] + 0.0705)
    north = slab(
        (COUNTER_FROM, hole[0], hole[1], WIDTH - 0.0075),
        (low, NORTH_WINDOW[2] - 0.031, high),
        ((True, True), (True, False), (True, True)),
        -0.001,
        0.006,
        1.5,
    )
    builder.add("splashback", [(transform(north, (0.0, DEPTH, 0.0), (90.0, 0.0, 0.0)), tiled)])
    length = DEPTH - EAST_FROM
    east = slab((-length / 2, length / 2 - 0.001), (low, 1.30), [[True]], -0.001, 0.006, 1.5)
    upright = transform(east, rotate=(90.0, 0.0, 0.0))
    builder.add("splashback", [(upright, tiled)], (WIDTH, EAST_FROM + length / 2, 0.0), -90.0)


def _dining_place(builder: RoomBuilder, style: _Style) -> None:
    """Rug, table, three chairs, the lamp above."""
    theme, rng = style.theme, stream(style.seed, "chairs")
    x, y, width, depth = TABLE
    builder.add("rug", seating.rug(2.1, 1.6, *theme.rug), (x, y, 0.0006))
    top = wood(*theme.table, style.seed + 1, 0.45)
    frame = top if not isinstance(theme.chairs, str) else finish_of(theme.chairs, style.seed)
    builder.add("table", seating.table(width, depth, top, frame), (x, y, RUG_TOP), obstacle=True)
    seats = ((-0.28, -0.47, 0.0), (0.30, -0.45, 0.0), (0.02, 0.47, 180.0))
    for offset_x, offset_y, turn in seats:
        seat = seating.chair(finish_of(theme.chairs, style.seed + 2), theme.cushion)
        place = (x + offset_x + rng.uniform(-0.03, 0.03), y + offset_y, RUG_TOP)
        builder.add("chair", seat, place, turn + rng.uniform(-7, 7), obstacle=True)


def _south_and_west(builder: RoomBuilder, style: _Style) -> None:
    """Sideboard, picture, door, clock, plant, bin, skirting boards."""
    theme = style.theme
    board = cabinets.sideboard(SIDEBOARD_WIDTH, finish_of(theme.sideboard, style.seed + 3), wood(*theme.table, 7))
    builder.add("sideboard", board, (SIDEBOARD_X, 0.018, 0.0), 180.0, obstacle=True)
    picture = fixtures.picture(0.95, 0.66, wood(*theme.table, 7), style.seed)
    builder.add("picture", picture, (SIDEBOARD_X, 0.001, 1.66), 180.0)
    leaf = finish_of("#f1eee6" if isinstance(theme.chairs, str) else theme.table, 9)
    door_x = 3.55
    builder.add("door", fixtures.door(leaf), (door_x, 0.001, 0.0), 180.0, obstacle=True)
    builder.add("clock", fixtures.clock(), (WIDTH - 0.001, 0.85, 1.86), -90.0)
    plant = floor_plant(stream(style.seed, "floor plant"))
    builder.add("plant", plant, (0.36, 0.36, 0.0006), obstacle=True)
    builder.add("bin", fixtures.bin_with_pedal(), (WIDTH - 0.18, EAST_FROM - 0.22, 0.0006), -90.0, obstacle=True)
    fridge_front = DEPTH - 0.02
    builder.add("baseboard", fixtures.baseboard(fridge_front), (0.0, fridge_front / 2, 0.0005), 90.0)
    west_end = door_x - 0.535
    builder.add("baseboard", fixtures.baseboard(west_end - 0.02), (west_end / 2 + 0.009, 0.0, 0.0005), 180.0)
    builder.add("baseboard", fixtures.baseboard(EAST_FROM - 0.04), (WIDTH, EAST_FROM / 2, 0.0005), -90.0)


def _sun(seed: int) -> Sun:
    """Morning or afternoon light falling through one of the two windows."""
    rng = stream(seed, "sun")
    sideways, steep = rng.uniform(-0.45, 0.30), rng.uniform(0.70, 0.95)
    direction = (sideways, -1.0, -steep) if rng.random() < 0.6 else (1.0, sideways, -steep)
    return Sun(direction, (1.0, 0.90, 0.76), 9.0)


def _lamps(builder: RoomBuilder, theme: Theme) -> tuple[Lamp, ...]:
    """The ceiling lamp, the pendant over the table, and daylight entering through the windows."""
    warm: Colour = (1.0, 0.87, 0.70)
    x, y, size = CEILING_LAMP
    panel = tuple(9.0 * channel for channel in warm)
    housing, face = fixtures.ceiling_lamp(size, (panel[0], panel[1], panel[2]))
    builder.add("ceiling_lamp", housing, (x, y, HEIGHT))
    builder.add("ceiling_lamp_glow", face, (x, y, HEIGHT))
    bulb = tuple(60.0 * channel for channel in warm)
    shade, glowing = fixtures.pendant_lamp(HEIGHT - PENDANT_Z, shade_of(theme), (bulb[0], bulb[1], bulb[2]))
    builder.add("pendant_lamp", shade, (TABLE[0], TABLE[1], HEIGHT))
    builder.add("pendant_bulb", glowing, (TABLE[0], TABLE[1], HEIGHT))
    # Daylight comes from windows, small and bright: sampled as lamps it is free of blotches. The lamps belong to the
    # backdrop, which is seen there and which need not be as bright as the light that comes from it.
    daylight = (6.6, 7.1, 7.8)
    outside = fixtures.WALL_THICKNESS + 0.01
    x0, x1, z0, z1 = NORTH_WINDOW
    north = Lamp(
        "outside",
        (WIDTH / 2 + (x0 + x1) / 2, DEPTH + outside, (z0 + z1) / 2),
        ((x1 - x0, 0.0, 0.0), (0.0, 0.0, z1 - z0)),
        0.0,
        daylight,
    )
    x0, x1, z0, z1 = WEST_WINDOW
    west = Lamp(
        "outside",
        (-outside, DEPTH / 2 + (x0 + x1) / 2, (z0 + z1) / 2),
        ((0.0, x1 - x0, 0.0), (0.0, 0.0, z1 - z0)),
        0.0,
        daylight,
    )
    ceiling = Lamp(
        "ceiling_lamp_glow",
        (CEILING_LAMP[0], CEILING_LAMP[1], HEIGHT - 0.045),
        ((size, 0.0, 0.0), (0.0, -size, 0.0)),
        0.0,
        (panel[0], panel[1], panel[2]),
    )
    centre = (TABLE[0], TABLE[1], PENDANT_Z + 0.025 + BULB_RADIUS)
    pendant = Lamp("pendant_bulb", centre, None, BULB_RADIUS, (bulb[0], bulb[1], bulb[2]))
    return north, west, ceiling, pendant
