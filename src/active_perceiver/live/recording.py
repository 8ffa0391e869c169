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
    FRAME_NAME,
    FRAMES,
    HEADER,
    PICTURE,
    STEPS,
    VERSION,
    RecordingError,
    header_of,
)
from active_perceiver.live.recording_header import RecordingHeader, is_actions, is_duration, is_flag, is_numbers
from active_perceiver.live.search_loop import FOUND
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
        setup = RecordingHeader.from_json(header)
    except ValueError as error:
        raise RecordingError(f"{folder / HEADER} is damaged: {error}") from None
    step_records: list[StepRecord] = []
    ended: dict[str, Any] | None = None
    for number, value in _lines(folder / STEPS):
        where = f"line {number} of {folder / STEPS}"
        if ended is not None:
            raise RecordingError(f"{where} comes after the end; a recording holds one search: delete what follows it")
        try:
            if "ended" in value:
                ended = _checked_end(value)
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
        ended = {"found": found, "reason": FOUND if found else CUT_OFF, "seconds": last.seconds}
    record = SearchRecord(
        read_image(folder / PICTURE), tuple(step_records), ended["found"], float(ended["seconds"]), ended["reason"],
        setup.dry_run,
    )  # fmt: skip
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


def _checked_end(value: dict[str, Any]) -> dict[str, Any]:
    if not is_flag(value.get("found")) or not isinstance(value.get("reason"), str):
        raise ValueError("found is not true or false, or reason is not a text")
    if not is_duration(value.get("seconds")):
        raise ValueError("seconds is not a number from 0 on")
    return {**value, "reason": value["reason"].encode(errors="replace").decode()}


def _step_record(value: dict[str, Any], look: int, folder: Path, actions: tuple[Action, ...]) -> StepRecord:
    """A look from its line.

    Raises:
        ValueError: if something in it is missing or wrong, or its frame is.
    """
    robot_moved, score, box, frame = (value.get(name) for name in ("moved", "score", "box", "frame"))
    pose = value.get("pose")
    rules = {
        f"look is not {look}": type(value.get("look")) is int and value["look"] == look,
        "seconds is not a number from 0 on": is_duration(value.get("seconds")),
        "pose is not four numbers or null": pose is None or is_numbers(pose, 4),
        "moved is not true, false or null": robot_moved is None or is_flag(robot_moved),
        "action is not one of the recording's": is_actions([value.get("action")])
        and Action(value["action"]) in actions,
        "found is not true or false": is_flag(value.get("found")),
        "score and box are not a number and four numbers, or both null": (score is None and box is None)
        or (is_duration(score) and is_numbers(box, 4)),
        f"probabilities are not {len(actions)} numbers": is_numbers(value.get("probabilities"), len(actions)),
        "frame is not the name of a frame": isinstance(frame, str)
        and frame.startswith(f"{FRAMES}/")
        and FRAME_NAME.fullmatch(frame[len(FRAMES) + 1 :]) is not None,
    }
    for wrong, kept in rules.items():
        if not kept:
            raise ValueError(wrong)
    path = folder / str(frame)
    try:
        data = path.read_bytes()
    except OSError as error:
        raise ValueError(f"its frame {path} cannot be read: {error.strerror}") from None
    decode_image(data, f"its frame {path}", side=32)  # small is fast, and damage shows as well
    return StepRecord(
        data,
        None if pose is None else (float(pose[0]), float(pose[1]), float(pose[2]), float(pose[3])),
        Step(
            Action(value["action"]),
            None if score is None else Detection(float(score), np.array(box)),
            np.array(value["probabilities"], float),
            value["found"],
        ),
        robot_moved,
        float(value["seconds"]),
    )
