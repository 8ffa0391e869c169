"""Executors: the same results in the same order wherever the work is done, and an end that leaves nothing running."""

from __future__ import annotations

import multiprocessing
import os
import signal
import time
from collections.abc import Callable
from pathlib import Path

import pytest

from active_perceiver.errors import UserError
from active_perceiver.parallel.executor import Executor, SerialExecutor, WorkerError, tell, threads_of_children
from active_perceiver.parallel.fresh_process import FreshProcessExecutor
from active_perceiver.parallel.process_pool import ProcessExecutor

PLACES: dict[str, Callable[[], Executor]] = {
    "here": SerialExecutor,
    "fresh processes": FreshProcessExecutor,
    "processes": lambda: ProcessExecutor(2),
}
places = pytest.mark.parametrize("place", PLACES)


class OddError(UserError):
    """What cannot be pickled."""

    def __init__(self, first: str, second: str) -> None:
        super().__init__(first + second)


def multiply(factor: int, item: int) -> int:
    tell(f"{item} times {factor}")
    if item == -1:
        os.kill(os.getpid(), signal.SIGKILL)
    if item == -2:
        raise UserError("no such number")
    if item == -3:
        raise OddError("neither even ", "nor odd")
    return factor * item


def remember(seen: list[int], item: int) -> tuple[int, int, str | None]:
    seen.append(item)
    return os.getpid(), len(seen), os.environ.get("OMP_NUM_THREADS")


def dawdle(folder: Path, item: int) -> int:
    (folder / f"{item}").touch()
    time.sleep(0.0 if item == 0 else 60.0)
    return item


@places
def test_results_come_in_order_and_all_are_reported(place: str) -> None:
    reports: list[tuple[int, int]] = []
    results = PLACES[place]().map(
        multiply, list(range(11)), 3, lambda done, total, note="": reports.append((done, total))
    )
    assert list(results) == [3 * number for number in range(11)]
    assert reports[-1] == (11, 11)
    assert [done for done, _ in reports] == sorted(done for done, _ in reports)
    assert list(PLACES[place]().map(multiply, [], 3)) == []


@places
def test_an_error_goes_through(place: str) -> None:
    results = PLACES[place]().map(multiply, [4, -2, 5], 3)
    assert next(results) == 12
    with pytest.raises(UserError, match="no such number"):
        next(results)


@pytest.mark.parametrize("place", ["fresh processes", "processes"])
def test_a_process_that_is_killed_is_reported(place: str) -> None:
    with pytest.raises(WorkerError, match="was killed"):
        list(PLACES[place]().map(multiply, [1, -1, 2], 3))


def test_an_error_that_cannot_be_sent_is_told(capfd: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(WorkerError, match="OddError: neither even nor odd"):
        list(FreshProcessExecutor().map(multiply, [-3], 3))


@pytest.mark.parametrize("place", ["here", "fresh processes"])
def test_what_an_item_tells_is_shown(place: str) -> None:
    notes: list[tuple[int, str]] = []
    list(PLACES[place]().map(multiply, [5, 6], 2, lambda done, total, note="": notes.append((done, note))))
    assert [told for told in notes if told[1]] == [(0, "5 times 2"), (1, "6 times 2")]
    tell("nobody listens")


def test_a_worker_keeps_what_is_shared_and_a_fresh_process_nothing() -> None:
    pool = list(ProcessExecutor(1).map(remember, [1, 2, 3], []))
    assert len({process for process, _, _ in pool}) == 1
    assert [count for _, count, _ in pool] == [1, 2, 3]
    assert {threads for _, _, threads in pool} == {"1"}
    fresh = list(FreshProcessExecutor(threads=2).map(remember, [1, 2], []))
    assert [(count, threads) for _, count, threads in fresh] == [(1, "2"), (1, "2")]
    assert fresh[0][0] != fresh[1][0]


def test_closing_stops_a_fresh_process_in_the_middle(tmp_path: Path) -> None:
    started = time.monotonic()

    def interrupt(done: int, total: int, note: str = "") -> None:
        if (done, note) == (1, "working"):
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        list(FreshProcessExecutor().map(work_on, [0, 1, 2], tmp_path, interrupt))
    assert time.monotonic() - started < 50
    assert not (tmp_path / "2").exists()
    assert (tmp_path / "cleaned up").exists()
    assert multiprocessing.active_children() == []


def work_on(folder: Path, item: int) -> int:
    try:
        tell("working")
        return dawdle(folder, item)
    finally:
        (folder / "cleaned up").touch()


def test_what_waits_is_dropped_when_the_iterator_is_closed(tmp_path: Path) -> None:
    results = ProcessExecutor(1).map(touch, list(range(200)), tmp_path)
    assert next(results) == 0
    results.close()  # type: ignore[attr-defined]
    assert len(list(tmp_path.iterdir())) < 100
    assert multiprocessing.active_children() == []


def touch(folder: Path, item: int) -> int:
    (folder / f"{item}").touch()
    time.sleep(0.02)
    return item


def test_the_environment_is_as_before(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("OMP_NUM_THREADS", "7")
    monkeypatch.delenv("MKL_NUM_THREADS", raising=False)
    with threads_of_children(3):
        assert (os.environ["OMP_NUM_THREADS"], os.environ["MKL_NUM_THREADS"]) == ("3", "3")
    assert os.environ["OMP_NUM_THREADS"] == "7"
    assert "MKL_NUM_THREADS" not in os.environ


def test_no_worker_is_too_few() -> None:
    with pytest.raises(WorkerError, match="at least 1, got 0"):
        ProcessExecutor(0)
