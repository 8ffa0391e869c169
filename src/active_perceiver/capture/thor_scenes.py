"""`scenes capture thor`: one room of AI2-THOR, or a kind of them, to scene files; resumable."""

from __future__ import annotations

import logging
from collections.abc import Callable, Iterator, Sequence
from dataclasses import asdict, replace
from pathlib import Path
from typing import Literal

from active_perceiver.capture.thor import PLAN, ThorCapture, capture_thor, client_version
from active_perceiver.capture.thor_targets import NoTargetsError
from active_perceiver.parallel.run_store import RunStore, part_folder
from active_perceiver.robots.ai2thor import Controller, ThorConfig, ThorError, start_controller
from active_perceiver.scenes import EIGHT_ACTIONS, save_scene
from active_perceiver.utils.files import check_output, files_there

LOG = logging.getLogger(__name__)

RoomKind = Literal["kitchens", "living_rooms", "bedrooms", "bathrooms"]
# https://ai2thor.allenai.org/ithor/documentation/scenes/
FIRST_ROOM: dict[RoomKind, int] = {"kitchens": 1, "living_rooms": 201, "bedrooms": 301, "bathrooms": 401}
ROOMS_OF_A_KIND = 30
ACTIONS = EIGHT_ACTIONS

Start = Callable[[str, ThorConfig], Controller]
Captured = ThorCapture | NoTargetsError | None


def rooms_of(kind: RoomKind) -> tuple[str, ...]:
    """AI2-THOR's names of its rooms of a kind: "FloorPlan201" to "FloorPlan230" for living rooms."""
    return tuple(f"FloorPlan{FIRST_ROOM[kind] + number}" for number in range(ROOMS_OF_A_KIND))


def capture_room(
    room: str,
    out: Path,
    settings: ThorConfig,
    *,
    types: Sequence[str] = (),
    all_types: bool = True,
    force: bool = False,
    resume: bool = False,
    start: Start | None = None,
) -> ThorCapture:
    """Capture one room and write its scene file; what is finished is kept in the folder `OUT.part` until then.

    Args:
        room: such as "FloorPlan1".
        out: the scene file; its stem becomes the scene's name.
        settings: of the lattice and the camera.
        types: AI2-THOR's types of the targets; all that can be picked up if empty.
        all_types: whether each must be in the room.
        force: replace an existing file, and begin anew where a capture was interrupted.
        resume: go on with an interrupted capture.
        start: starts the simulator; `start_controller` if None.

    Raises:
        OutputExistsError: if the file, or an interrupted capture, exists and nothing says what to do with it.
        RunStoreError: if the interrupted capture was begun with other settings.
        ThorError: see `capture_thor`.
    """
    if out.suffix != ".h5" or out.is_dir():
        raise ThorError(f"{out} is no scene file to write; give an --out that ends in .h5")
    check_output(out, force)
    noted = {
        "client": client_version(), "room": room, "settings": asdict(settings),
        "targets": list(types), "actions": [action.value for action in ACTIONS],
    }  # fmt: skip
    # Begun before the simulator is started: a contradiction is better told at once.
    store = RunStore.begin(part_folder(out), noted, force=force, resume=resume)
    try:
        controller = (start or start_controller)(room, settings)
        try:
            captured = capture_thor(
                controller, room, settings, store, types=types, all_types=all_types, actions=ACTIONS
            )
        finally:
            controller.stop()
    except ThorError:
        if store.load(PLAN) is None:
            store.remove()  # nothing was done yet
        raise
    save_scene(replace(captured.scene, name=out.stem), out, force=force)
    store.remove()
    return captured


def capture_rooms(
    rooms: Sequence[str],
    folder: Path,
    settings: ThorConfig,
    *,
    types: Sequence[str] = (),
    force: bool = False,
    resume: bool = False,
    start: Start | None = None,
) -> Iterator[tuple[Path, Captured]]:
    """Capture several rooms, one after the other, into a folder; a type that a room does not have is no error there.

    Args:
        rooms: AI2-THOR's names of them.
        folder: for the scene files, each called as its room.
        settings: see `capture_room`, as for those that follow.
        types: of the targets.
        force: replace existing files.
        resume: leave files that are there as they are, and go on with an interrupted capture.
        start: starts the simulator.

    Yields:
        Each file when it is done and what came of it; None for one that was there, and why for a room with no target.

    Raises:
        OutputExistsError: before anything is captured, if a file exists and nothing says what to do with it.
    """
    files = [folder / f"{room}.h5" for room in rooms]
    there = files_there(files, force=force, resume=resume)
    for number, (room, path) in enumerate(zip(rooms, files, strict=True), 1):
        if path in there and resume:
            yield path, None
        else:
            LOG.info("%s (%d of %d)", path, number, len(files))
            try:
                yield (
                    path,
                    capture_room(
                        room, path, settings, types=types, all_types=False, force=force, resume=resume, start=start
                    ),
                )
            except NoTargetsError as error:
                yield path, error
