"""Items of long work by name: only what a store does not hold is done."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

from active_perceiver.parallel.executor import Executor, Item, Shared
from active_perceiver.parallel.run_store import RunStore
from active_perceiver.utils.progress import ProgressCallback, quiet


def run_missing(
    executor: Executor,
    store: RunStore,
    work: Callable[[Shared, tuple[str, Item]], None],
    items: Mapping[str, Item],
    shared: Shared,
    progress: ProgressCallback = quiet,
) -> None:
    """Do those items that the store does not hold; `work` puts them there itself, from wherever it is done.

    Args:
        executor: does them.
        store: where they are kept.
        work: given `shared`, and the name and the item.
        items: by name.
        shared: what all items need.
        progress: told how many of all items are done.
    """
    missing = store.missing(items)
    if missing:
        named = [(name, items[name]) for name in missing]
        for _ in executor.map(work, named, shared, _counted(progress, missing, len(items))):
            pass


def records_of(
    executor: Executor,
    store: RunStore,
    work: Callable[[Shared, Item], Mapping[str, Any]],
    items: Mapping[str, Item],
    shared: Shared,
    progress: ProgressCallback = quiet,
) -> dict[str, dict[str, Any]]:
    """The record of each item, by name; those that the store does not hold are made by `work`, and kept as they come.

    Arguments as of `run_missing`, but that `work` is given `shared` and the item, and returns the record.
    """
    missing = store.missing(items)
    results = executor.map(work, [items[name] for name in missing], shared, _counted(progress, missing, len(items)))
    for name, record in zip(missing, results, strict=True):
        store.keep(name, record)
    progress(len(items), len(items))
    return {name: store.record(name) or {} for name in items}


def _counted(progress: ProgressCallback, missing: Sequence[str], of: int) -> ProgressCallback:
    """Counts what was there as done, and says which item is next."""
    before = of - len(missing)

    def report(done: int, total: int, note: str = "") -> None:
        now = missing[done] if done < len(missing) else ""
        progress(before + done, of, f"{now}: {note}" if now and note else now or note)

    return report
