"""What was drawn and is not in the scene file yet: an append-only file beside it.

`SCENE.labels.jsonl`: one JSON object a line. The first says which scene it belongs to: `format`
"active-perceiver-labels", `version` 1, `scene`, `content_hash` (of its views), `views` (how many), `targets` (their
names). Every other is one change: the number of a `view`, and all that is known of it since: its `label` and `boxes`,
see `ViewLabels`. The last line of a view holds, so replaying is reading. A line counts once it is on the disk; a
crash can only tear the last one, which nobody was told to be kept, and it is left out.
"""

from __future__ import annotations

import json
import os
from collections.abc import Collection
from pathlib import Path
from typing import Any

from active_perceiver.labelling.view_labels import LabelError, ViewLabels
from active_perceiver.scenes.scene import Scene
from active_perceiver.utils.files import flush_folder

try:
    import fcntl
except ImportError:  # Windows: two servers of one scene are not kept from each other there
    fcntl = None  # type: ignore[assignment]

FORMAT = "active-perceiver-labels"
VERSION = 1


class JournalError(LabelError):
    """A journal that belongs to another scene, is in use, is damaged or cannot be written."""


def journal_path(scene_file: Path) -> Path:
    """Where the changes of a scene are kept until they are in its file."""
    return scene_file.with_name(f"{scene_file.name}.labels.jsonl")


class Journal:
    """The changes of a scene that are not in its file yet.

    Attributes:
        path: of the file, which is there while the journal is open, and stays after `close` if it holds changes.
        changes: what is known of the views that were changed, by number.
    """

    def __init__(self, path: Path, scene: Scene) -> None:
        """Open a journal, and read what an earlier one left.

        Raises:
            JournalError: if another process has it open, it belongs to another scene, it is damaged other than at
                its end, or it cannot be written.
        """
        self.path = path
        self.changes: dict[int, ViewLabels] = {}
        self._header = _line(
            {
                "format": FORMAT,
                "version": VERSION,
                "scene": scene.name,
                "content_hash": scene.content_hash,
                "views": len(scene),
                "targets": list(scene.target_names),
            }
        )
        self._header_size = len(self._header)
        self._file = self._opened()
        try:
            sound = self._read(path.read_bytes(), scene)
            self._truncate(sound)
            if not sound:
                self._write(self._header)
                flush_folder(path.parent)
        except OSError as error:
            os.close(self._file)
            raise self._not_kept(error) from None
        except JournalError:
            os.close(self._file)
            raise

    def append(self, view: int, known: ViewLabels) -> None:
        """Keep a change; once this returns it is on the disk.

        Raises:
            JournalError: if it cannot be written; the journal is as it was.
        """
        before = os.fstat(self._file).st_size
        try:
            self._write(_line({"view": view, **known.as_json()}))
        except OSError as error:
            self._truncate(before)
            raise self._not_kept(error) from None
        self.changes[view] = known

    def clear(self) -> None:
        """Forget all changes: they are in the scene file."""
        self._truncate(self._header_size)
        self.changes.clear()

    def close(self) -> None:
        """Stop; the file is removed unless it holds changes."""
        if not self.changes:
            self.path.unlink(missing_ok=True)
        os.close(self._file)

    def _opened(self) -> int:
        """The file, locked against other processes."""
        while True:
            try:
                file = os.open(self.path, os.O_RDWR | os.O_CREAT | os.O_APPEND | getattr(os, "O_BINARY", 0), 0o666)
            except OSError as error:
                raise self._not_kept(error) from None
            if fcntl is None:
                return file
            try:
                fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
                if _is_at(file, self.path):
                    return file
                os.close(file)  # the one who had it removed it just now
            except OSError:
                os.close(file)
                raise JournalError(
                    f"{self.path} is in use: the scene is being labelled by another command; end that one first"
                ) from None

    def _read(self, data: bytes, scene: Scene) -> int:
        """Replay; the number of bytes, from the beginning, that are sound."""
        lines = data.splitlines(keepends=True)
        sound = 0
        for number, line in enumerate(lines):
            try:
                value = json.loads(line) if line.endswith(b"\n") else None
                if not isinstance(value, dict):
                    raise ValueError("is torn")
                if number == 0:
                    self._check_header(value)
                    self._header_size = len(line)
                else:
                    view, known = _change(value, len(scene), scene.target_names)
                    self.changes[view] = known
            except JournalError:
                raise
            except ValueError as error:  # LabelError and JSONDecodeError too
                if number < len(lines) - 1:
                    raise JournalError(
                        f"line {number + 1} of {self.path} is damaged ({error}); repair or delete that line, or move "
                        "the file away to do without all changes in it"
                    ) from None
                break
            sound += len(line)
        return sound

    def _check_header(self, header: dict[str, Any]) -> None:
        ours = json.loads(self._header)
        if header.get("format") != FORMAT or header.get("version") != VERSION:
            raise JournalError(f"{self.path} is no journal of labels of version {VERSION}; move it away")
        for field in ("content_hash", "views", "targets"):
            if header.get(field) != ours[field]:
                raise JournalError(
                    f"{self.path} belongs to another scene ('{header.get('scene')}', whose {field} differs): put "
                    "that scene back to save the changes into it, or move the journal away"
                )

    def _write(self, line: bytes) -> None:
        written = 0
        while written < len(line):
            written += os.write(self._file, line[written:])
        os.fsync(self._file)

    def _truncate(self, size: int) -> None:
        os.ftruncate(self._file, size)
        os.fsync(self._file)

    def _not_kept(self, error: OSError) -> JournalError:
        return JournalError(f"{self.path} cannot be written ({error.strerror}); nothing more is kept until it can be")


def _is_at(file: int, path: Path) -> bool:
    try:
        return os.path.samestat(os.fstat(file), path.stat())
    except FileNotFoundError:
        return False


def _line(value: dict[str, Any]) -> bytes:
    return json.dumps(value, separators=(",", ":")).encode() + b"\n"


def _change(value: dict[str, Any], views: int, targets: Collection[str]) -> tuple[int, ViewLabels]:
    view = value.pop("view", None)
    if type(view) is not int or not 0 <= view < views:
        raise LabelError(f"there is no view {view!r}; the scene has {views}")
    return view, ViewLabels.from_json(value, targets)
