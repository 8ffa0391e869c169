"""Finished items of long work, on disk, so that they survive whatever interrupts it."""

from __future__ import annotations

import json
import shutil
import zipfile
import zlib
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
from numpy.typing import NDArray

from active_perceiver.errors import UserError
from active_perceiver.utils.files import OutputExistsError, replacing
from active_perceiver.version import __version__

SETTINGS = "settings.json"


class RunStoreError(UserError):
    """Finished work that does not fit what is asked for, or was removed while it was needed."""


class RunStore:
    """A folder with a file for each finished item: arrays or a record, there as a whole or not at all.

    Processes may share it: each file is written to a temporary name and renamed. Nothing in a file is executed when
    it is read. Items have names; those of the files are made of them.
    """

    def __init__(self, folder: Path) -> None:
        self.folder = folder

    @classmethod
    def begin(
        cls, folder: Path, settings: Mapping[str, Any], *, force: bool = False, resume: bool = False
    ) -> RunStore:
        """Make a folder, or go on with one that interrupted work left.

        Args:
            folder: where.
            settings: what the work follows from, as JSON can say it; a folder with others, or of another version of
                this software, is not gone on with.
            force: begin anew if there is interrupted work.
            resume: go on with it.

        Raises:
            OutputExistsError: if there is some and neither `force` nor `resume` says what to do, or if the folder
                holds something else.
            RunStoreError: if it was begun with other settings.
        """
        sign = folder / SETTINGS
        # As they are read again: JSON knows lists, but no tuples.
        wanted = json.loads(json.dumps({"version": __version__, **settings}))
        if sign.is_file():
            if not (force or resume):
                raise OutputExistsError(
                    f"{folder} is an interrupted run; --resume goes on with it, --force begins anew"
                )
            if resume and (other := _other_settings(sign, wanted)):
                raise RunStoreError(
                    f"{folder} was begun with other settings ({', '.join(other)}); give the same ones, or --force "
                    "without --resume to begin anew"
                )
        elif folder.exists() and (not folder.is_dir() or _foreign(folder)):
            raise OutputExistsError(f"{folder} is no interrupted run and will not be replaced; give another --out")
        if folder.exists() and not resume:
            shutil.rmtree(folder)
        if not sign.is_file():
            with replacing(sign) as temporary:
                temporary.write_text(json.dumps(wanted, indent=2) + "\n")
        return cls(folder)

    def save(self, name: str, **arrays: NDArray[Any]) -> None:
        """Keep an item's arrays."""
        with replacing(self.path(name, "npz")) as temporary, temporary.open("wb") as file:
            np.savez(file, **arrays)  # type: ignore[arg-type]  # numpy's stub takes the names for its own options

    def load(self, name: str) -> dict[str, NDArray[Any]] | None:
        """An item's arrays; None if they are not there, truncated or damaged, that is to be made (again)."""
        try:
            with np.load(self.path(name, "npz"), allow_pickle=False) as file:
                return {key: file[key] for key in file.files}
        except (OSError, ValueError, EOFError, KeyError, zipfile.BadZipFile, zlib.error):
            return None

    def loaded(self, name: str) -> dict[str, NDArray[Any]]:
        """An item's arrays, which were kept before.

        Raises:
            RunStoreError: if they are not there any more.
        """
        arrays = self.load(name)
        if arrays is None:
            path = self.path(name, "npz")
            raise RunStoreError(f"{path} was removed or damaged while it was needed; run it again with --resume")
        return arrays

    def keep(self, name: str, record: Mapping[str, Any]) -> None:
        """Keep an item's record, as JSON can say it."""
        with replacing(self.path(name, "json")) as temporary:
            temporary.write_text(json.dumps(record, indent=2) + "\n")

    def record(self, name: str) -> dict[str, Any] | None:
        """An item's record; None if it is not there, or damaged."""
        try:
            return json.loads(self.path(name, "json").read_text())
        except (OSError, ValueError):
            return None

    def missing(self, names: Iterable[str]) -> list[str]:
        """Those items that are to be done."""
        return [name for name in names if self.load(name) is None and self.record(name) is None]

    def remove(self) -> None:
        """Throw everything away."""
        shutil.rmtree(self.folder)

    def path(self, name: str, suffix: str) -> Path:
        """The file of an item, whether it is there or not."""
        return self.folder / f"{name.replace('/', '_')}.{suffix}"


def part_folder(out: Path) -> Path:
    """Where the finished items of work are kept whose result will be a file or folder `out`."""
    return out.with_name(f"{out.name}.part")


@contextmanager
def kept_beside(
    out: Path | None, settings: Mapping[str, Any], force: bool = False, resume: bool = False
) -> Iterator[RunStore]:
    """A store beside a result file, removed when the block, which writes the result, ends well.

    Without a result file nothing outlives the block. See `RunStore.begin` for the other arguments and for what is
    raised.

    Raises:
        RunStoreError: if `resume` is asked for without a result file.
    """
    if out is None:
        if resume:
            raise RunStoreError("--resume goes on with what is kept beside the result file; name it with --out")
        with TemporaryDirectory(prefix="active-perceiver-") as folder:
            yield RunStore(Path(folder))
        return
    store = RunStore.begin(part_folder(out), settings, force=force, resume=resume)
    yield store
    store.remove()


def _other_settings(sign: Path, wanted: Mapping[str, Any]) -> list[str]:
    """Names of the settings that are not those of a folder; all of them if its own cannot be read."""
    try:
        begun = json.loads(sign.read_text())
        return [name for name in wanted if begun.get(name) != wanted[name]] or sorted(begun.keys() - wanted.keys())
    except (ValueError, AttributeError):
        return list(wanted)


def _foreign(folder: Path) -> bool:
    """Whether a folder without settings holds more than what a run leaves that was killed while writing them."""
    return any(not path.name.startswith(f".{SETTINGS}.") for path in folder.iterdir())
