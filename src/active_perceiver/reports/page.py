"""Self-contained HTML pages: text, tables, pictures and videos in one file that opens without a network."""

from __future__ import annotations

import base64
import html
from collections.abc import Sequence
from pathlib import Path

from active_perceiver.utils.files import replacing

_STYLE = """
:root { --ink: #22303c; --muted: #667686; --line: #e2e6ea; --accent: #2f6fde; --good: #2a9d5c; }
* { box-sizing: border-box; }
body { margin: 0; font: 16px/1.55 system-ui, -apple-system, "Segoe UI", Roboto, sans-serif; color: var(--ink);
       background: #f7f8fa; }
main { max-width: 1180px; margin: 0 auto; padding: 32px 24px 80px; }
h1 { font-size: 30px; margin: 0 0 4px; } h2 { font-size: 22px; margin: 44px 0 12px; }
h3 { font-size: 18px; margin: 0 0 8px; } p { max-width: 78ch; } .muted { color: var(--muted); }
section.card { background: white; border: 1px solid var(--line); border-radius: 12px; padding: 20px; margin: 18px 0; }
.row { display: flex; flex-wrap: wrap; gap: 16px; align-items: flex-start; }
.row > figure { flex: 1 1 0; min-width: 150px; margin: 0; }
.row > figure:has(video) { flex-grow: 1.75; min-width: 260px; }
figure img, figure video { width: 100%; border-radius: 8px; display: block; border: 1px solid var(--line); }
figcaption { font-size: 13px; color: var(--muted); margin-top: 4px; }
.strip { display: flex; flex-wrap: wrap; gap: 6px; margin-top: 14px; }
.strip figure { width: 122px; margin: 0; } .strip figcaption { font-size: 12px; }
table { border-collapse: collapse; width: 100%; background: white; font-variant-numeric: tabular-nums; }
th, td { text-align: right; padding: 7px 12px; border-bottom: 1px solid var(--line); }
th:first-child, td:first-child { text-align: left; } th { font-weight: 600; color: var(--muted); font-size: 14px; }
.scroll { overflow-x: auto; border: 1px solid var(--line); border-radius: 12px; }
.good { color: var(--good); font-weight: 600; }
"""

_MEDIA_TYPES = {".png": "image/png", ".webp": "image/webp", ".jpg": "image/jpeg", ".mp4": "video/mp4"}


def text(value: object) -> str:
    """Escape text for HTML."""
    return html.escape(str(value))


def data_url(data: bytes, suffix: str) -> str:
    """Embed a picture or a video; the suffix (".png", ".webp", ".jpg", ".mp4") says which."""
    return f"data:{_MEDIA_TYPES[suffix]};base64,{base64.b64encode(data).decode()}"


def picture(data: bytes, suffix: str, caption: str = "") -> str:
    """A figure with an embedded image and a caption, which is its alternative text too."""
    note = f"<figcaption>{text(caption)}</figcaption>" if caption else ""
    return f'<figure><img src="{data_url(data, suffix)}" alt="{text(caption)}">{note}</figure>'


def video(data: bytes, caption: str = "") -> str:
    """A figure with an embedded MP4."""
    note = f"<figcaption>{text(caption)}</figcaption>" if caption else ""
    source = data_url(data, ".mp4")
    return f'<figure><video src="{source}" controls loop muted playsinline preload="metadata"></video>{note}</figure>'


def row(figures: Sequence[str]) -> str:
    """Figures side by side."""
    return f'<div class="row">{"".join(figures)}</div>'


def strip(figures: Sequence[str]) -> str:
    """Small figures in a row that wraps."""
    return f'<div class="strip">{"".join(figures)}</div>'


def table(head: Sequence[str], rows: Sequence[Sequence[object]]) -> str:
    """A table; the first column is left-aligned, the rest are numbers."""
    header = "".join(f"<th>{text(cell)}</th>" for cell in head)
    body = "".join("<tr>" + "".join(f"<td>{text(cell)}</td>" for cell in cells) + "</tr>" for cells in rows)
    return f'<div class="scroll"><table><thead><tr>{header}</tr></thead><tbody>{body}</tbody></table></div>'


def write_page(path: Path, title: str, lead: str, body: Sequence[str]) -> None:
    """Write a page, atomically.

    Args:
        path: where to.
        title: plain text.
        lead: one plain-text paragraph under the title.
        body: pieces of HTML.
    """
    document = (
        '<!doctype html><html lang="en"><head><meta charset="utf-8">'
        '<meta name="viewport" content="width=device-width, initial-scale=1">'
        f"<title>{text(title)}</title><style>{_STYLE}</style></head><body><main>"
        f'<h1>{text(title)}</h1><p class="muted">{text(lead)}</p>{"".join(body)}</main></body></html>'
    )
    with replacing(path) as temporary:
        temporary.write_text(document)
