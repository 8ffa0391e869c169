"""docs/reproduction.md shows the committed results, whole."""

import json
from pathlib import Path

import pytest

from active_perceiver.experiments.reproduction.setups import CHOICES, FULL, METHODS
from active_perceiver.experiments.reproduction.tables import (
    format_choices,
    format_recogniser,
    format_table_1,
    format_table_2,
)

ROOT = Path(__file__).parents[1]
PAGE = (ROOT / "docs" / "reproduction.md").read_text()
RESULTS = ROOT / "benchmarks" / "reproduction"


def result(name: str) -> dict:
    return json.loads((RESULTS / f"{name}.json").read_text())


def test_table_1_is_whole_and_on_the_page() -> None:
    table = result("table1")
    rows = {(row["setup"], row["method"], row["learner"]) for row in table["rows"]}
    setups = {setup for setup, _, _ in rows}
    learners = {method: ("a3c", "ppo") if METHODS[method].reward else (None,) for method in METHODS}
    assert rows == {(setup, method, name) for setup in setups for method in METHODS for name in learners[method]}
    for setup in FULL.setups.keys() - setups:
        assert f"**Not here yet:** {FULL.setups[setup].label}" in " ".join(PAGE.split()).replace(" in ", ", ")
    assert min(row["seeds"] for row in table["rows"]) >= 3
    assert table["protocol"]["boxes"] == "recogniser"
    assert (table["protocol"]["episodes"], table["protocol"]["limit"]) == (10, 5000)
    assert format_table_1(table["rows"], FULL) in PAGE
    assert format_recogniser(table["recogniser"]) in PAGE


def test_table_2_and_the_choices_are_on_the_page() -> None:
    assert format_table_2(result("table2")["rows"]) in PAGE
    choices = result("choices")["rows"]
    assert [row["choice"] for row in choices] == ["", *CHOICES]
    assert format_choices(choices) in PAGE


@pytest.mark.parametrize("name", ["curves", "entropy", "trajectories"])
def test_figures_have_numbers_and_pictures(name: str) -> None:
    assert result(name)["command"] == f"reproduce {name}"
    picture = ROOT / "docs" / "pictures" / f"reproduction_{name}.png"
    assert picture.read_bytes().startswith(b"\x89PNG")
    assert f"(pictures/{picture.name})" in PAGE


def test_every_row_comes_from_committed_trainings() -> None:
    """The tables are means of what is in `cells`."""
    cells = [json.loads(path.read_text()) for path in (RESULTS / "cells").glob("*.json")]
    for row in result("table1")["rows"]:
        keys = ("setup", "method", "learner")
        group = [cell for cell in cells if all(cell["cell"][key] == row[key] for key in keys)]
        success = [cell["exact"]["overall"]["success"] for cell in group if not cell["cell"].get("choice")]
        assert len(success) == row["seeds"]
        assert sum(success) / len(success) == pytest.approx(row["exact"]["success"]["mean"], rel=1e-4, abs=1e-5)


@pytest.mark.parametrize("path", sorted(RESULTS.glob("views_*.json")), ids=lambda path: path.stem)
def test_the_searches_for_views_are_on_the_page(path: Path) -> None:
    view, learner = json.loads(path.read_text()), path.stem.removeprefix("views_")
    overall = view["overall"]
    assert (view["settings"]["task"], view["settings"]["learner"]) == ("view", learner)
    figures = f"{overall['mean_steps']:.2f} | {overall['shortest_mean']:.2f} | {overall['ratio']:.3f}"
    assert f"| {learner} | {100 * overall['success']:.1f} % | {figures} |" in PAGE
