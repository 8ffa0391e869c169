"""Names of temporary files that say which process makes them, so that those of killed ones are found and removed."""

from __future__ import annotations

import functools
import hashlib
import os
import re
import shutil
import socket
from contextlib import suppress
from pathlib import Path

_NAME = re.compile(r"\..*\.ap-(?P<place>[0-9a-f]{8})-(?P<pid>\d+)-(?P<start>\d+)-[^./]+\.part(\.[^./]*)?")
REPLACED = ".replaced"
"""Where in a temporary folder the folder is kept that it replaces."""
# Folders are looked through once by a process: a cache may hold many thousand files, each of them written by itself.
_looked_through: set[Path] = set()


def temporary_prefix(path: Path) -> str:
    """How the name of a temporary file or folder begins that is to become `path`; `.part` and a suffix end it."""
    pid = os.getpid()
    return f".{path.name[:40]}.ap-{_place()}-{pid}-{_start(pid) or 0}-"


def remove_stale(folder: Path) -> None:
    """Remove what processes left behind in a folder that are no longer there, once per folder.

    A folder that was complete when its process ended takes its place if that is free.
    """
    key = folder.absolute()
    if key in _looked_through:
        return
    _looked_through.add(key)
    with suppress(OSError):
        for entry in list(os.scandir(folder)):
            found = _NAME.fullmatch(entry.name)
            if found and found["place"] == _place() and _start(int(found["pid"])) != int(found["start"]):
                with suppress(OSError):
                    _remove(Path(entry.path))


def _remove(stale: Path) -> None:
    if stale.is_symlink() or not stale.is_dir():
        stale.unlink()
        return
    # Killed between moving the old folder aside and the new one into its place: the new one is complete.
    if (stale / REPLACED).exists():
        for made in stale.iterdir():
            path = stale.parent / made.name
            if made.name != REPLACED and not path.exists():
                made.rename(path)
    shutil.rmtree(stale)


@functools.cache
def _place() -> str:
    """Where the numbers of processes count: a computer, or a container on it."""
    parts = [socket.gethostname()]
    with suppress(OSError):
        parts.append(str(Path("/proc/self/ns/pid").readlink()))
    return hashlib.sha256("\n".join(parts).encode()).hexdigest()[:8]


def _start(pid: int) -> int | None:
    """When a process was started, in ticks; 0 if the system does not tell, None if there is no such process."""
    try:
        # The name of the program, in brackets, may hold spaces and brackets itself.
        return int(Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[19])
    except (OSError, ValueError, IndexError):
        pass
    if Path("/proc/self/stat").exists():
        return None
    if os.name != "posix":  # Windows ends a process that is asked whether it is there
        return 0
    try:
        os.kill(pid, 0)
    except ProcessLookupError:
        return None
    except OSError:
        pass
    return 0
