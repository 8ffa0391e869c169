"""Finished work of a rendering in progress, on disk, so that it survives whatever interrupts it."""

from __future__ import annotations

import json
import shutil
import zipfile
import zlib
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from active_perceiver.capture.rendered.config import CaptureError
from active_perceiver.utils.files import OutputExistsError, replacing

SETTINGS = "settings.json"


class CaptureStore:
    """A folder with a file for each finished piece of work: named arrays, there as a whole or not at all.

    Processes may share it: each piece is written to a temporary name and renamed. Nothing in a file is executed when
    it is read.
    """

    def __init__(self, folder: Path) -> None:
        self.folder = folder

    @classmethod
    def begin(
        cls, folder: Path, noted: Mapping[str, Any], *, force: bool = False, resume: bool = False
    ) -> CaptureStore:
        """Make a folder, or go on with one that an interrupted rendering left.

        Args:
            folder: where.
            noted: what the work follows from, as plain data; a folder with other notes is not gone on with.
            force: begin anew if there is an interrupted rendering.
            resume: go on with it.

        Raises:
            OutputExistsError: if there is one and neither `force` nor `resume` says what to do, or if the folder
                holds something else.
            CaptureError: if it was begun with other settings.
        """
        sign, text = folder / SETTINGS, json.dumps(noted, indent=2) + "\n"
        if sign.is_file():
            if not (force or resume):
                raise OutputExistsError(
                    f"{folder} is an interrupted rendering; --resume goes on with it, --force begins anew"
                )
            if resume and sign.read_text(errors="replace") != text:
                raise CaptureError(
                    f"{folder} was begun with other settings or another version of this software; give the same "
                    "ones, or --force without --resume to begin anew"
                )
        elif folder.exists() and (not folder.is_dir() or _foreign(folder)):
            raise OutputExistsError(
                f"{folder} is no interrupted rendering and will not be replaced; give another --out"
            )
        if folder.exists() and not resume:
            shutil.rmtree(folder)
        if not sign.is_file():
            with replacing(sign) as temporary:
                temporary.write_text(text)
        return cls(folder)

    def save(self, key: str, **arrays: NDArray[Any]) -> None:
        """Keep a piece of work."""
        with replacing(self._path(key)) as temporary, temporary.open("wb") as file:
            np.savez(file, **arrays)  # type: ignore[arg-type]  # numpy's stub takes the names for its own options

    def load(self, key: str) -> dict[str, NDArray[Any]] | None:
        """A piece of work; None if it is not there, truncated or damaged, that is to be done (again)."""
        try:
            with np.load(self._path(key), allow_pickle=False) as file:
                return {name: file[name] for name in file.files}
        except (OSError, ValueError, EOFError, KeyError, zipfile.BadZipFile, zlib.error):
            return None

    def loaded(self, key: str) -> dict[str, NDArray[Any]]:
        """A piece of work that was finished before.

        Raises:
            CaptureError: if it is not there any more.
        """
        arrays = self.load(key)
        if arrays is None:
            raise CaptureError(
                f"{self._path(key)} was removed or damaged while it was needed; run it again with --resume"
            )
        return arrays

    def missing(self, keys: Sequence[str]) -> list[int]:
        """Numbers of those pieces that are to be done."""
        return [number for number, key in enumerate(keys) if self.load(key) is None]

    def remove(self) -> None:
        """Throw everything away."""
        shutil.rmtree(self.folder)

    def _path(self, key: str) -> Path:
        return self.folder / f"{key}.npz"


def _foreign(folder: Path) -> bool:
    """Whether a folder without notes holds more than what a rendering leaves that was killed while writing them."""
    return any(not path.name.startswith(f".{SETTINGS}.") for path in folder.iterdir())
