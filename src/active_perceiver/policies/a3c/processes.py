"""The workers of A3C as processes: started, listened to, and always stopped, whatever ends the training."""

from __future__ import annotations

import queue
import signal
import time
import traceback
from collections.abc import Generator, Sequence
from multiprocessing.sharedctypes import Synchronized
from typing import Any

import torch
from torch import multiprocessing

from active_perceiver.policies.a3c.worker import EpisodeWorker, SharedWeights

# Seconds between two looks at whether all workers are still alive, and until one that does not end is killed.
LOOK_EVERY = 1.0
PATIENCE = 10.0


class WorkerCrashError(RuntimeError):
    """A worker failed, or was killed; the message holds its traceback."""


def run_workers(
    workers: Sequence[EpisodeWorker], shared: SharedWeights, done: int, most: int
) -> Generator[tuple[int, int, int]]:
    """Let every worker live episodes in a process of its own.

    Yields after each episode the worker's number, the episode's steps and the number of updates so far.

    There may be more workers than cores. Closing the iterator, an error and Ctrl-C stop them all.

    Args:
        workers: are sent to their processes.
        shared: moved to shared memory.
        done: updates so far.
        most: updates in all.

    Raises:
        WorkerCrashError: if a worker failed or was killed; the others are stopped.
    """
    shared.share()
    # A server without threads is forked for each process: forking this one, which has torch's, could hang.
    methods = multiprocessing.get_all_start_methods()
    context: Any = multiprocessing.get_context("forkserver" if "forkserver" in methods else "spawn")
    if "forkserver" in methods:
        context.set_forkserver_preload([__name__])
    messages, stop = context.Queue(), context.Event()
    updates = context.Value("l", done)
    processes = [
        context.Process(
            target=_live, args=(worker, shared, updates, most, messages, stop), name=_name(worker), daemon=True
        )
        for worker in workers
    ]
    try:
        for process in processes:
            process.start()
        running = len(processes)
        looked = time.monotonic()
        while running:
            # The others may have more to say than there is time to listen.
            if time.monotonic() - looked > LOOK_EVERY:
                looked = time.monotonic()
                _check(processes)
            try:
                kind, *message = messages.get(timeout=LOOK_EVERY)
            except queue.Empty:
                continue
            if kind == "crash":
                raise WorkerCrashError(f"a worker of a3c failed; its own words:\n{message[0]}")
            if kind == "end":
                running -= 1
                continue
            number, steps = message
            # As of now, not of when the message was sent: with many workers they wait to be read.
            yield number, steps, updates.value
    finally:
        stop.set()
        _end(processes, messages)


def _name(worker: EpisodeWorker) -> str:
    return f"a3c-{worker.number}"


def _check(processes: Sequence[Any]) -> None:
    """Make sure that no worker was killed, which it could not say itself."""
    for process in processes:
        if process.exitcode:
            raise WorkerCrashError(
                f"the worker {process.name} was killed (exit code {process.exitcode}), perhaps for want of memory; "
                "go on with --resume, or train fewer targets at once"
            )


def _end(processes: Sequence[Any], messages: Any) -> None:
    """Wait for processes that were told to stop, kill those that do not."""
    for process in processes:
        if process.pid is None:
            continue
        process.join(PATIENCE)
        if process.is_alive():
            process.kill()
            process.join()
    messages.close()
    messages.cancel_join_thread()


def _live(
    worker: EpisodeWorker, shared: SharedWeights, updates: Synchronized[int], most: int, messages: Any, stop: Any
) -> None:
    # Ctrl-C reaches every process of a terminal; the parent decides what it means.
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    torch.set_num_threads(1)
    parent = multiprocessing.parent_process()
    try:
        # A worker whose parent was killed must not go on for ever.
        while not stop.is_set() and updates.value < most and (parent is None or parent.is_alive()):
            steps = worker.episode(shared, lambda: None if stop.is_set() else _next_update(updates, most))
            messages.put(("episode", worker.number, steps))
        messages.put(("end",))
    except BaseException:
        messages.put(("crash", traceback.format_exc()))


def _next_update(updates: Synchronized[int], most: int) -> int | None:
    """Number of the update that is due, from 0; None once there have been `most`."""
    with updates.get_lock():
        number = updates.value
        if number >= most:
            return None
        updates.value = number + 1
        return number
