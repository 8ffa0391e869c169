"""Reading JSON that people, or strangers, wrote: no key twice, nothing nested or long enough to do harm."""

from __future__ import annotations

import json
import re
from typing import Any

import numpy as np

MAX_NESTING = 64
"""Lists and objects in one another; COCO and what this software writes have fewer than ten."""
MAX_DIGITS = 40
"""Of a whole number; identifiers of 128 bits have 39. Longer ones fit into no array, and take long to read."""

_STRING = re.compile(rb'"[^"\\]*(?:\\.[^"\\]*)*(?:"|\\?\Z)', re.DOTALL)
_OTHER = bytes(set(range(256)) - set(b"[]{}"))
_LONG = re.compile(rb"(?<![\d.eE+])\d{%d,}(?![\d.eE])" % (MAX_DIGITS + 1))


class DuplicateKeyError(ValueError):
    """An object that names a key twice: which of the values is meant, only its author knows."""


def parse_json(data: bytes | str) -> Any:
    """The content of a JSON document.

    Args:
        data: the document; bytes are UTF-8, or UTF-16 or UTF-32 as they begin.

    Raises:
        DuplicateKeyError: if an object has a key twice.
        ValueError: if it is no JSON, or nested too deep, or has a whole number of too many digits.
    """
    text = data if isinstance(data, str) else data.decode(json.detect_encoding(data), "surrogatepass")
    _check_size(text.encode("utf-8", "surrogatepass"))
    return json.loads(text, object_pairs_hook=_without_duplicates)


def _check_size(data: bytes) -> None:
    bare = _STRING.sub(b"", data)
    if found := _LONG.search(bare):
        raise ValueError(f"it has a whole number of {len(found[0])} digits, {found[0][:12].decode()}...")
    brackets = np.frombuffer(bare.translate(None, _OTHER), np.uint8)
    # "{" and "[" are two before "}" and "]".
    steps = np.where((brackets == ord("{")) | (brackets == ord("[")), 1, -1)
    if len(steps) and (deepest := int(np.cumsum(steps).max())) > MAX_NESTING:
        raise ValueError(f"it is nested {deepest} deep, more than {MAX_NESTING}")


def _without_duplicates(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    made = dict(pairs)
    if len(made) < len(pairs):
        seen: set[str] = set()
        twice = next(key for key, _ in pairs if key in seen or seen.add(key))  # type: ignore[func-returns-value]
        raise DuplicateKeyError(f"key {twice!r:.60} is there twice in one object; remove one of them")
    return made
