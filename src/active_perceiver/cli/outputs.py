"""Arguments that benchmarks share, where to write what was measured; and what they print."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from active_perceiver.benchmarks.runner import Benchmark


@dataclass(kw_only=True)
class Outputs:
    """The files of a command that measures."""

    out: Path | None = None
    """Write the result here, as JSON."""
    picture: Path | None = None
    """Write a plot here, as PNG."""
    force: bool = False
    """Replace existing files."""


def print_benchmark(benchmark: Benchmark, outputs: Outputs, resume: bool = False) -> int:
    """Run a benchmark, print its tables and say where its files are."""
    from active_perceiver.benchmarks.runner import OutputFiles, run_benchmark

    files = OutputFiles(outputs.out, outputs.picture, outputs.force, resume)
    print(benchmark.report(run_benchmark(benchmark, files)))
    if files.out is not None:
        print(f"\nresult: {files.out}")
    if files.picture is not None:
        print(f"picture: {files.picture}")
    return 0
