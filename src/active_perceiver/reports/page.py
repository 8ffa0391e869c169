"""Self-contained HTML pages: text, tables, pictures and videos in one file that opens without a network.

What a page looks like is in `templates/`, where every value is escaped; here are the values that need a type.
"""

from __future__ import annotations

import base64
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

from jinja2 import Environment, PackageLoader, StrictUndefined

from active_perceiver.utils.files import replacing

_MEDIA_TYPES = {".png": "image/png", ".webp": "image/webp", ".jpg": "image/jpeg", ".mp4": "video/mp4"}


@dataclass(frozen=True)
class Figure:
    """An embedded picture or video.

    Attributes:
        url: a data URL with all of it.
        caption: below it; a picture's alternative text too.
        is_video: whether it is played.
    """

    url: str
    caption: str
    is_video: bool

    @classmethod
    def of(cls, data: bytes, suffix: str, caption: str = "") -> Figure:
        """Embed a file's content; the suffix (".png", ".webp", ".jpg", ".mp4") says what it is.

        Raises:
            ValueError: if no page can show what the suffix stands for.
        """
        if suffix not in _MEDIA_TYPES:
            raise ValueError(f"a page shows {', '.join(_MEDIA_TYPES)}, not '{suffix}'")
        kind = _MEDIA_TYPES[suffix]
        return cls(f"data:{kind};base64,{base64.b64encode(data).decode()}", caption, kind.startswith("video/"))


@dataclass(frozen=True)
class Table:
    """A table; the first column is left-aligned, the rest are numbers.

    Attributes:
        head: the columns' titles; none if empty.
        rows: as many cells each.
        note: a paragraph above it.
    """

    head: Sequence[str]
    rows: Sequence[Sequence[object]]
    note: str = ""


def write_page(path: Path, template: str, **values: Any) -> None:
    """Write a page, atomically.

    Args:
        path: where to.
        template: name of a file in `templates/`.
        values: what it shows; its first line says which it needs.

    Raises:
        jinja2.UndefinedError: if one is missing.
    """
    document = _templates().get_template(template).render(values)
    with replacing(path) as temporary:
        temporary.write_text(document)


@cache
def _templates() -> Environment:
    return Environment(
        loader=PackageLoader("active_perceiver.reports"),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
