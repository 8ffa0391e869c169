"""Work spread over processes of this machine, in order, the same however many processes there are."""

from __future__ import annotations

import multiprocessing
import os
import signal
import threading
from collections import deque
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import Future, ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from multiprocessing.connection import wait
from typing import Any

from active_perceiver.parallel.executor import KILLED, Item, Result, Shared, WorkerError, threads_of_children
from active_perceiver.utils.progress import ProgressCallback, quiet

# So many items wait for each process: enough to keep it busy, few enough to need no memory.
QUEUE = 4
_shared: Any = None


class ProcessExecutor:
    """Spreads items over processes, each of which does one after the other, with one thread.

    They are spawned, never forked: Embree and Open Image Denoise hang in a forked process. What an item tells is not
    heard.

    Args:
        workers: processes; None for one a core.

    Raises:
        WorkerError: if `workers` is less than 1.
    """

    def __init__(self, workers: int | None = None) -> None:
        self.workers = workers if workers is not None else (os.cpu_count() or 1)
        if self.workers < 1:
            raise WorkerError(f"the number of workers must be at least 1, got {workers}")

    def map(
        self,
        function: Callable[[Shared, Item], Result],
        items: Sequence[Item],
        shared: Shared,
        progress: ProgressCallback = quiet,
    ) -> Iterator[Result]:
        """See `Executor.map`."""
        context = multiprocessing.get_context("spawn")
        running: deque[Future[Result]] = deque()
        ahead = QUEUE * self.workers
        with threads_of_children(1):
            pool = ProcessPoolExecutor(min(self.workers, max(len(items), 1)), context, _start, (shared,))
            try:
                for number in range(len(items)):
                    while len(running) < ahead and number + len(running) < len(items):
                        running.append(pool.submit(_call, function, items[number + len(running)]))
                    result = running.popleft().result()
                    progress(number + 1, len(items))
                    yield result
            except BrokenProcessPool:
                raise WorkerError(KILLED) from None
            finally:
                # After an error or Ctrl-C what waits is dropped and what runs (seconds at most) is waited for.
                pool.shutdown(wait=True, cancel_futures=True)


def _start(shared: Any) -> None:
    global _shared
    _shared = shared
    leave_to_parent()


def _call(function: Callable[[Any, Item], Result], item: Item) -> Result:
    return function(_shared, item)


def leave_to_parent() -> None:
    """Ctrl-C reaches every process of a terminal: the parent decides what it means, and ends this one with itself."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    threading.Thread(target=_end_with_parent, daemon=True).start()


def _end_with_parent() -> None:
    """A parent that was killed cannot stop its workers; they would wait for work for ever."""
    parent = multiprocessing.parent_process()
    if parent is not None:
        wait([parent.sentinel])
        os._exit(1)
