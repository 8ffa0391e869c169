"""What the committed results promise: a worse one is not committed unnoticed."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

BENCHMARKS = Path(__file__).parents[1] / "benchmarks"
SCENES = sorted((BENCHMARKS / "scenes").glob("*.json"))
KINDS = ("pictures_seen", "pictures_unseen")


def result(name: str) -> Any:
    return json.loads((BENCHMARKS / f"{name}.json").read_text())


def test_the_demo_is_as_good_and_as_fast_as_it_set_out_to_be():
    demo = result("demo")
    assert demo["overall"]["success"] == 1.0
    assert demo["overall"]["ratio"] <= 1.02
    assert demo["seconds"]["policy"] <= 15
    assert demo["seconds"]["recogniser"] <= 240
    assert demo["seconds"]["demo"] <= 360
    for pictures, auroc, ap50 in (("seen pictures", 0.997, 0.93), ("unseen pictures", 0.994, 0.91)):
        metrics = demo["recogniser"]["matching"]["metrics"][pictures]
        assert metrics["auroc"] >= auroc
        assert metrics["ap50"] >= ap50
        assert metrics["false_positive_rate"] < 0.01
    for found in (row for kind in KINDS for row in demo["stop_evaluation"][kind]["per_target"]):
        assert found["true_found"] >= 0.95
        assert found["false_found"] <= 0.02


@pytest.mark.parametrize("path", SCENES, ids=lambda path: path.stem)
def test_every_scene_is_solved(path):
    body = json.loads(path.read_text())
    assert body["overall"]["success"] == 1.0
    assert body["overall"]["ratio"] <= 1.03
    for kind in KINDS:
        assert body["stop_evaluation"][kind]["overall"]["true_found"] >= 0.95
        assert body["stop_evaluation"][kind]["overall"]["false_found"] <= 0.02


def test_every_generated_room_is_sound():
    rooms = result("rooms")
    assert rooms["sound"] == len(rooms["rooms"]) == 120


def test_one_action_takes_ten_milliseconds_on_one_core():
    (action,) = (
        one for one in result("act")["actions"] if (one["backbone"], one["threads"]) == ("efficientnet_lite0", 1)
    )
    assert action["ms"]["whole"]["median"] <= 11.0


def test_rows_of_table_1_are_means_of_committed_trainings():
    cells = [json.loads(path.read_text()) for path in (BENCHMARKS / "reproduction" / "cells").glob("*.json")]
    rows = result("reproduction/table1")["rows"]
    assert rows
    for row in rows:
        assert row["seeds"] >= 3
        keys = ("setup", "method", "learner")
        group = [cell for cell in cells if all(cell["cell"][key] == row[key] for key in keys)]
        success = [cell["exact"]["overall"]["success"] for cell in group if not cell["cell"].get("choice")]
        assert len(success) == row["seeds"]
        assert sum(success) / len(success) == pytest.approx(row["exact"]["success"]["mean"], rel=1e-4, abs=1e-5)
