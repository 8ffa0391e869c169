"""An executor during whose work somebody presses Ctrl-C."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from typing import Any

from active_perceiver.parallel.executor import Executor
from active_perceiver.utils.progress import ProgressCallback, quiet


class InterruptedExecutor:
    """Another executor, interrupted before an item is done.

    Args:
        executor: does the items.
        at: the number of the item, counted from 1; 0 for never.

    Attributes:
        done: the items that were done.
    """

    workers = 1

    def __init__(self, executor: Executor, at: int) -> None:
        self._executor = executor
        self._at = at
        self.done: list[Any] = []

    def map(
        self,
        function: Callable[[Any, Any], Any],
        items: Sequence[Any],
        shared: Any,
        progress: ProgressCallback = quiet,
    ) -> Iterator[Any]:
        """See `Executor.map`."""
        for number, item in enumerate(items, 1):
            if number == self._at:
                raise KeyboardInterrupt
            yield from self._executor.map(function, [item], shared, progress)
            self.done.append(item)
