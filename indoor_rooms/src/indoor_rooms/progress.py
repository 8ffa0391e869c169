"""Progress of long work: any callable that takes what is done, and of how much."""

from __future__ import annotations

from typing import Protocol


class Progress(Protocol):
    """Called as work goes on."""

    def __call__(self, done: int, total: int, note: str = "") -> None:
        """Take in that `done` of `total` pieces are done."""


def quiet(done: int, total: int, note: str = "") -> None:
    """Progress that nobody watches."""
