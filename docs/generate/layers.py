"""docs/architecture.md: the layers that import-linter holds, as a picture, and what has to run without torch."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Sequence
from functools import cache
from pathlib import Path
from typing import Any

from importlinter.api import read_configuration

WIDTH = 72
"""Characters inside the frame; wide enough for the longest row."""

_JOINTS = {(False, False): "─", (True, False): "┴", (False, True): "┬", (True, True): "┼"}
"""Whether a wall stands above and below -> what joins them in the line between two rows."""


def software() -> str:
    """The folders of the software."""
    return f"```\n{draw(_layers('active_perceiver'))}\n```"


def rooms() -> str:
    """The folders and files of the room generator."""
    return f"```\n{draw(_layers('indoor_rooms'))}\n```"


def without_torch() -> str:
    """What a robot runs."""
    (contract,) = [one for one in _contracts() if "torch" in one.get("forbidden_modules", [])]
    whole, parts = [], defaultdict(list)
    for module in contract["source_modules"]:
        _, folder, *name = module.split(".")
        if name:
            parts[folder].append(name[0])
        else:
            whole.append(folder)
    some = [f"{', '.join(_code(names))} of {_code([folder])[0]}" for folder, names in parts.items()]
    return f"{', '.join(_code(whole))} as a whole; {'; '.join(some)}."


def draw(layers: Sequence[str], width: int = WIDTH) -> str:
    """Draw layers as rows of boxes, the top one first.

    Args:
        layers: as import-linter has them: `a | b` are boxes side by side, `a : b` share one, for they may import
            each other.
        width: characters inside the frame.
    """
    rows = [[box.strip().replace(" : ", " ↔ ") for box in layer.split("|")] for layer in layers]
    lines: list[str] = []
    above = {0, width + 1}
    for row in rows:
        below = _walls(len(row), width)
        lines += [_line(above, below, "├┤", width) if lines else _line(set(), below, "┌┐", width)]
        edges = sorted(below)
        cells = [box.center(end - start - 1) for box, start, end in zip(row, edges, edges[1:], strict=False)]
        lines.append(f"│{'│'.join(cells)}│")
        above = below
    return "\n".join([*lines, _line(above, set(), "└┘", width)])


def _walls(boxes: int, width: int) -> set[int]:
    """Columns of the walls of a row."""
    return {round(number * (width + 1) / boxes) for number in range(boxes + 1)}


def _line(above: set[int], below: set[int], ends: str, width: int) -> str:
    inner = "".join(_JOINTS[column in above, column in below] for column in range(1, width + 1))
    return f"{ends[0]}{inner}{ends[1]}"


def _layers(package: str) -> list[str]:
    (contract,) = [one for one in _contracts() if package in one.get("containers", [])]
    return list(contract["layers"])


@cache
def _contracts() -> list[dict[str, Any]]:
    return list(read_configuration(str(Path(__file__).parents[2] / "pyproject.toml"))["contracts_options"])


def _code(names: list[str]) -> list[str]:
    return [f"`{name}`" for name in names]
