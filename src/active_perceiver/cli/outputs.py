"""Arguments that commands share: where to write what was measured."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path


@dataclass(kw_only=True)
class Outputs:
    """The files of a command that measures."""

    out: Path | None = None
    """Write the result here, as JSON."""
    picture: Path | None = None
    """Write a plot here, as PNG."""
    force: bool = False
    """Replace existing files."""
