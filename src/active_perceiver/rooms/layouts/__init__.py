"""The rooms there are, by name: LAYOUTS. Each is made from a seed; `make_room` makes one that works."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

from active_perceiver.errors import UserError
from active_perceiver.rooms.layouts import conference_room, kitchen, living_room
from active_perceiver.rooms.layouts.placement import NoRoomError
from active_perceiver.rooms.layouts.things import Contents
from active_perceiver.rooms.room import Room

# Arrangements tried for a seed before giving up.
ATTEMPTS = 60


class LayoutError(UserError, ValueError):
    """A room that cannot be made."""


@dataclass(frozen=True)
class Layout:
    """A kind of room.

    Attributes:
        furnish: makes one arrangement from a seed, the number of the attempt and what lies about; raises NoRoomError
            if it does not work out.
        contents: what usually lies about.
        things: added to a room's seed gives that of its things, so that rooms of the same number but of another kind
            do not hold the same mug.
    """

    furnish: Callable[[int, int, Contents], Room]
    contents: Contents
    things: int = 0


LAYOUTS: dict[str, Layout] = {
    "conference_room": Layout(conference_room.furnish_conference_room, conference_room.CONTENTS, 2000),
    "kitchen": Layout(kitchen.furnish_kitchen, kitchen.CONTENTS),
    "living_room": Layout(living_room.furnish_living_room, living_room.CONTENTS, 1000),
}


def make_room(layout: str, seed: int = 1, contents: Contents | None = None) -> Room:
    """A furnished room, in which a robot can get about and reach every target.

    Args:
        layout: a name in LAYOUTS.
        seed: at least 1; each seed is another room of that layout.
        contents: what lies about; what is usual there if None.

    Raises:
        LayoutError: if there is no such layout, the seed is below 1, or no arrangement holds everything.
    """
    if layout not in LAYOUTS:
        raise LayoutError(f"there is no room layout '{layout}'; choose one of: {', '.join(sorted(LAYOUTS))}")
    if seed < 1:
        raise LayoutError(f"a room's seed must be at least 1, not {seed}")
    kind = LAYOUTS[layout]
    contents = contents or kind.contents
    if contents.seed is None:
        contents = replace(contents, seed=kind.things + seed)
    reason = ""
    for attempt in range(ATTEMPTS):
        try:
            return kind.furnish(seed, attempt, contents)
        except NoRoomError as error:
            reason = str(error)
    raise LayoutError(f"no {layout} could be arranged for seed {seed} ({reason}); take another seed")
