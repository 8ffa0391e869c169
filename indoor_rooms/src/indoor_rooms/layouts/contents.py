"""Which things may lie on which surfaces, how they are turned, and laying them out in a room."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from indoor_rooms.furniture import appliances
from indoor_rooms.geometry.pieces import Pieces, placed
from indoor_rooms.layouts.common import check_targets, within_reach
from indoor_rooms.layouts.placement import Item, Ledge, RoomBuilder, assign, lay_out, stream
from indoor_rooms.layouts.walls import FloorLayout
from indoor_rooms.objects import OBJECTS

SURFACES = {
    "counter": "a kitchen's worktop",
    "table": "a dining table",
    "desk": "a desk or a conference table",
    "low table": "a coffee table or a side table",
    "board": "the top of a sideboard, a chest or a cabinet",
    "shelf": "a board of a bookcase or on a wall",
    "sill": "a window sill",
    "seat": "a sofa or an armchair",
    "floor": "the floor beside a wall",
}

_TOPS = ("table", "desk", "low table", "board")
_KITCHEN = ("counter", "table", "board")
_FRUIT = ("counter", "table", "low table", "board", "desk")

ALLOWED: dict[str, tuple[str, ...]] = {
    # the kitchen's
    "apple": _FRUIT, "banana": _FRUIT, "green_apple": _FRUIT, "lemon": _KITCHEN, "orange": _FRUIT,
    "bowl": (*_KITCHEN, "low table"), "bread": _KITCHEN, "plate": (*_KITCHEN, "low table"),
    "mug": ("counter", *_TOPS), "teapot": ("counter", "table", "board", "low table"),
    "jar": (*_KITCHEN, "shelf"), "bottle": (*_KITCHEN, "shelf"), "can": ("counter", "shelf"),
    "cereal": ("counter", "board", "table"), "milk": ("counter", "table"), "soap": ("counter", "sill"),
    "spray_bottle": ("counter", "sill"), "toaster": ("counter", "board"), "knife_block": ("counter",),
    "microwave": ("counter", "board"), "herb_pot": ("sill", "counter"), "utensil_crock": ("counter",),
    "paper_roll": ("counter", "board"), "pepper_mill": ("shelf", "table", "counter"),
    # of living rooms and offices
    "remote_control": ("low table", "board"), "phone": _TOPS, "laptop": ("table", "desk", "low table", "board"),
    "lamp": ("board", "desk", "low table"), "clock": ("board", "shelf", "desk", "sill"),
    "headphones": ("desk", "low table", "board", "shelf"), "game_controller": ("low table", "board", "seat"),
    "radio": ("board", "shelf", "sill"), "scissors": ("desk", "table", "board"), "stapler": ("desk", "board"),
    "tape_dispenser": ("desk", "board"), "pen_cup": ("desk", "board", "sill"), "calculator": ("desk", "board"),
    "binder": ("desk", "board", "shelf"), "notebook": ("desk", "low table", "table"), "cushion": ("seat",),
    "candle": ("low table", "board", "shelf", "sill", "table"), "photo_frame": ("board", "shelf", "desk"),
    "house_plant": ("sill", "board", "desk", "low table"), "bag": ("seat", "floor", "board"),
    "teddy_bear": ("seat", "board"),
    "globe": ("board", "shelf", "desk"), "tissue_box": ("low table", "board", "desk", "sill"),
    "ball": ("floor",), "water_bottle": ("desk", "board", "table"), "camera": ("board", "shelf", "low table", "desk"),
    "book": _TOPS, "book_stack": ("low table", "board", "desk"), "basket": ("floor", "board"),
    "vase": ("board", "low table", "table", "sill"),
}  # fmt: skip

# Lived in, but not searched for.
SCENERY = ("microwave", "herb_pot", "utensil_crock", "paper_roll", "pepper_mill")

# How far a thing may be turned from facing the room, degrees; anything else may be turned at will.
SWING = {
    "bread": 20, "toaster": 8, "cereal": 18, "milk": 25, "book": 25, "knife_block": 12, "banana": 25, "soap": 50,
    "microwave": 4, "laptop": 14, "clock": 20, "game_controller": 40, "radio": 12, "tape_dispenser": 40,
    "calculator": 25, "binder": 10, "notebook": 30, "cushion": 6, "photo_frame": 18, "bag": 10, "teddy_bear": 18,
    "tissue_box": 25, "camera": 25, "book_stack": 20, "basket": 20, "remote_control": 70, "phone": 60,
}  # fmt: skip


@dataclass(frozen=True)
class Contents:
    """Which things a room holds.

    Attributes:
        required: names of those that must be there, each on another piece of furniture if there is enough.
        optional: what there may be besides; what finds no room is left out.
        seed: of their shapes and colours; the room's own if None.
        moved: which other arrangement of the same things on the same furniture; the room's own if None.
    """

    required: tuple[str, ...]
    optional: tuple[str, ...] = ()
    seed: int | None = None
    moved: int | None = None


def lay_things(
    builder: RoomBuilder, plan: FloorLayout, ledges: Sequence[Ledge], contents: Contents, seed: int
) -> dict[str, str]:
    """Put things on those ledges that a robot can come close to.

    Args:
        builder: has all the furniture, takes the parts.
        plan: the room's size.
        ledges: where things may stand.
        contents: which things.
        seed: of places, and of shapes and colours if the contents have no seed of their own.

    Returns:
        Those that can be searched for: object name -> category.

    Raises:
        NoRoomError: if a required thing finds no room, or a robot cannot get about or come near a target.
    """
    ledges = within_reach(builder, plan, ledges)
    items = []
    for name in dict.fromkeys((*contents.required, *contents.optional)):
        rng = stream(seed if contents.seed is None else contents.seed, name)
        pieces = appliances.microwave() if name == "microwave" else OBJECTS[name](rng)
        items.append(Item(name, placed(pieces, turn=_turn(name, rng)), ALLOWED[name]))
    rng = stream(seed, arrangement("places", contents.moved))
    targets = {}
    for ledge, chosen in zip(ledges, assign(items, ledges, contents.required, rng), strict=True):
        on_floor = ledge.kind == "floor"

        def put(
            name: str, pieces: Pieces, place: tuple[float, float, float], turn: float, obstacle: bool = on_floor
        ) -> None:
            builder.add(name, pieces, place, turn, obstacle=obstacle)

        lay_out(chosen, ledge, rng, put)
        targets.update({item.name: item.name for item in chosen if item.name not in SCENERY})
    check_targets(builder, plan, targets)
    return dict(sorted(targets.items()))


def arrangement(label: str, moved: int | None) -> str:
    """Label of the random numbers that say where things lie, see `Contents.moved`."""
    return label if moved is None else f"{label} {moved}"


def _turn(name: str, rng: np.random.Generator) -> float:
    if name in ("mug", "teapot"):
        # Handle to one side or the other, a little towards the room: what makes a mug a mug is seen.
        return float(rng.choice([0.0, 180.0]) + rng.uniform(-40, 40))
    swing = SWING.get(name, 180)
    return float(rng.uniform(-swing, swing))
