"""Progress on anything that takes more than two seconds."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, contextmanager
from typing import Protocol

from rich.console import Console
from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn, TimeRemainingColumn


class ProgressCallback(Protocol):
    """Called by long work: how much of how much is done, and a word on how it goes."""

    def __call__(self, done: int, total: int, note: str = "") -> None:
        """Report progress."""


ProgressBar = Callable[[str], AbstractContextManager[ProgressCallback]]
"""Opens a bar with a label, and gives what is called as the work goes on; `progress_bar` is one."""

# Progress goes to standard error: standard output is for results. A log file has no width; lines get room there.
console = Console(stderr=True)
if not console.is_terminal:
    console = Console(stderr=True, width=120)


@contextmanager
def progress_bar(label: str) -> Iterator[ProgressCallback]:
    """Draw a progress bar with the time taken and left; one line stays when the block ends."""
    columns = (
        TextColumn(f"{label:<30}"),
        BarColumn(bar_width=28),
        TextColumn("{task.completed:>5.0f}/{task.total:<5.0f}"),
        TimeElapsedColumn(),
        TimeRemainingColumn(),
        TextColumn("{task.fields[note]}", style="dim"),
    )
    with Progress(*columns, console=console) as bar:
        task = bar.add_task(label, total=1, note="")
        reported = False

        def report(done: int, total: int, note: str = "") -> None:
            nonlocal reported
            reported = True
            bar.update(task, completed=done, total=total, note=note)

        yield report
        if not reported:
            bar.update(task, completed=1, note="nothing left to do")


def part_of(progress: ProgressCallback, before: int, total: int) -> ProgressCallback:
    """Progress of work that is a part of other work, `before` of whose `total` pieces are done when it begins."""
    return lambda done, _, note="": progress(before + done, total, note)


def quiet(done: int, total: int, note: str = "") -> None:
    """A report that nobody reads."""
