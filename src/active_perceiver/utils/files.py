"""Writing files so that nothing a user made is lost: to a temporary name first, then renamed."""

from __future__ import annotations

import errno
import os
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from active_perceiver.errors import UserError


class OutputExistsError(UserError, FileExistsError):
    """What would be written is there already."""


class OutputError(UserError, OSError):
    """A place that cannot be written to. It is made of errno, what the system says, and the path."""

    def __str__(self) -> str:
        return (
            f"{self.filename} cannot be written ({self.strerror}); give another place, or make room, or the right to "
            "write, there"
        )


# What the system says of a disk that is full, whoever writes to it.
FULL = (errno.ENOSPC, errno.EDQUOT)


def check_output(path: Path, force: bool) -> None:
    """Make sure that a file or folder may be written, before time is spent on what is to be in it.

    Raises:
        OutputExistsError: if it exists and `force` is false.
    """
    if path.exists() and not force:
        raise OutputExistsError(f"{path} exists; give another name, or --force to replace it")


@contextmanager
def _telling(path: Path, *numbers: int) -> Iterator[None]:
    """Say which file it is that cannot be written, of errors with these numbers, or of all."""
    try:
        yield
    except OSError as error:
        if isinstance(error, UserError) or (numbers and error.errno not in numbers):
            raise
        raise OutputError(error.errno, error.strerror, str(path)) from error


@contextmanager
def replacing(path: Path, force: bool = True) -> Iterator[Path]:
    """A temporary path beside `path` that takes its place when the block ends well and vanishes when it does not.

    Args:
        path: the file to write; its folder is made.
        force: whether an existing file may be replaced.

    Raises:
        OutputExistsError: if `path` exists and `force` is false.
        OutputError: if it cannot be written there, or the disk is full.
    """
    check_output(path, force)
    with _telling(path):
        path.parent.mkdir(parents=True, exist_ok=True)
        handle, name = tempfile.mkstemp(prefix=f".{path.name}.", suffix=f".part{path.suffix}", dir=path.parent)
    os.close(handle)
    temporary = Path(name)
    try:
        with _telling(path, *FULL):
            yield temporary
        umask = os.umask(0)
        os.umask(umask)
        temporary.chmod(0o666 & ~umask)  # mkstemp makes files that only their owner may read
        with _telling(path):
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
        OutputError: if it cannot be written there, or the disk is full.
    """
    check_output(path, force)
    with _telling(path):
        path.parent.mkdir(parents=True, exist_ok=True)
        beside = tempfile.TemporaryDirectory(prefix=f".{path.name}.", suffix=".part", dir=path.parent)
    with beside as name:
        made = Path(name) / path.name
        made.mkdir()
        with _telling(path, *FULL):
            yield made
        if path.exists():
            path.rename(Path(name) / "replaced")
        made.rename(path)
