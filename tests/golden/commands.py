"""Running the command line from outside, so that it does not matter how the package is divided into modules."""

from __future__ import annotations

import contextlib
import io
import os
import re
import runpy
import subprocess
import sys
from pathlib import Path

PACKAGE = "active_perceiver"
COLUMNS = "100"
# One thread each: sums of floating point numbers depend on how many share them.
SINGLE = dict.fromkeys(("OMP_NUM_THREADS", "MKL_NUM_THREADS", "OPENBLAS_NUM_THREADS"), "1")
PLAIN = {"COLUMNS": COLUMNS, "NO_COLOR": "1", "TERM": "dumb"}


def run(folder: Path, *arguments: str, allowed: tuple[int, ...] = (0,)) -> str:
    """Run a command in a folder, with a cache of its own there.

    Args:
        folder: where it runs.
        arguments: of the command.
        allowed: exit codes that are no failure.

    Returns:
        What it printed.
    """
    environment = {**os.environ, **SINGLE, **PLAIN, "ACTIVE_PERCEIVER_CACHE": str(folder / "cache")}
    done = subprocess.run(
        [sys.executable, "-m", PACKAGE, *arguments],
        cwd=folder, env=environment, capture_output=True, text=True, check=False,
    )  # fmt: skip
    if done.returncode not in allowed:
        sys.exit(f"{' '.join(arguments)} ended with {done.returncode}:\n{done.stdout}{done.stderr}")
    return done.stdout


def all_helps() -> dict[str, str]:
    """What `--help` says of the program and of every command, found by following the subcommands that it names."""
    helps: dict[str, str] = {}
    todo: list[tuple[str, ...]] = [()]
    while todo:
        command = todo.pop(0)
        text = helps[" ".join(command)] = _help(command)
        # The first paragraph ends with the commands, if there are any; values of an argument may stand there as well.
        listed = re.search(r"\{([a-z0-9,_\-\s]+)\}\s*$", text.split("\n\n")[0])
        if listed and "\n subcommands\n" in text:
            todo += [(*command, name.strip()) for name in listed[1].split(",")]
    return helps


def _help(command: tuple[str, ...]) -> str:
    """In this process, which takes a fraction of the time of one of its own for each."""
    printed = io.StringIO()
    before, sys.argv = sys.argv, [PACKAGE, *command, "--help"]
    os.environ.update(PLAIN)
    try:
        with contextlib.redirect_stdout(printed), contextlib.suppress(SystemExit):
            runpy.run_module(PACKAGE, run_name="__main__")
    finally:
        sys.argv = before
    return "".join(f"{line.rstrip()}\n" for line in printed.getvalue().splitlines())
