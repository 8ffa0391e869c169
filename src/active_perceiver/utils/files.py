"""Writing files so that nothing a user made is lost: to a temporary name, onto the disk, and only then renamed.

Without the second step a power cut can leave an empty file under the right name: some file systems write names first.
"""

from __future__ import annotations

import errno
import os
import tempfile
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

from active_perceiver.errors import UserError
from active_perceiver.utils.temporaries import REPLACED, remove_stale, temporary_prefix


class OutputExistsError(UserError, FileExistsError):
    """What would be written is there already."""


class OutputError(UserError, OSError):
    """A place that cannot be written to. It is made of errno, what the system says, and the path."""

    def __str__(self) -> str:
        return (
            f"{self.filename} cannot be written ({self.strerror}); give another place, or make room, or the right to "
            "write, there"
        )


# What the system says of disks that have no such thing as flushing, as some network disks.
NO_FLUSHING = (errno.EINVAL, errno.ENOTSUP)
# What the system says of a disk that is full, whoever writes to it.
FULL = (errno.ENOSPC, errno.EDQUOT)


def check_output(path: Path, force: bool) -> None:
    """Make sure that a file or folder may be written, before time is spent on what is to be in it.

    Raises:
        OutputExistsError: if it exists and `force` is false.
    """
    if path.exists() and not force:
        raise OutputExistsError(f"{path} exists; give another name, or --force to replace it")


def files_there(files: Sequence[Path], *, force: bool, resume: bool) -> list[Path]:
    """Which of many files that are to be written are there already.

    Raises:
        OutputExistsError: if any is, and nothing says what to do with it.
    """
    there = [path for path in files if path.exists()]
    if there and not (force or resume):
        raise OutputExistsError(
            f"{', '.join(str(path) for path in there[:5])} exist(s); --resume keeps what is there and makes the "
            "rest, --force replaces it"
        )
    return there


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
        remove_stale(path.parent)
        handle, name = tempfile.mkstemp(prefix=temporary_prefix(path), suffix=f".part{path.suffix}", dir=path.parent)
    os.close(handle)
    temporary = Path(name)
    try:
        with _telling(path, *FULL):
            yield temporary
        umask = os.umask(0)
        os.umask(umask)
        temporary.chmod(0o666 & ~umask)  # mkstemp makes files that only their owner may read
        with _telling(path):
            flush(temporary)
            temporary.replace(path)
            flush_folder(path.parent)
    finally:
        temporary.unlink(missing_ok=True)


def flush(path: Path) -> None:
    """Make sure that what was written to a file is on the disk."""
    _flush(path, os.O_RDWR)


def flush_folder(folder: Path) -> None:
    """Make sure that the names of new files in a folder are on the disk."""
    if os.name == "posix":  # a folder cannot be opened on Windows
        _flush(folder, os.O_RDONLY)


def _flush(path: Path, way: int) -> None:
    file = os.open(path, way)
    try:
        os.fsync(file)
    except OSError as error:
        if error.errno not in NO_FLUSHING:
            raise
    finally:
        os.close(file)


def _flush_tree(folder: Path) -> None:
    """The same for all files in a folder and below it, and their names."""
    for place, _, names in os.walk(folder):
        for name in names:
            if not (Path(place) / name).is_symlink():
                flush(Path(place) / name)
        flush_folder(Path(place))


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
        remove_stale(path.parent)
        beside = tempfile.TemporaryDirectory(prefix=temporary_prefix(path), suffix=".part", dir=path.parent)
    with beside as name:
        made = Path(name) / path.name
        made.mkdir()
        with _telling(path, *FULL):
            yield made
            _flush_tree(made)
        if path.exists():
            path.rename(Path(name) / REPLACED)
        made.rename(path)
        flush_folder(path.parent)
