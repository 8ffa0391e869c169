"""Blocks of Markdown pages, between `<!-- begin: NAME -->` and `<!-- end: NAME -->`, each on a line of its own."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from pathlib import Path

Blocks = Mapping[str, Callable[[], str]]
"""Name of a block -> what makes its Markdown, without the markers."""

_MARKER = re.compile(r"^<!-- (begin|end): (\S+) -->$", re.MULTILINE)


class PageError(Exception):
    """Markers of a page are not as they should be; the message names the page."""


def fill_pages(root: Path, blocks: Mapping[str, Blocks], *, write: bool = True) -> list[tuple[str, str]]:
    """Fill all blocks of *.md and docs/**/*.md.

    Args:
        root: of the repository.
        blocks: path of a page, relative to the root -> the blocks it must have.
        write: whether to change the pages, or only to say what would change.

    Returns:
        Page and name of each block that is or was stale.

    Raises:
        PageError: a page or a marker is missing or unknown; nothing is written then.
    """
    paths = [*sorted(root.glob("*.md")), *sorted((root / "docs").rglob("*.md"))]
    pages = {path.relative_to(root).as_posix(): path.read_text() for path in paths}
    for page in blocks:
        if page not in pages:
            raise PageError(f"{page}: there is no such page")
    filled, stale = {}, []
    for page, text in pages.items():
        filled[page], changed = fill(text, blocks.get(page, {}), page)
        stale += [(page, name) for name in changed]
    if write:
        for page in dict(stale):
            (root / page).write_text(filled[page])
    return stale


def fill(text: str, blocks: Blocks, page: str) -> tuple[str, list[str]]:
    """Fill the blocks of one page.

    Args:
        text: of the page.
        blocks: all that it must have, each once.
        page: what errors call it.

    Returns:
        The new text, and the names of the blocks that differ.

    Raises:
        PageError: a marker is missing, unknown, or there twice.
    """
    places = _places(text, page)
    for name in places:
        if name not in blocks:
            raise PageError(f"{page}: nothing fills the block '{name}'")
    for name in blocks:
        if name not in places:
            raise PageError(f"{page}: the markers of the block '{name}' are missing")
    stale, parts, done = [], [], 0
    for name, (start, end) in places.items():
        content = f"\n{blocks[name]()}".rstrip("\n") + "\n"
        if text[start:end] != content:
            stale.append(name)
        parts += [text[done:start], content]
        done = end
    return "".join([*parts, text[done:]]), stale


def _places(text: str, page: str) -> dict[str, tuple[int, int]]:
    """Where the content of each block begins and ends, in the order of the page."""
    places: dict[str, tuple[int, int]] = {}
    open_name, start = None, 0
    for marker in _MARKER.finditer(text):
        kind, name = marker.groups()
        if (kind == "end") != (open_name is not None) or (kind == "end" and name != open_name):
            raise PageError(f"{page}: '{marker[0]}' stands where it should not; a marker before it is missing")
        if kind == "begin":
            if name in places:
                raise PageError(f"{page}: the block '{name}' is there twice")
            open_name, start = name, marker.end()
        else:
            places[name] = (start, marker.start())
            open_name = None
    if open_name is not None:
        raise PageError(f"{page}: '<!-- end: {open_name} -->' is missing")
    return places
