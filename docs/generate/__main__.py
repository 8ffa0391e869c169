"""`python -m docs.generate`: fill the marked blocks; with `--check` only say which are stale."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from docs.generate.blocks import BLOCKS
from docs.generate.pages import PageError, fill_pages

ROOT = Path(__file__).parents[2]


def main(arguments: list[str] | None = None) -> int:
    """Fill the blocks of this repository; returns the exit code."""
    parser = argparse.ArgumentParser(prog="python -m docs.generate", description="Fill the marked blocks.")
    parser.add_argument("--check", action="store_true", help="write nothing; exit code 1 if a block is stale")
    check = parser.parse_args(arguments).check
    try:
        stale = fill_pages(ROOT, BLOCKS, write=not check)
    except PageError as error:
        print(f"error: {error}", file=sys.stderr)
        return 2
    for page, name in stale:
        print(f"{page}: {name} {'is stale' if check else 'written'}")
    return 1 if check and stale else 0


if __name__ == "__main__":
    sys.exit(main())
