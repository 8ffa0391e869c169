"""What all benchmarks do with their results: refuse to overwrite before they measure, write when they have."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

from matplotlib.figure import Figure

from active_perceiver.figures.floor import figure_png
from active_perceiver.utils.files import check_output, replacing
from active_perceiver.utils.result import write_result


def check_outputs(force: bool, *paths: Path | None) -> None:
    """Make sure that nothing will be overwritten, before time is spent on measuring.

    Raises:
        OutputExistsError: if one of the files exists and `force` is false.
    """
    for path in paths:
        if path is not None:
            check_output(path, force)


def write_outputs(
    command: str, body: dict[str, Any], out: Path | None, picture: Path | None, draw: Callable[[], Figure]
) -> None:
    """Write the result file and the picture if they are asked for, and say where they are.

    Args:
        command: what was run, such as "benchmark env".
        body: of the result file.
        out: the JSON file.
        picture: the PNG file.
        draw: makes the picture.
    """
    if out is not None:
        write_result(out, command, body)
        print(f"\nresult: {out}")
    if picture is not None:
        with replacing(picture) as temporary:
            temporary.write_bytes(figure_png(draw()))
        print(f"picture: {picture}")
