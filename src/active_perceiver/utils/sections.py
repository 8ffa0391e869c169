"""Named sections of work, so that whoever wants to know where the time goes can listen instead of patching.

Code that is worth timing says `with section("backward"):`. While nobody listens that is a look at an empty list.
"""

from __future__ import annotations

import time
from collections.abc import Iterator
from contextlib import AbstractContextManager, contextmanager, nullcontext
from typing import Protocol


class SectionListener(Protocol):
    """Called at the end of each section, also of one that an error ended."""

    def __call__(self, name: str, seconds: float) -> None:
        """Take in how long a section took."""


_listeners: list[SectionListener] = []
_UNHEARD = nullcontext()


def section(name: str) -> AbstractContextManager[None]:
    """Name the block's work to those who listen in this process."""
    return _timed(name) if _listeners else _UNHEARD


@contextmanager
def listening(listener: SectionListener) -> Iterator[None]:
    """Tell a listener of every section that ends within the block."""
    _listeners.append(listener)
    try:
        yield
    finally:
        _listeners.remove(listener)


@contextmanager
def _timed(name: str) -> Iterator[None]:
    started = time.perf_counter()
    try:
        yield
    finally:
        seconds = time.perf_counter() - started
        for listener in tuple(_listeners):
            listener(name, seconds)
