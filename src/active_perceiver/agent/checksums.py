"""Checksums of an agent's folder: a copy that went wrong is noticed before the robot moves."""

from __future__ import annotations

import hashlib
import json
from pathlib import Path

from active_perceiver.agent.config import AgentError
from active_perceiver.utils.files import replacing
from active_perceiver.utils.json_reader import parse_json

CHECKSUMS_FILE = "checksums.json"


def write_checksums(folder: Path) -> None:
    """Note the SHA-256 of every file in a folder, in `CHECKSUMS_FILE`, atomically."""
    names = sorted(path.relative_to(folder).as_posix() for path in folder.rglob("*") if path.is_file())
    sums = {name: _sha256(folder / name) for name in names if name != CHECKSUMS_FILE}
    with replacing(folder / CHECKSUMS_FILE) as temporary:
        temporary.write_text(json.dumps({"sha256": sums}, indent=2) + "\n")


def check_files(folder: Path) -> None:
    """Make sure that every file is what it was when `write_checksums` noted it. Files that came later do not matter.

    A folder without `CHECKSUMS_FILE`, such as one that is being trained or was never exported, is not looked at.

    Raises:
        AgentError: if a file is missing or is another one, or the checksums cannot be read; the message names it.
    """
    path = folder / CHECKSUMS_FILE
    if not path.is_file():
        return
    try:
        sums = dict(parse_json(path.read_bytes())["sha256"])
    except (OSError, ValueError, TypeError, KeyError) as error:
        raise AgentError(f"{path} is damaged ({type(error).__name__}); copy or export the agent again") from None
    for name, expected in sums.items():
        try:
            given = _sha256(folder / name)
        except OSError as error:
            raise AgentError(
                f"{folder / name} cannot be read ({error.strerror}); copy or export the agent again"
            ) from None
        if given != expected:
            raise AgentError(
                f"{folder / name} is damaged: its checksum is not the one in {CHECKSUMS_FILE}; copy or export the "
                f"agent again, or delete {CHECKSUMS_FILE} if you changed the file yourself"
            )


def _sha256(path: Path) -> str:
    return hashlib.sha256(path.read_bytes()).hexdigest()
