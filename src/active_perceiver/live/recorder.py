"""A search kept on the disk as it goes: a folder that can be read whenever the search, or the machine, stopped.

A recording is a folder of

- `recording.json`: `format` "active-perceiver-recording", `version` 1, and what the search was asked to do, see
  `RecordingHeader`; written once, at the start;
- `picture.png`: what was searched;
- `frames/00000.jpg` and so on: what the robot saw at each look. Images that the robot gives encoded are kept as they
  are (`.jpg`, `.png` or `.webp`), others become JPEGs of quality 92;
- `steps.jsonl`: a JSON object a line. One for each look, written once its frame is on the disk and before the robot
  moves on: `look` (0, 1, ...), `frame` (the file's name) and what `step_json` gives. Then one that says how it
  ended: `ended` true, `found`, `reason` ("found", "max steps", "max minutes", "interrupted" or "error: ..."),
  `seconds`. It is not there if the process was killed, and then the last line may be torn; it is left out.
"""

from __future__ import annotations

import json
import os
import re
import time
from pathlib import Path
from types import TracebackType
from typing import Any

import numpy as np
from numpy.typing import NDArray
from typing_extensions import Self

from active_perceiver.errors import UserError
from active_perceiver.live import SearchRecord, StepRecord
from active_perceiver.live.recording_header import RecordingHeader
from active_perceiver.scenes import ImageError, decode_image
from active_perceiver.scenes.images import encode_image, image_suffix
from active_perceiver.utils.files import OutputExistsError, flush_folder, replacing
from active_perceiver.utils.json_reader import parse_json

FORMAT = "active-perceiver-recording"
VERSION = 1
QUALITY = 92
HEADER, PICTURE, FRAMES, STEPS = "recording.json", "picture.png", "frames", "steps.jsonl"

INTERRUPTED, CUT_OFF = "interrupted", "cut off: the search was killed, or is still going on"

FRAME_NAME = re.compile(r"\d{5,}\.(jpg|png|webp)")


class RecordingError(UserError, ValueError):
    """A recording that cannot be written or read; the message names the file, and the line if it is one."""


def step_json(step_record: StepRecord) -> dict[str, Any]:
    """What is written down of a look: plain data without its image."""
    detection = step_record.step.detection
    return {
        "seconds": round(step_record.seconds, 4),
        "pose": None if step_record.pose is None else [float(value) for value in step_record.pose],
        "moved": None if step_record.robot_moved is None else bool(step_record.robot_moved),
        "action": step_record.step.action.value,
        "found": bool(step_record.step.found),
        "score": None if detection is None else float(detection.score),
        "box": None if detection is None else detection.box.tolist(),
        "probabilities": step_record.step.probabilities.tolist(),
    }


def check_folder(folder: Path, force: bool) -> None:
    """Make sure that a recording may be written into a folder.

    Args:
        folder: need not exist.
        force: whether a recording that is there may be replaced.

    Raises:
        OutputExistsError: if it holds something else, or a recording that may not be replaced.
    """
    if not folder.exists() or (folder.is_dir() and not any(folder.iterdir())):
        return
    if not folder.is_dir():
        raise OutputExistsError(f"{folder} is a file; a recording is a folder: give another name")
    if not force:
        raise OutputExistsError(f"{folder} is not empty; give another name, or --force to replace a recording there")
    if header_of(folder / HEADER) is None:
        raise OutputExistsError(
            f"{folder} is not empty and holds no recording, and --force replaces nothing else; give another name"
        )


def header_of(path: Path) -> dict[str, Any] | None:
    """The content of a `recording.json`; None if it is not there or something else."""
    try:
        header = parse_json(path.read_bytes())
    except (OSError, ValueError):
        return None
    return header if isinstance(header, dict) and header.get("format") == FORMAT else None


def _remove_recording(folder: Path) -> None:
    """Remove the files that a recording consists of and nothing else; last what makes it one."""
    frames = folder / FRAMES
    if frames.is_dir() and not frames.is_symlink():
        for path in frames.iterdir():
            if FRAME_NAME.fullmatch(path.name):
                path.unlink()
        if not any(frames.iterdir()):
            frames.rmdir()
    for name in (STEPS, PICTURE, HEADER):
        (folder / name).unlink(missing_ok=True)


