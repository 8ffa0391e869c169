"""What stands on a stove."""

from __future__ import annotations

from indoor_rooms.furniture.appliances import BURNERS, STOVE_TOP
from indoor_rooms.geometry.mesh import Vector
from indoor_rooms.layouts.contents import arrangement
from indoor_rooms.layouts.placement import LIFT, RoomBuilder, stream
from indoor_rooms.objects import OBJECTS


def pots_on_the_stove(builder: RoomBuilder, back: Vector, seed: int, moved: int | None = None) -> None:
    """Pot and kettle on the back burners, the pan in front with its handle along the stove's front.

    Args:
        builder: takes the parts.
        back: the middle of the stove's back; it faces -y.
        seed: of shapes and which burner is whose.
        moved: see `Contents.moved`.
    """
    rng = stream(seed, arrangement("stove", moved))
    x, y, _ = back
    behind = [BURNERS[0], BURNERS[1]]
    if rng.random() < 0.5:
        behind.reverse()
    front = BURNERS[2 + int(rng.integers(2))]
    inwards = -12.0 if front[0] < 0 else 192.0
    outwards = 0.0 if behind[1][0] > 0 else 180.0
    turns = {
        "pot": (behind[0], 90.0 + rng.uniform(-12, 12)),
        "kettle": (behind[1], outwards + (1 if outwards else -1) * rng.uniform(25, 55)),
        "pan": (front, inwards + rng.uniform(-8, 8)),
    }
    for name, ((burner_x, burner_y), turn) in turns.items():
        place = (x + burner_x, y + burner_y, STOVE_TOP + 0.0012 + LIFT)
        builder.add(name, OBJECTS[name](stream(seed, name)), place, turn)
