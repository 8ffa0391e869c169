"""The figures in docs/scenes.md are those of the committed results, and hold what is promised."""

from __future__ import annotations

import json
import re
from pathlib import Path
from typing import Any

import pytest

ROOT = Path(__file__).parents[1]
PAGE = (ROOT / "docs" / "scenes.md").read_text()
RESULTS = sorted((ROOT / "benchmarks" / "scenes").glob("*.json"))


@pytest.fixture(params=RESULTS, ids=lambda path: path.stem)
def named(request: pytest.FixtureRequest) -> tuple[str, dict[str, Any]]:
    return request.param.stem.replace("four_rooms", "four rooms"), json.loads(request.param.read_text())


def test_there_is_a_result_for_each_scene() -> None:
    assert {path.stem for path in RESULTS} >= {"kitchen_1", "kitchen_2", "living_room_1", "living_room_2"}
    assert "conference_room" in {path.stem for path in RESULTS}


def test_the_page_says_what_was_measured(named: tuple[str, dict[str, Any]]) -> None:
    name, result = named
    section = PAGE[PAGE.index("## How well") :]
    row = re.search(rf"^\| {name} \|(.*)\|$", section, re.MULTILINE)
    assert row is not None
    metrics, word, seconds = result["recogniser"]["metrics"], result["own_word"], result["seconds"]
    expected = [f"{100 * result['overall']['success']:.1f} %", f"{result['overall']['ratio']:.3f}"]
    expected += [f"{metrics[p]['auroc']:.3f}, {metrics[p]['ap50']:.3f}" for p in ("seen pictures", "unseen pictures")]
    for pictures in ("pictures_seen", "pictures_unseen"):
        overall = word[pictures]["overall"]
        expected.append(f"{100 * overall['true_found']:.1f} %, {100 * overall['false_found']:.1f} %")
    expected.append(f"{seconds['recogniser']:.0f} s, {seconds['policy']:.0f} s")
    assert [cell.strip() for cell in row.group(1).split("|")] == expected


def test_every_scene_is_solved(named: tuple[str, dict[str, Any]]) -> None:
    _, result = named
    assert result["overall"]["success"] == 1.0
    assert result["overall"]["ratio"] <= 1.03
    for pictures in ("pictures_seen", "pictures_unseen"):
        overall = result["own_word"][pictures]["overall"]
        assert overall["true_found"] >= 0.95
        assert overall["false_found"] <= 0.02


def test_forty_rooms_of_each_layout_are_sound() -> None:
    result = json.loads((ROOT / "benchmarks" / "rooms.json").read_text())
    assert result["sound"] == len(result["rooms"]) == 120
    assert "120 of 120 rooms are sound" in PAGE


def test_the_page_says_what_a_recogniser_trained_elsewhere_is_worth() -> None:
    result = json.loads((ROOT / "benchmarks" / "elsewhere.json").read_text())
    text = " ".join(PAGE[PAGE.index("Such a recogniser") : PAGE.index("## What they are not")].split())
    assert result["settings"]["recogniser_scenes"] == ["elsewhere.h5"]
    there, here = result["recogniser"]["metrics"]["seen pictures"], result["detection"]["pictures_seen"]
    word, overall = result["own_word"]["pictures_seen"]["overall"], result["overall"]
    for said in (
        f"AUROC {there['auroc']:.3f}, AP50 {there['ap50']:.3f} on places of the other rooms",
        f"but {here['auroc']:.3f}, {here['ap50']:.3f} in the conference room",
        f"where {100 * here['false_positive_rate']:.1f} % of the views without a target",
        f"success {100 * overall['success']:.1f} %, {overall['ratio']:.3f} x the shortest path",
        f"{100 * word['true_found']:.1f} % true, {100 * word['false_found']:.1f} % false",
    ):
        assert said in text, said
