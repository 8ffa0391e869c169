"""The store of finished items: whole or not there, gone on with under the same settings only."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from active_perceiver.parallel.executor import SerialExecutor
from active_perceiver.parallel.run_missing import records_of, run_missing
from active_perceiver.parallel.run_store import RunStore, RunStoreError, kept_beside, part_folder
from active_perceiver.utils.files import OutputExistsError
from active_perceiver.version import __version__

SETTINGS = {"seeds": 2, "learners": ("distil",)}


def content(folder: Path) -> dict[str, bytes]:
    return {str(path.relative_to(folder)): path.read_bytes() for path in folder.rglob("*") if path.is_file()}


def test_interrupted_work_is_neither_lost_nor_mixed(tmp_path: Path) -> None:
    folder = tmp_path / "out.part"
    RunStore.begin(folder, SETTINGS).keep("first", {"seed": 0})
    before = content(folder)
    with pytest.raises(OutputExistsError, match=r"--resume .* --force"):
        RunStore.begin(folder, SETTINGS)
    for other in ({**SETTINGS, "seeds": 3}, {**SETTINGS, "scenes": 1}, {"learners": ["distil"]}):
        with pytest.raises(RunStoreError, match=r"other settings \((seeds|scenes)\)"):
            RunStore.begin(folder, other, resume=True)
    assert content(folder) == before
    again = RunStore.begin(folder, SETTINGS, resume=True)
    assert again.record("first") == {"seed": 0}
    assert RunStore.begin(folder, {"seeds": 3}, force=True).missing(["first"]) == ["first"]
    again.remove()
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("text", ["{", "[]", "3", ""])
def test_damaged_settings_are_other_ones(text: str, tmp_path: Path) -> None:
    RunStore.begin(tmp_path / "x", SETTINGS)
    (tmp_path / "x" / "settings.json").write_text(text)
    with pytest.raises(RunStoreError, match="other settings"):
        RunStore.begin(tmp_path / "x", SETTINGS, resume=True)


def test_a_run_that_was_killed_while_it_noted_its_settings_is_begun_anew(tmp_path: Path) -> None:
    (tmp_path / "x").mkdir()
    (tmp_path / "x" / ".settings.json.xyz.part.json").write_text("{")
    store = RunStore.begin(tmp_path / "x", {"seed": 1})
    assert json.loads((store.folder / "settings.json").read_text()) == {"version": __version__, "seed": 1}


def test_what_is_no_run_is_not_touched(tmp_path: Path) -> None:
    (tmp_path / "folder").mkdir()
    (tmp_path / "folder" / "diary.txt").write_text("dear diary")
    (tmp_path / "file").write_text("a run of before")
    before = content(tmp_path)
    for name in ("folder", "file"):
        for options in ({}, {"force": True}, {"resume": True}):
            with pytest.raises(OutputExistsError, match="will not be replaced"):
                RunStore.begin(tmp_path / name, SETTINGS, **options)
    assert content(tmp_path) == before


def test_items_are_whole_or_not_there(tmp_path: Path) -> None:
    store = RunStore(tmp_path / "store")
    store.save("one", image=np.arange(5, dtype=np.uint8), exposure=np.asarray(0.5))
    np.testing.assert_array_equal(store.loaded("one")["image"], np.arange(5))
    assert store.loaded("one")["exposure"] == 0.5
    store.keep("kitchen/mug, seed 1", {"success": 1.0, "ratio": None})
    assert store.record("kitchen/mug, seed 1") == {"success": 1.0, "ratio": None}
    np.savez(store.folder / "two.npz", evil=np.array([print], object))
    store.path("four", "json").write_text('{"success": 1.')
    names = ["two", "one", "three", "four", "kitchen/mug, seed 1"]
    assert store.missing(names) == ["two", "three", "four"]  # nothing is unpickled
    with pytest.raises(RunStoreError, match="--resume"):
        store.loaded("three")


def test_the_store_beside_a_result_goes_when_all_is_done(tmp_path: Path) -> None:
    out = tmp_path / "result.json"
    with pytest.raises(KeyboardInterrupt), kept_beside(out, SETTINGS) as store:
        square([], 3)
    assert store.folder == part_folder(out)
    store.keep("one", {"seed": 0})
    with kept_beside(out, SETTINGS, resume=True) as store:
        assert store.record("one") == {"seed": 0}
    with kept_beside(None, SETTINGS) as store:
        store.keep("one", {"seed": 0})
    assert not store.folder.exists()
    assert list(tmp_path.iterdir()) == []
    with pytest.raises(RunStoreError, match="name it with --out"), kept_beside(None, SETTINGS, resume=True):
        pass


def square(done: list[int], item: int) -> dict[str, Any]:
    done.append(item)
    if item == 3 and done.count(3) == 1:
        raise KeyboardInterrupt
    return {"square": item**2, "root": item**0.5}


def test_only_missing_items_are_done_and_each_is_kept_as_it_comes(tmp_path: Path) -> None:
    store, done, items = RunStore(tmp_path / "x"), [], {f"item {number}": number for number in (2, 3, 4)}
    with pytest.raises(KeyboardInterrupt):
        records_of(SerialExecutor(), store, square, items, done)
    reports: list[tuple[int, int, str]] = []
    records = records_of(SerialExecutor(), store, square, items, done, lambda *call: reports.append(call))
    assert done == [2, 3, 3, 4]
    assert list(records) == list(items)
    assert records["item 3"] == {"square": 9, "root": 3**0.5}
    assert (1, 3, "item 3") in reports
    assert reports[-1][:2] == (3, 3)


def put(store: RunStore, item: tuple[str, int]) -> None:
    store.save(item[0], value=np.asarray(item[1]))


def test_work_that_keeps_its_own_items_is_done_once(tmp_path: Path) -> None:
    store = RunStore(tmp_path / "x")
    put(store, ("a", 7))
    run_missing(SerialExecutor(), store, put, {"a": 1, "b": 2}, store)
    assert [int(store.loaded(name)["value"]) for name in "ab"] == [7, 2]
