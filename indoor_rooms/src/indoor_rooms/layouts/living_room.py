"""Living rooms: a sofa opposite a television with a low table between, bookcases, a chest, perhaps a desk."""

from __future__ import annotations

import numpy as np

from indoor_rooms.furniture import lounge, screens, seating, soft, storage, tables
from indoor_rooms.layouts.cases import (
    keep_floor,
    stand_bookcase,
    stand_chest,
    stand_desk,
    stand_plants,
    stand_radiator,
)
from indoor_rooms.layouts.common import bare_room, dress_window, hang_pictures, make_window, sill_ledge, wall_ledge
from indoor_rooms.layouts.contents import Contents, lay_things
from indoor_rooms.layouts.daylight import NEUTRAL, WARM, Daylight, hour_of_day, scaled
from indoor_rooms.layouts.dining import RUG_TOP
from indoor_rooms.layouts.placement import Ledge, RoomBuilder, stream
from indoor_rooms.layouts.shell import ceiling_panel, daylight_lamps, hang_door, pendant, raise_walls
from indoor_rooms.layouts.walls import WALL_GAP, FloorLayout, Wall
from indoor_rooms.materials.material import Material
from indoor_rooms.materials.surfaces import glazed
from indoor_rooms.materials.themes import Theme, floor_of, pick_one, theme_of, upholstery_of
from indoor_rooms.room import Lamp, Room

CONTENTS = Contents(
    ("remote_control", "laptop", "lamp", "cushion", "book", "vase", "clock", "bag"),
    (
    "candle", "photo_frame", "house_plant", "teddy_bear", "globe", "tissue_box", "ball", "game_controller",
    "headphones", "phone", "radio", "mug", "bowl", "camera", "basket", "book_stack", "bottle", "apple",
    "teapot",
    ),
)  # fmt: skip

OPPOSITE = {"north": "south", "south": "north", "east": "west", "west": "east"}
SOFA_DEPTH = 1.0
SOFA_SEAT_DEPTH = SOFA_DEPTH - lounge.SOFA_DEPTH + lounge.SOFA_SEAT_DEPTH
TV_STAND_DEPTH = 0.42
# A seat's cushion is flat but for its edges, metres.
SOFT_EDGES = 0.07
ARMCHAIR_WIDTH, ARMCHAIR_DEPTH = 0.92, 0.98


def furnish_living_room(seed: int, attempt: int, contents: Contents = CONTENTS, hour: str | None = None) -> Room:
    """A furnished living room.

    Args:
        seed: everything follows from it.
        attempt: another arrangement for the same seed, for when one does not work out.
        contents: what lies about.
        hour: of the day, see `daylight.HOURS`; it follows from the seed if None.

    Raises:
        NoRoomError: if this arrangement leaves too little room for a robot or for things.
    """
    rng = stream(seed, f"living room {attempt}")
    width, depth = float(rng.uniform(4.2, 5.4)), float(rng.uniform(4.0, 4.8))
    height = float(rng.uniform(2.45, 2.8))
    plan, builder, theme = FloorLayout(width, depth), RoomBuilder(), theme_of(rng)
    watched = pick_one(rng, list(plan.walls.values()))
    behind = plan.walls[OPPOSITE[watched.name]]
    sides = [wall for wall in plan.walls.values() if wall not in (watched, behind)]
    glazed_walls = [sides[int(index)] for index in rng.permutation(2)][: 1 if rng.random() < 0.5 else 2]
    windows = [make_window(plan, wall, rng, (0.72, 0.95), height) for wall in glazed_walls]
    light = hour_of_day(glazed_walls, rng, hour)
    ledges, lamps, middle = _seats(builder, plan, watched, behind, theme, light, rng)
    others = [*sides, watched, behind]
    hang_door(builder, plan, others, theme, rng)
    for number in range(1, 3 if rng.random() < 0.6 else 2):
        ledges += stand_bookcase(builder, plan, others, theme.casing, f"bookcase_{number}", rng)
    ledges += stand_chest(builder, plan, others, theme, "chest", rng)
    if rng.random() < 0.75:
        ledges += stand_desk(builder, plan, others, theme, rng, swivel=rng.random() < 0.3)
    ledges += keep_floor(plan, others, 2, rng)
    stand_plants(builder, plan, others, int(rng.integers(1, 3)), rng)
    for window in windows:
        ledges.append(sill_ledge(window))
        stand_radiator(builder, window)
        dress_window(builder, window, theme, rng, floor=False)
    hang_pictures(builder, plan, theme.timber, rng, 4, others)

    feature = pick_one(rng, (watched, behind)) if theme.feature else None
    raise_walls(builder, plan, height, windows, theme, feature, floor_of(theme.floor, theme.seed))
    targets = lay_things(builder, plan, ledges, contents, seed)

    lamps += daylight_lamps(builder, windows, light, seed)
    if rng.random() < 0.5:
        shade = glazed(theme.accent, 0.35)
        lamps.append(pendant(builder, *middle, height, height - 0.55, shade, WARM, 0.8 * light.lamps))
    else:
        x, y = width / 2, depth / 2
        lamps.append(ceiling_panel(builder, x, y, height, 0.5, pick_one(rng, (WARM, NEUTRAL)), light.lamps))
    return bare_room(builder, plan, height, f"living_room_{seed}", targets, light.sun, light.sky, lamps)


