"""What all benchmarks have in common: nothing is overwritten, what is done is kept, result and plot are written.

Nothing is printed: the commands print what `Benchmark.report` says.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, ClassVar

from matplotlib.figure import Figure

from active_perceiver.figures.floor import figure_png
from active_perceiver.parallel.run_store import RunStore, kept_beside
from active_perceiver.utils.files import check_output, replacing
from active_perceiver.utils.result import to_jsonable, write_result

Run = dict[str, Any]
ResultBody = dict[str, Any]


@dataclass(frozen=True)
class OutputFiles:
    """Where the outcome of a benchmark goes.

    Attributes:
        out: the result file, JSON; what is finished is kept beside it until all is done.
        picture: a plot, PNG.
        force: whether files that are there are replaced, and an interrupted run is begun anew.
        resume: whether an interrupted run is gone on with.
    """

    out: Path | None = None
    picture: Path | None = None
    force: bool = False
    resume: bool = False


class Benchmark(ABC):
    """Something that is measured; what and how are the fields of the class that says it."""

    name: ClassVar[str]
    """As in the command `benchmark NAME`."""

    @abstractmethod
    def prepare(self) -> Mapping[str, Any] | None:
        """Check the settings, and open what is measured.

        Returns:
            What the runs that are kept follow from, as JSON can say it; None if none are kept.

        Raises:
            UserError: if something makes no sense, or is not there.
        """

    @abstractmethod
    def measure(self, store: RunStore) -> ResultBody:
        """Measure, with progress bars; runs that the store holds are not done again.

        Returns:
            The body of the result file.
        """

    @abstractmethod
    def report(self, body: ResultBody) -> str:
        """Tables for people of what `measure` gave, or of what a result file holds."""

    def figure(self, body: ResultBody) -> Figure | None:
        """The plot; None if there is none."""
        return None


def run_benchmark(benchmark: Benchmark, files: OutputFiles) -> ResultBody:
    """Measure what an earlier run has not, and write the result and the plot if they are asked for.

    Returns:
        The body of the result file, as the file has it.

    Raises:
        OutputExistsError: if a file or an interrupted run is there, and nothing says what to do with it.
        UserError: if the settings make no sense, or what they name is not there.
    """
    # An interrupted run has not written its result yet, so `resume` has nothing to say about an existing one.
    for path in (files.out, files.picture):
        if path is not None:
            check_output(path, files.force)
    facts = benchmark.prepare()
    kept = (files.out, facts, files.force, files.resume) if facts is not None else (None, {}, False, False)
    with kept_beside(*kept) as store:
        body = to_jsonable(benchmark.measure(store))
        if files.out is not None:
            write_result(files.out, f"benchmark {benchmark.name}", body)
        if files.picture is not None and (figure := benchmark.figure(body)) is not None:
            with replacing(files.picture) as temporary:
                temporary.write_bytes(figure_png(figure))
    return body


def share_bars(rows: Sequence[Mapping[str, Any]], label: str) -> dict[str, tuple[float, float, float]]:
    """By label of a row: shares of searches that ended with a true, with a false and without a word of "found"."""
    return {row[label]: (row["true_found"], row["false_found"], row["not_found"]) for row in rows}
