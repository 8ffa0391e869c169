"""Writing files so that nothing a user made is lost: to a temporary name first, then renamed."""

from __future__ import annotations

import os
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from active_perceiver.errors import UserError


class OutputExistsError(UserError, FileExistsError):
    """What would be written is there already."""


@contextmanager
def replacing(path: Path, force: bool = True) -> Iterator[Path]:
    """A temporary path beside `path` that takes its place when the block ends well and vanishes when it does not.

    Args:
        path: the file to write; its folder is made.
        force: whether an existing file may be replaced.

    Raises:
        OutputExistsError: if `path` exists and `force` is false.
    """
    if path.exists() and not force:
        raise OutputExistsError(f"{path} exists; give another name, or --force to replace it")
    path.parent.mkdir(parents=True, exist_ok=True)
    handle, name = tempfile.mkstemp(prefix=f".{path.name}.", suffix=f".part{path.suffix}", dir=path.parent)
    os.close(handle)
    temporary = Path(name)
    try:
        yield temporary
        umask = os.umask(0)
        os.umask(umask)
        temporary.chmod(0o666 & ~umask)  # mkstemp makes files that only their owner may read
        temporary.replace(path)
    finally:
        temporary.unlink(missing_ok=True)


def flush_folder(folder: Path) -> None:
    """Make sure that the names of new files in a folder are on the disk."""
    try:
        file = os.open(folder, os.O_RDONLY)
    except OSError:  # a folder cannot be opened on Windows
        return
    try:
        os.fsync(file)
    finally:
        os.close(file)


@contextmanager
def replacing_folder(path: Path, force: bool = False) -> Iterator[Path]:
    """A temporary folder beside `path` that takes its place when the block ends well and vanishes when it does not.

    Args:
        path: the folder to write; the one it is in is made.
        force: whether an existing folder, with all that is in it, may be replaced.

    Raises:
        OutputExistsError: if `path` exists and `force` is false.
    """
    if path.exists() and not force:
        raise OutputExistsError(f"{path} exists; give another name, or --force to replace it")
    path.parent.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(prefix=f".{path.name}.", suffix=".part", dir=path.parent) as name:
        made = Path(name) / path.name
        made.mkdir()
        yield made
        if path.exists():
            path.rename(Path(name) / "replaced")
        made.rename(path)