def _seats(
    builder: RoomBuilder,
    plan: FloorLayout,
    watched: Wall,
    behind: Wall,
    theme: Theme,
    light: Daylight,
    rng: np.random.Generator,
) -> tuple[list[Ledge], list[Lamp], tuple[float, float]]:
    """Television and sofa opposite each other, what stands between and beside them.

    Returns:
        Ledges, lamps, and the middle of the low table.
    """
    ledges: list[Ledge] = []
    lamps: list[Lamp] = []
    sofa_width = float(rng.uniform(1.7, 2.3))
    along = float(rng.uniform(behind.length * 0.42, behind.length * 0.58))
    fabric, feet = upholstery_of(theme.fabric, rng), theme.frames
    plan.take(behind.rectangle(along, sofa_width, 0.0, WALL_GAP + SOFA_DEPTH))
    builder.add(
        "sofa",
        lounge.sofa(sofa_width, fabric, feet, SOFA_DEPTH),
        behind.point(along, WALL_GAP),
        behind.turn,
        obstacle=True,
    )
    out = WALL_GAP + lounge.SOFA_BACK_DEPTH + SOFA_SEAT_DEPTH / 2
    centres = lounge.seat_centres(sofa_width)
    seat = (sofa_width - 2 * lounge.ARM_WIDTH) / len(centres) - SOFT_EDGES
    for centre in centres:
        ledge = wall_ledge(behind, (along + centre, out, lounge.SEAT_HEIGHT), (seat, SOFA_SEAT_DEPTH), "sofa", "seat")
        ledges.append(ledge)

    opposite = watched.length - along
    stand = float(rng.uniform(1.6, 1.95))
    screen = float(rng.uniform(0.85, stand - 0.62))
    plan.take(watched.rectangle(opposite, stand, 0.0, WALL_GAP + TV_STAND_DEPTH + 0.05))
    builder.add(
        "tv_stand",
        storage.tv_stand(stand, theme.casing, TV_STAND_DEPTH),
        watched.point(opposite, WALL_GAP),
        watched.turn,
        obstacle=True,
    )
    builder.add(
        "television",
        screens.television(screen),
        watched.point(opposite, WALL_GAP + 0.10, storage.TV_STAND_HEIGHT + 0.0008),
        watched.turn,
    )
    plan.hang(watched, opposite, screen + 0.1)
    free = (stand - screen) / 2 - 0.03
    for side in (-1, 1):
        place = opposite + side * (stand - free - 0.02) / 2
        ledges.append(
            wall_ledge(watched, (place, WALL_GAP + 0.21, storage.TV_STAND_HEIGHT), (free, 0.36), "tv_stand", "board")
        )
    table_ledges, middle, reach = _low_table(builder, plan, behind, along, theme, rng)
    ledges += table_ledges
    ledges += _armchairs(
        builder,
        plan,
        behind,
        along,
        reach,
        fabric if rng.random() < 0.5 else upholstery_of(theme.accent, rng),
        feet,
        rng,
    )
    for side in rng.permutation((-1, 1)).tolist():
        place = along + side * (sofa_width / 2 + 0.32)
        rectangle = behind.rectangle(place, 0.52, WALL_GAP, 0.52)
        if not plan.fits(rectangle, 0.0):
            continue
        plan.take(rectangle)
        if not lamps:
            lamps.append(_floor_lamp(builder, behind, place, light, rng))
        else:
            builder.add(
                "side_table",
                tables.side_table(0.46, theme.timber, theme.frames),
                behind.point(place, 0.30, 0.0004),
                behind.turn,
                obstacle=True,
            )
            ledges.append(
                wall_ledge(behind, (place, 0.30, tables.SIDE_TABLE_HEIGHT), (0.38, 0.26), "side_table", "low table")
            )
    return ledges, lamps, middle


