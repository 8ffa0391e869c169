"""Reading a recording, see `recorder.py`, and what a report is made of."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from active_perceiver.agent.perceiver import Step
from active_perceiver.live import SearchRecord, StepRecord
from active_perceiver.live.recorder import (
    CUT_OFF,
    HEADER,
    PICTURE,
    STEPS,
    VERSION,
    RecordingError,
    header_of,
)
from active_perceiver.live.recording_header import RecordingHeader
from active_perceiver.live.search_loop import FOUND
from active_perceiver.live.stored_recording import StoredEnd, StoredLook, checked, read_header, whole_characters
from active_perceiver.recognition.recogniser import Detection
from active_perceiver.scenes import Action, decode_image, read_image
from active_perceiver.utils.json_reader import parse_json


@dataclass(frozen=True)
class Recording:
    """A search as it was recorded, or as it just ended.

    Attributes:
        setup: what it was asked to do.
        record: what came of it, at least one look.
    """

    setup: RecordingHeader
    record: SearchRecord


def read_recording(folder: Path) -> Recording:
    """Read a recording, of a search that ended, was interrupted or was killed.

    Raises:
        RecordingError: if the folder is no recording, holds no look yet, or is damaged other than at its end.
        ImageError: if its picture cannot be read.
    """
    header = header_of(folder / HEADER)
    if header is None:
        raise RecordingError(
            f"{folder} is not a recording: it has no sound {HEADER}; `active-perceiver search --record` makes one"
        )
    if (version := header.get("version")) != VERSION:
        raise RecordingError(f"{folder} has version {version}; this software reads version {VERSION}: update it")
    try:
        setup = read_header(header)
    except ValueError as error:
        raise RecordingError(f"{folder / HEADER} is damaged: {error}") from None
    step_records: list[StepRecord] = []
    ended: StoredEnd | None = None
    for number, value in _lines(folder / STEPS):
        where = f"line {number} of {folder / STEPS}"
        if ended is not None:
            raise RecordingError(f"{where} comes after the end; a recording holds one search: delete what follows it")
        try:
            if "ended" in value:
                ended = checked(value, StoredEnd)
            else:
                step_records.append(_step_record(value, len(step_records), folder, setup.actions))
        except ValueError as error:
            raise RecordingError(f"{where} is damaged: {error}") from None
    if not step_records:
        raise RecordingError(
            f"{folder} holds no look: the search ended before the first one; there is nothing to show"
        )
    last = step_records[-1]
    if ended is None:
        found = last.step.found
        ended = StoredEnd(found, FOUND if found else CUT_OFF, last.seconds)
    reason = whole_characters(ended.reason)
    record = SearchRecord(
        read_image(folder / PICTURE), tuple(step_records), ended.found, ended.seconds, reason, setup.dry_run
    )
    return Recording(setup, record)


def _lines(path: Path) -> Iterator[tuple[int, dict[str, Any]]]:
    """Number, from 1, and content of each line of a log but a torn last one."""
    try:
        lines = path.read_bytes().splitlines(keepends=True)
    except OSError as error:
        raise RecordingError(f"{path} cannot be read: {error.strerror}") from None
    for number, line in enumerate(lines, 1):
        value, reason = None, "it is no JSON object"
        try:
            if line.endswith(b"\n"):
                value = parse_json(line)
        except ValueError as error:
            reason = f"{reason} ({error})"
        if isinstance(value, dict):
            yield number, value
        elif number < len(lines):
            raise RecordingError(f"line {number} of {path} is damaged: {reason}; repair or delete it")


def _step_record(value: dict[str, Any], look: int, folder: Path, actions: tuple[Action, ...]) -> StepRecord:
    """A look from its line.

    Raises:
        ValueError: if something in it is missing or wrong, or its frame is.
    """
    stored = checked(value, StoredLook)
    rules = {
        f"look is not {look}": stored.look == look,
        "action is not one of the recording's": stored.action in actions,
        "score and box are not both there or both null": (stored.score is None) == (stored.box is None),
        f"probabilities are not {len(actions)} numbers": len(stored.probabilities) == len(actions),
    }
    for wrong, kept in rules.items():
        if not kept:
            raise ValueError(wrong)
    path = folder / stored.frame
    try:
        data = path.read_bytes()
    except OSError as error:
        raise ValueError(f"its frame {path} cannot be read: {error.strerror}") from None
    decode_image(data, f"its frame {path}", side=32)  # small is fast, and damage shows as well
    seen = None if stored.score is None else Detection(stored.score, np.array(stored.box))
    step = Step(stored.action, seen, np.array(stored.probabilities), stored.found)
    return StepRecord(data, stored.pose, step, stored.moved, stored.seconds)
