"""A fresh process for each item, one after the other: for measuring what nothing before it has warmed up or used."""

from __future__ import annotations

import multiprocessing
import pickle
import signal
import sys
import traceback
from collections.abc import Callable
from multiprocessing.connection import Connection
from typing import Any

from active_perceiver.errors import UserError
from active_perceiver.parallel.executor import (
    KILLED,
    Item,
    Result,
    SerialExecutor,
    Shared,
    WorkerError,
    tell,
    threads_of_children,
    told_to,
)
from active_perceiver.parallel.process_pool import leave_to_parent

# Seconds that a process which is stopped has to clean up before it is killed.
PATIENCE = 10.0


class FreshProcessExecutor(SerialExecutor):
    """Does one item after the other, each in a process of its own.

    Args:
        threads: CPU threads of the libraries in it.
    """

    def __init__(self, threads: int = 1) -> None:
        self.threads = threads

    def call(self, function: Callable[[Shared, Item], Result], shared: Shared, item: Item) -> Result:
        """Call the function in a new process, which is ended whatever happens."""
        context = multiprocessing.get_context("spawn")
        here, there = context.Pipe(duplex=False)
        process = context.Process(target=_work, args=(there, function, shared, item))
        with threads_of_children(self.threads):
            process.start()
        there.close()
        try:
            while True:
                kind, content = here.recv()
                if kind == "result":
                    return content
                if kind == "error":
                    raise content
                tell(content)
        except EOFError:
            raise WorkerError(KILLED) from None
        finally:
            process.terminate()
            process.join(PATIENCE)
            process.kill()
            process.join()
            here.close()


def _work(parent: Connection, function: Callable[[Any, Any], Any], shared: Any, item: Any) -> None:
    leave_to_parent()
    # Whatever the item has begun, such as processes of its own, it may end.
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(1))
    try:
        with told_to(lambda note: parent.send(("note", note))):
            result = function(shared, item)
        parent.send(("result", result))
    except Exception as error:
        if not isinstance(error, UserError):
            traceback.print_exc()  # what the parent raises knows only its own lines
        parent.send(("error", _sendable(error)))


def _sendable(error: Exception) -> Exception:
    try:
        pickle.loads(pickle.dumps(error))
    except Exception:
        return WorkerError(f"{type(error).__name__}: {error}")
    return error
