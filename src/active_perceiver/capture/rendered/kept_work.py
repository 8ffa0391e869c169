"""Work of many processes that is kept as it is done: only what is missing is done, and a room's light among it."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import fields
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from active_perceiver.capture.rendered.capture_store import CaptureStore
from active_perceiver.capture.rendered.config import CaptureError
from active_perceiver.parallel.process_pool import run_parallel
from active_perceiver.utils.progress import ProgressCallback
from indoor_rooms.renderer.compiled import Surfaces
from indoor_rooms.renderer.lighting import BakedRoom
from indoor_rooms.room import Room

Shared = TypeVar("Shared")
# The surfaces follow from the room.
LIGHT_FIELDS = tuple(field.name for field in fields(BakedRoom) if field.name not in ("room", "surfaces"))


def run_missing(
    work: Callable[[Shared, tuple[str, Any]], None],
    shared: Shared,
    store: CaptureStore,
    keys: Sequence[str],
    jobs: Sequence[Any],
    workers: int | None,
    report: ProgressCallback,
) -> None:
    """Do those pieces of work that the store does not hold; `work` puts them there itself.

    Args:
        work: given `shared`, and the key and the job of a piece.
        shared: what all pieces need.
        store: where they are kept.
        keys: a name for each piece.
        jobs: what differs between them.
        workers: processes; None for one a core.
        report: told how many of all pieces are done.
    """
    missing = store.missing(keys)
    before = len(keys) - len(missing)
    if missing:
        run_parallel(
            work,
            shared,
            [(keys[number], jobs[number]) for number in missing],
            workers,
            lambda done, total, note="": report(before + done, len(keys), note),
        )


def light_arrays(baked: BakedRoom) -> dict[str, NDArray[Any]]:
    """A room's light as arrays for a store."""
    return {name: np.asarray(getattr(baked, name)) for name in LIGHT_FIELDS}


def lit_room(room: Room, surfaces: Surfaces, arrays: Mapping[str, NDArray[Any]]) -> BakedRoom:
    """A room with the light that `light_arrays` kept.

    Raises:
        CaptureError: if it is the light of another room.
    """
    if len(arrays["total"]) != len(surfaces.positions):
        raise CaptureError(f"what is kept is not the light of room '{room.name}'; begin anew with --force")
    light: dict[str, Any] = {name: arrays[name] for name in LIGHT_FIELDS}
    return BakedRoom(
        room=room, surfaces=surfaces, **{name: value if value.ndim else value.item() for name, value in light.items()}
    )
