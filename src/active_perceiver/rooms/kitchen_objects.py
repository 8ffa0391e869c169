"""Which things there are in a kitchen, and on which ledges each may stand."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from active_perceiver.rooms.furniture.appliances import BURNERS
from active_perceiver.rooms.objects import OBJECTS
from active_perceiver.rooms.pieces import placed
from active_perceiver.rooms.placement import LIFT, Item, Ledge, RoomBuilder, assign, lay_out, stream

COUNTERS = ("north left", "north right", "east far", "east near")
TABLE = ("table south", "table north")
SILLS = ("north sill", "west sill")
OPEN = (*COUNTERS, *TABLE, "sideboard")

# The paper's four objects: each on another piece of furniture.
OBJECTS_OF_RECORD = ("mug", "plate", "bread", "apple")

ALLOWED: dict[str, tuple[str, ...]] = {
    "mug": OPEN,
    "plate": (*TABLE, "sideboard", "north left", "east near"),
    "bread": (*COUNTERS, *TABLE, "sideboard"),
    "apple": OPEN,
    "bowl": OPEN,
    "bottle": (*COUNTERS, "sideboard", "shelf"),
    "toaster": ("north left", "east far", "east near", "sideboard"),
    "vase": ("sideboard", *TABLE),
    "banana": OPEN,
    "cereal": (*COUNTERS, "sideboard"),
    "milk": (*COUNTERS, *TABLE),
    "can": (*COUNTERS, "shelf"),
    "soap": ("north sill", "north right", "north left"),
    "book": (*TABLE, "sideboard", "east near"),
    "knife_block": COUNTERS,
    "orange": OPEN,
    "green_apple": OPEN,
    "teapot": (*TABLE, "sideboard", "east far"),
    "jar": (*COUNTERS, "shelf", *TABLE),
    "lemon": OPEN,
    "spray_bottle": (*SILLS, "north right"),
}
# Lived in, but not searched for.
EXTRAS: dict[str, tuple[str, ...]] = {
    "herb_pot": SILLS,
    "utensil_crock": ("north left", "north right", "east far"),
    "paper_roll": ("east far", "east near", "sideboard"),
    "pepper_mill": ("shelf", *TABLE),
}
# How far a thing may be turned from facing the room, degrees; anything round may be turned at will.
SWING = {"bread": 20, "toaster": 8, "cereal": 18, "milk": 25, "book": 25, "knife_block": 12, "banana": 25, "soap": 50}


def _turn(name: str, rng: np.random.Generator) -> float:
    if name in ("mug", "teapot"):
        # Handle to one side or the other, a little towards the room: what makes a mug a mug is seen.
        return float(rng.choice([0.0, 180.0]) + rng.uniform(-40, 40))
    swing = SWING.get(name, 180)
    return float(rng.uniform(-swing, swing))


def place_objects(
    builder: RoomBuilder, ledges: Sequence[Ledge], stove: tuple[float, float, float], seed: int
) -> dict[str, str]:
    """Puts all things of the kitchen on their ledges and the pots on the stove.

    Args:
        builder: takes the parts.
        ledges: where things may stand.
        stove: x of the stove's middle, y of its back, z of its top; metres.
        seed: of shapes, colours and places.

    Returns:
        Targets: object name -> category.
    """
    targets = {name: name for name in ALLOWED}
    allowed = {**ALLOWED, **EXTRAS}
    items = []
    for name in allowed:
        rng = stream(seed, name)
        pieces = OBJECTS[name](rng)
        items.append(Item(name, placed(pieces, turn=_turn(name, rng))))
    rng = stream(seed, "places")
    chosen = assign(items, ledges, allowed, OBJECTS_OF_RECORD, rng)
    for ledge in ledges:
        lay_out(chosen[ledge.name], ledge, rng, builder.add)
    _on_the_stove(builder, stove, seed)
    targets.update({name: name for name in ("pot", "pan", "kettle")})
    return targets


def _on_the_stove(builder: RoomBuilder, stove: tuple[float, float, float], seed: int) -> None:
    """Pot and kettle on the back burners, the pan in front with its handle along the stove's front."""
    rng = stream(seed, "stove")
    x, y, z = stove
    back = [BURNERS[0], BURNERS[1]]
    if rng.random() < 0.5:
        back.reverse()
    front = BURNERS[2 + int(rng.integers(2))]
    inwards = -12.0 if front[0] < 0 else 192.0
    outwards = 0.0 if back[1][0] > 0 else 180.0
    turns = {
        "pot": (back[0], 90.0 + rng.uniform(-12, 12)),
        "kettle": (back[1], outwards + (1 if outwards else -1) * rng.uniform(25, 55)),
        "pan": (front, inwards + rng.uniform(-8, 8)),
    }
    for name, ((burner_x, burner_y), turn) in turns.items():
        builder.add(name, OBJECTS[name](stream(seed, name)), (x + burner_x, y + burner_y, z + 0.0012 + LIFT), turn)