def _low_table(
    builder: RoomBuilder, plan: FloorLayout, behind: Wall, along: float, theme: Theme, rng: np.random.Generator
) -> tuple[list[Ledge], tuple[float, float], float]:
    """A coffee table on a rug in front of the sofa; its ledges, its middle, half the rug's width."""
    shape = str(rng.choice(("rectangle", "round", "shelf")))
    width = 0.85 if shape == "round" else float(rng.uniform(0.9, 1.2))
    depth = width if shape == "round" else float(rng.uniform(0.55, 0.65))
    front = WALL_GAP + SOFA_DEPTH
    out = front + 0.42 + depth / 2
    rug_width, rug_from, rug_to = width + 0.75, front + 0.04, out + depth / 2 + 0.28
    rug_depth = rug_to - rug_from
    rug_out = (rug_from + rug_to) / 2
    builder.add(
        "rug", seating.rug(rug_width, rug_depth, *theme.rug), behind.point(along, rug_out, 0.0006), behind.turn
    )
    plan.take(behind.rectangle(along, rug_width, rug_from, rug_depth))
    table = tables.coffee_table(width, depth, theme.timber, theme.frames, shape)  # type: ignore[arg-type]
    builder.add("coffee_table", table, behind.point(along, out, RUG_TOP), behind.turn, obstacle=True)
    top = RUG_TOP + tables.COFFEE_TABLE_HEIGHT
    usable = width - 0.1 if shape != "round" else width * 0.66
    strip, offset = (depth / 2 - 0.06, depth / 4 - 0.01) if shape != "round" else (0.24, 0.13)
    ledges = []
    for sign in (-1, 1):
        ledge = wall_ledge(behind, (along, out + sign * offset, top), (usable, strip), "coffee_table", "low table")
        ledges.append(ledge)
    x, y, _ = behind.point(along, out)
    return ledges, (x, y), rug_width / 2


def _armchairs(
    builder: RoomBuilder,
    plan: FloorLayout,
    behind: Wall,
    along: float,
    reach: float,
    fabric: Material,
    feet: Material,
    rng: np.random.Generator,
) -> list[Ledge]:
    """One or two armchairs beside the rug, facing the low table."""
    ledges = []
    count = 0
    for side in rng.permutation((-1, 1)).tolist():
        place, out = along + side * (reach + 0.62), WALL_GAP + SOFA_DEPTH + float(rng.uniform(0.50, 0.75))
        rectangle = behind.rectangle(place, 1.06, out - 0.5, 1.0)
        if (count and rng.random() < 0.5) or not plan.fits(rectangle, 0.02):
            continue
        plan.take(rectangle)
        count += 1
        name = f"armchair_{count}"
        # A side of -1 is left of the sofa's middle, from where the table is to the right.
        turn = behind.turn - side * 90.0
        piece = lounge.armchair(fabric, feet, ARMCHAIR_WIDTH, ARMCHAIR_DEPTH)
        builder.add(name, piece, behind.point(place, out, 0.0004), turn, obstacle=True)
        seat = ARMCHAIR_DEPTH - lounge.SOFA_BACK_DEPTH - 0.07
        first = place - side * (ARMCHAIR_DEPTH / 2 - 0.07 - seat / 2)
        half = (ARMCHAIR_WIDTH - 2 * lounge.ARMCHAIR_ARM_WIDTH - SOFT_EDGES) / 2
        # The seat's own frame: its ledge runs along its width, which is out of the wall.
        ends = [behind.point(first, out + sign * side * half)[:2] for sign in (-1, 1)]
        ledges.append(Ledge(name, "seat", ends[0], ends[1], lounge.SEAT_HEIGHT, seat))
    return ledges


def _floor_lamp(builder: RoomBuilder, behind: Wall, place: float, light: Daylight, rng: np.random.Generator) -> Lamp:
    """A standing lamp beside the sofa."""
    glow = scaled(WARM, 45.0 * light.lamps)
    pieces, glowing, (bulb_x, bulb_y, bulb_z), radius = soft.floor_lamp(rng, glow)
    x, y, z = behind.point(place, 0.30, 0.0004)
    builder.add("floor_lamp", pieces, (x, y, z), obstacle=True)
    builder.add("floor_lamp_bulb", glowing, (x, y, z))
    return Lamp("floor_lamp_bulb", (x + bulb_x, y + bulb_y, z + bulb_z), None, radius, glow)
