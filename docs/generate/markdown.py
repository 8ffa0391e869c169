"""Result files, and what numbers and tables look like in Markdown."""

from __future__ import annotations

import json
from collections.abc import Iterable, Sequence
from functools import cache
from pathlib import Path
from typing import Any

BENCHMARKS = Path(__file__).parents[2] / "benchmarks"


@cache
def result(name: str) -> Any:
    """The committed result file `benchmarks/NAME.json`."""
    return json.loads((BENCHMARKS / f"{name}.json").read_text())


def table(head: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """A table; cells are Markdown, a bar in them is escaped."""
    lines = [head, ["---"] * len(head), *rows]
    return "\n".join(f"| {' | '.join(cell.replace('|', chr(92) + '|') for cell in line)} |" for line in lines)


def percent(share: float, digits: int = 1) -> str:
    """A share of 0..1 in per cent."""
    return f"{100 * share:.{digits}f} %"


def true_false(overall: dict[str, Any]) -> str:
    """How often "found" was true, and how often false."""
    return f"{percent(overall['true_found'])}, {percent(overall['false_found'])}"
