"""Preparing the next piece of work while this one is done."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from concurrent.futures import ThreadPoolExecutor
from itertools import islice
from typing import TypeVar

T = TypeVar("T")


def prefetch_batches(items: Iterable[T], size: int) -> Iterator[list[T]]:
    """Lists of up to `size` items in their order; the next list is made in a thread while one is used.

    What makes the items runs in one thread only, so draws of random numbers in it are the same as ever. An exception
    in it is raised here.

    Args:
        items: whatever is to be used in batches.
        size: of a batch.
    """
    source = iter(items)
    with ThreadPoolExecutor(1) as worker:
        following = worker.submit(lambda: list(islice(source, size)))
        while batch := following.result():
            following = worker.submit(lambda: list(islice(source, size)))
            yield batch