class Recorder:
    """Keeps a search as it goes. Left as a context manager by an exception, it notes that.

    Args:
        folder: made if it is not there.
        setup: what the search is asked to do.
        picture: (H, W, 3) uint8 RGB, what is searched.
        force: replace a recording that is there.

    Attributes:
        folder: the recording.
        looks: how many are kept.

    Raises:
        OutputExistsError: if the folder is not empty and may not be replaced.
        RecordingError: if it cannot be written.
    """

    def __init__(
        self, folder: Path, setup: RecordingHeader, picture: NDArray[np.uint8], *, force: bool = False
    ) -> None:
        check_folder(folder, force)
        self.folder = folder
        self._started = time.monotonic()
        self.looks, self._sound = 0, 0
        self._found = self._ended = False
        header = {"format": FORMAT, "version": VERSION, **setup.as_json()}
        try:
            if folder.exists():
                _remove_recording(folder)
            (folder / FRAMES).mkdir(parents=True, exist_ok=True)
            _write_through(folder / PICTURE, encode_image(picture, "png"))
            with replacing(folder / HEADER) as temporary:
                _write_through(temporary, json.dumps(header, indent=2, allow_nan=False).encode() + b"\n")
            self._steps = os.open(
                folder / STEPS, os.O_WRONLY | os.O_CREAT | os.O_APPEND | getattr(os, "O_BINARY", 0), 0o666
            )
            flush_folder(folder)
        except OSError as error:
            raise self._not_kept(error) from None

    def keep(self, step_record: StepRecord) -> None:
        """Keep a look; once this returns it is on the disk.

        Raises:
            RecordingError: if it cannot be written.
        """
        data, suffix = _encoded(step_record.frame)
        name = f"{self.looks:05}.{suffix}"
        try:
            _write_through(self.folder / FRAMES / name, data)
            flush_folder(self.folder / FRAMES)
            self._write({"look": self.looks, "frame": f"{FRAMES}/{name}", **step_json(step_record)})
        except OSError as error:
            raise self._not_kept(error) from None
        self.looks += 1
        self._found = self._found or step_record.step.found

    def end(self, record: SearchRecord) -> None:
        """Note how the search ended.

        Raises:
            RecordingError: if it cannot be written.
        """
        self._end(record.found, record.reason, record.seconds)

    def _end(self, found: bool, reason: str, seconds: float) -> None:
        self._ended = True
        try:
            self._write({"ended": True, "found": bool(found), "reason": reason, "seconds": round(seconds, 4)})
        except OSError as error:
            raise self._not_kept(error) from None

    def _write(self, value: dict[str, Any]) -> None:
        # What an interrupt, or a full disk, left of a line must not stay before the next one.
        os.ftruncate(self._steps, self._sound)
        line = json.dumps(value, separators=(",", ":"), allow_nan=False).encode() + b"\n"
        written = 0
        while written < len(line):
            written += os.write(self._steps, line[written:])
        os.fsync(self._steps)
        self._sound += len(line)

    def _not_kept(self, error: OSError) -> RecordingError:
        return RecordingError(f"the recording in {self.folder} cannot be written: {error.strerror}")

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        try:
            if error is not None and not self._ended:
                self._end(self._found, _reason_of(error), time.monotonic() - self._started)
        except RecordingError:
            if not isinstance(error, RecordingError):
                raise
        finally:
            os.close(self._steps)


def _reason_of(error: BaseException) -> str:
    if isinstance(error, KeyboardInterrupt):
        return INTERRUPTED
    text = str(error) if isinstance(error, UserError) else f"{type(error).__name__} {error}"
    return f"error: {text.strip()}"


def _encoded(frame: NDArray[np.uint8] | bytes) -> tuple[bytes, str]:
    """An image as it is kept, and the suffix of its file."""
    if isinstance(frame, bytes):
        try:
            return frame, image_suffix(frame)
        except ImageError:  # a kind of image that the agent can read, but not everybody
            frame = decode_image(frame, "the robot's image")
    return encode_image(frame, "jpeg", QUALITY), "jpg"


def _write_through(path: Path, data: bytes) -> None:
    """Write a file; once this returns it is on the disk."""
    with path.open("wb") as file:
        file.write(data)
        file.flush()
        os.fsync(file.fileno())
