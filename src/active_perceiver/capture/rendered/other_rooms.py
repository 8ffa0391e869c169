"""Other rooms in which the things of a scene lie, and how many photographs of each thing are taken in which."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from active_perceiver.capture.rendered.config import CaptureError
from active_perceiver.capture.rendered.render import room_fingerprint
from indoor_rooms.layouts import make_room
from indoor_rooms.layouts.contents import Contents
from indoor_rooms.room import Room

OTHER_LAYOUT = "living_room"
# Far from the seeds that anyone gives to a room.
OTHER_SEED = 9001
# A room that is given more things often has no place for the smallest: large ones are laid out first.
THINGS = 8


@dataclass(frozen=True)
class OtherRoom:
    """One of the rooms: what it follows from, and how many poses are looked for of which target."""

    number: int
    contents: Contents
    wanted: Mapping[str, int]

    @property
    def seed(self) -> int:
        """Of the room."""
        return OTHER_SEED + self.number

    @property
    def name(self) -> str:
        """Of the room."""
        return f"{OTHER_LAYOUT}_{self.seed}"

    @property
    def key(self) -> str:
        """Of its light and poses in the store."""
        return f"room-{self.number:03}"

    def furnished(self) -> Room:
        """The room itself."""
        return make_room(OTHER_LAYOUT, self.seed, self.contents)


def plan_rooms(
    names: Sequence[str], wanted: Sequence[str], seed: int, pictures: int, count: int
) -> tuple[tuple[OtherRoom, ...], list[str]]:
    """Furnish rooms such that together they hold what is wanted.

    Each room is given what those before it held least often, first of what is wanted.

    Args:
        names: of everything that may lie about.
        wanted: names of what is to be photographed.
        seed: of the things' shapes and colours.
        pictures: wanted of each.
        count: of rooms.

    Returns:
        The rooms, and a fingerprint of each.

    Raises:
        CaptureError: if no room has a place for something that is wanted.
    """
    held = dict.fromkeys(names, 0)
    furnished, fingerprints = [], []
    for number in range(count):
        order = sorted(names, key=lambda name: (name not in wanted, held[name]))
        contents = Contents(required=(), optional=tuple(order[:THINGS]), seed=seed)
        room = OtherRoom(number, contents, {}).furnished()
        fingerprints.append(room_fingerprint(room))
        furnished.append((contents, [name for name in wanted if name in room.targets]))
        for name in room.targets:
            held[name] += 1
    if nowhere := [name for name in wanted if not held[name]]:
        raise CaptureError(
            f"none of {count} other rooms has a place for {', '.join(nowhere)}; ask for more --rooms, or for other "
            "--targets"
        )
    # Some rooms show a thing badly: others are asked for twice their share.
    poses = {name: min(pictures, 2 * -(-pictures // held[name])) for name in wanted}
    rooms = tuple(
        OtherRoom(number, contents, {name: poses[name] for name in there})
        for number, (contents, there) in enumerate(furnished)
    )
    return rooms, fingerprints


def shared_out(wanted: int, available: Sequence[int]) -> list[int]:
    """How many each gives, as evenly as can be, so that together they give what is wanted or all they have."""
    order = sorted(range(len(available)), key=lambda row: available[row])
    shares = [0] * len(available)
    for done, row in enumerate(order):
        shares[row] = min(available[row], (wanted - sum(shares)) // (len(order) - done))
    return shares
