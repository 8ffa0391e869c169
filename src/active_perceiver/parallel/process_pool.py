"""Doing many pieces of work in parallel processes, in order, the same however many processes there are."""

from __future__ import annotations

import multiprocessing
import os
import signal
import threading
from collections import deque
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import Future, ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from multiprocessing.connection import wait
from typing import Any, TypeVar

from active_perceiver.errors import UserError
from active_perceiver.utils.progress import ProgressCallback

Job = TypeVar("Job")
Result = TypeVar("Result")

# The processes share the cores between them; libraries that also start threads would only get in the way.
_ONE_THREAD = {
    "OMP_NUM_THREADS": "1",
    "OPENBLAS_NUM_THREADS": "1",
    "MKL_NUM_THREADS": "1",
    "OIDN_NUM_THREADS": "1",
    "OIDN_DEFAULT_DEVICE": "cpu",
}
# So many jobs wait for each process: enough to keep it busy, few enough to need no memory.
QUEUE = 4
_shared: Any = None


class WorkerError(UserError, RuntimeError):
    """Processes that cannot be started, or one that was killed."""


def run_parallel(
    work: Callable[[Any, Job], Result],
    shared: Any,
    jobs: Sequence[Job],
    workers: int | None,
    progress: ProgressCallback,
) -> list[Result]:
    """Call `work(shared, job)` for each job.

    Args:
        work: a function of a module (it is found by name in the other processes).
        shared: what all jobs need; sent to each process once.
        jobs: what differs.
        workers: processes; None for one a core. They are spawned, never forked: Embree and Open Image Denoise
            hang in a forked process.
        progress: told after each job.

    Returns:
        The results in the order of the jobs.

    Raises:
        WorkerError: if a process was killed, or `workers` is less than 1.
    """
    count = workers if workers is not None else (os.cpu_count() or 1)
    if count < 1:
        raise WorkerError(f"the number of workers must be at least 1, got {workers}")
    context = multiprocessing.get_context("spawn")
    results: list[Result] = []
    running: deque[Future[Result]] = deque()
    with _environment(_ONE_THREAD):
        pool = ProcessPoolExecutor(min(count, max(len(jobs), 1)), context, _start, (shared,))
        try:
            for job in jobs:
                if len(running) == QUEUE * count:
                    results.append(running.popleft().result())
                    progress(len(results), len(jobs))
                running.append(pool.submit(_call, work, job))
            while running:
                results.append(running.popleft().result())
                progress(len(results), len(jobs))
        except BrokenProcessPool:
            raise WorkerError(
                "a rendering process was killed, perhaps for want of memory; try again with fewer --workers"
            ) from None
        finally:
            # After an error or Ctrl-C what waits is dropped and what runs (a second at most) is waited for.
            pool.shutdown(wait=True, cancel_futures=True)
    return results


def _start(shared: Any) -> None:
    global _shared
    _shared = shared
    # Ctrl-C reaches every process of a terminal; the parent decides what it means.
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    threading.Thread(target=_end_with_parent, daemon=True).start()


def _end_with_parent() -> None:
    """A parent that was killed cannot stop its workers; they would wait for work for ever."""
    parent = multiprocessing.parent_process()
    if parent is not None:
        wait([parent.sentinel])
        os._exit(1)


def _call(work: Callable[[Any, Job], Result], job: Job) -> Result:
    return work(_shared, job)


@contextmanager
def _environment(values: dict[str, str]) -> Iterator[None]:
    """Set environment variables for the processes started in the block."""
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
