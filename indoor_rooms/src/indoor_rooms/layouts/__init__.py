"""The rooms there are, by name: LAYOUTS. Each is made from a seed; `make_room` makes one that works."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

from indoor_rooms.errors import RoomError
from indoor_rooms.layouts import conference_room, kitchen, living_room
from indoor_rooms.layouts.contents import Contents
from indoor_rooms.layouts.daylight import HOURS
from indoor_rooms.layouts.placement import NoRoomError
from indoor_rooms.room import Room

# Arrangements tried for a seed before giving up.
ATTEMPTS = 60


class LayoutError(RoomError, ValueError):
    """A room that cannot be made."""


@dataclass(frozen=True)
class Layout:
    """A kind of room.

    Attributes:
        furnish: makes one arrangement from a seed, the number of the attempt, what lies about and the hour of the day
            (None for the seed's own); raises NoRoomError if it does not work out.
        contents: what usually lies about.
        things: added to a room's seed gives that of its things, so that rooms of the same number but of another kind
            do not hold the same mug.
    """

    furnish: Callable[[int, int, Contents, str | None], Room]
    contents: Contents
    things: int = 0


LAYOUTS: dict[str, Layout] = {
    "conference_room": Layout(conference_room.furnish_conference_room, conference_room.CONTENTS, 2000),
    "kitchen": Layout(kitchen.furnish_kitchen, kitchen.CONTENTS),
    "living_room": Layout(living_room.furnish_living_room, living_room.CONTENTS, 1000),
}


def make_room(
    layout: str,
    seed: int = 1,
    contents: Contents | None = None,
    hour: str | None = None,
    moved: int | None = None,
) -> Room:
    """A furnished room, in which a robot can get about and reach every target.

    Args:
        layout: a name in LAYOUTS.
        seed: at least 1; each seed is another room of that layout.
        contents: what lies about; what is usual there if None.
        hour: of the day, one of `daylight.HOURS`; the seed's own if None. Nothing but the light depends on it.
        moved: at least 1; the same things lie elsewhere on the same furniture, each number is another arrangement.

    Raises:
        LayoutError: if there is no such layout or hour, a number is below 1, or no arrangement holds everything.
    """
    if layout not in LAYOUTS:
        raise LayoutError(f"there is no room layout '{layout}'; choose one of: {', '.join(sorted(LAYOUTS))}")
    if seed < 1:
        raise LayoutError(f"a room's seed must be at least 1, not {seed}")
    if hour is not None and hour not in HOURS:
        raise LayoutError(f"there is no hour of the day '{hour}'; choose one of: {', '.join(HOURS)}")
    if moved is not None and moved < 1:
        raise LayoutError(f"the number of another arrangement must be at least 1, not {moved}")
    kind = LAYOUTS[layout]
    contents = contents or kind.contents
    if contents.seed is None:
        contents = replace(contents, seed=kind.things + seed)
    reason = ""
    for attempt in range(ATTEMPTS):
        try:
            # Whether an arrangement works out is for the things in their own places to say: where else they lie must
            # not change the furniture.
            room = kind.furnish(seed, attempt, contents, hour)
        except NoRoomError as error:
            reason = str(error)
            continue
        if moved is None:
            return room
        try:
            return kind.furnish(seed, attempt, replace(contents, moved=moved), hour)
        except NoRoomError as error:
            raise LayoutError(
                f"arrangement {moved} of what lies in {layout} {seed} does not work out ({error}); take another "
                "number"
            ) from None
    raise LayoutError(f"no {layout} could be arranged for seed {seed} ({reason}); take another seed")
