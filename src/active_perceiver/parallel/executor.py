"""Where pieces of work are done: one interface, and the simplest place, which is here and now."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from typing import Protocol, TypeVar

from active_perceiver.errors import UserError
from active_perceiver.utils.progress import ProgressCallback, quiet

Shared = TypeVar("Shared")
Item = TypeVar("Item")
Result = TypeVar("Result")


class WorkerError(UserError, RuntimeError):
    """Processes that cannot be started, or one that was killed."""


KILLED = "a process was killed, perhaps for want of memory; try again with --resume, or with fewer --workers"


class Executor(Protocol):
    """Something that does pieces of work, the same wherever it does them.

    Attributes:
        workers: how many it does at a time.
    """

    @property
    def workers(self) -> int:
        """See above."""

    def map(
        self,
        function: Callable[[Shared, Item], Result],
        items: Sequence[Item],
        shared: Shared,
        progress: ProgressCallback = quiet,
    ) -> Iterator[Result]:
        """Call `function(shared, item)` for each item.

        An error, Ctrl-C and closing the iterator end the work: what waits is never begun.

        Args:
            function: of a module, for it is found by name in other processes. It may `tell` how it goes.
            items: what differs; small.
            shared: what all pieces need; it is sent to each worker once, which may keep things in it from one item to
                the next.
            progress: told how many items are done, and what the present one tells where it can be heard.

        Returns:
            The results in the order of the items, as they are done.

        Raises:
            WorkerError: if a process was killed.
        """


class SerialExecutor:
    """Does one item after the other in this process."""

    workers = 1

    def map(
        self,
        function: Callable[[Shared, Item], Result],
        items: Sequence[Item],
        shared: Shared,
        progress: ProgressCallback = quiet,
    ) -> Iterator[Result]:
        """See `Executor.map`."""
        for number, item in enumerate(items):
            progress(number, len(items))
            with told_to(lambda note, done=number: progress(done, len(items), note)):  # type: ignore[misc]
                result = self.call(function, shared, item)
            progress(number + 1, len(items))
            yield result

    def call(self, function: Callable[[Shared, Item], Result], shared: Shared, item: Item) -> Result:
        """Do one item."""
        return function(shared, item)


_listener: Callable[[str], object] | None = None


def tell(note: str) -> None:
    """Say how the present item goes, to be shown beside the progress where the executor can."""
    if _listener is not None:
        _listener(note)


@contextmanager
def told_to(listener: Callable[[str], object]) -> Iterator[None]:
    """Let a listener hear what is told in the block."""
    global _listener
    before, _listener = _listener, listener
    try:
        yield
    finally:
        _listener = before


@contextmanager
def threads_of_children(threads: int) -> Iterator[None]:
    """Processes that are started in the block compute with so many threads.

    They share the cores between them; libraries that also start threads would only get in the way. NumPy and Open
    Image Denoise are told by environment variables when they are loaded.
    """
    names = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "OIDN_NUM_THREADS")
    values = {**dict.fromkeys(names, str(threads)), "OIDN_DEFAULT_DEVICE": "cpu"}
    before = {name: os.environ.get(name) for name in values}
    os.environ.update(values)
    try:
        yield
    finally:
        for name, value in before.items():
            if value is None:
                os.environ.pop(name, None)
            else:
                os.environ[name] = value
