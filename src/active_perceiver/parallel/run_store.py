"""Finished runs of a long benchmark, kept in a file until all are done, so that an interrupted one can go on."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from active_perceiver import __version__
from active_perceiver.errors import UserError
from active_perceiver.utils.files import OutputExistsError, replacing


class RunStore:
    """A file of lines of JSON beside the result file: the settings, then one finished run after the other.

    Args:
        out: the result file, "train.json"; runs are kept in "train.json.part".
        settings: of the benchmark, as JSON can say them.
        force: throw away what is kept.
        resume: go on after what is kept.

    Attributes:
        path: of the file.
        runs: that were finished earlier.

    Raises:
        OutputExistsError: if runs are kept, and neither `force` nor `resume` says what to do.
        UserError: if they are to be gone on with, but have other settings.
    """

    def __init__(self, out: Path, settings: dict[str, Any], *, force: bool, resume: bool) -> None:
        self.path = out.with_name(f"{out.name}.part")
        self.runs: list[dict[str, Any]] = []
        # As they are read again: JSON knows lists, but no tuples.
        settings = json.loads(json.dumps({"version": __version__, **settings}))
        if self.path.exists():
            if resume:
                self.runs = self._read(settings)
            elif not force:
                raise OutputExistsError(f"{self.path} is an interrupted run; --resume goes on, --force begins anew")
        # Written again, so that a line that was cut off is gone.
        with replacing(self.path) as temporary:
            temporary.write_text("".join(f"{json.dumps(line)}\n" for line in (settings, *self.runs)))

    def add(self, run: dict[str, Any]) -> None:
        """Keep a run."""
        with self.path.open("a") as file:
            file.write(f"{json.dumps(run)}\n")

    def delete(self) -> None:
        """Remove the file, when the result is written."""
        self.path.unlink()

    def _read(self, settings: dict[str, Any]) -> list[dict[str, Any]]:
        first, *lines = self.path.read_text().split("\n")
        try:
            begun = json.loads(first)
            # Whatever follows the last end of a line was cut off.
            runs = [json.loads(line) for line in lines[:-1]]
        except json.JSONDecodeError:
            raise UserError(f"{self.path} is damaged; begin anew with --force") from None
        if begun != settings:
            other = [name for name in settings if begun.get(name) != settings[name]]
            raise UserError(
                f"{self.path} was begun with another {', '.join(other)}; give the same settings, or --force to begin "
                "anew"
            )
        return runs


@contextmanager
def kept_runs(
    out: Path | None, settings: dict[str, Any], *, force: bool, resume: bool
) -> Iterator[tuple[list[dict[str, Any]], Callable[[dict[str, Any]], None]]]:
    """The runs that were finished earlier, and what keeps a further one; nothing is kept without a result file.

    The file of runs is removed when the block, which writes the result at its end, is left without an exception.
    See `RunStore` for the arguments and for what is raised.
    """
    if out is None:
        yield [], lambda run: None
        return
    kept = RunStore(out, settings, force=force, resume=resume)
    yield kept.runs, kept.add
    kept.delete()


def check_resume(resume: bool, out: Path | None) -> None:
    """Make sure that there is something to go on with.

    Raises:
        UserError: if `resume` is asked for without a result file.
    """
    if resume and out is None:
        raise UserError("--resume goes on with what is kept beside the result file; name it with --out")
