"""Colours and fonts that all figures share."""

from __future__ import annotations

from PIL import ImageFont

INK = "#22303c"
MUTED = "#8796a5"
FLOOR = "#f6f3ec"
OBSTACLE = "#d9d3c7"
OBSTACLE_EDGE = "#b8b0a0"
GOAL = "#2a9d5c"
PATH = "#2f6fde"
START = "#f0a202"
BOX = "#ff4d2e"
PADDING = "#eceff2"

# Curves of one plot: Okabe and Ito's palette, which colour-blind people tell apart too, and ink.
SERIES = ("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", INK)
# Several searches on one floor plan: far from the green of the goals and the orange of the starts.
PATHS = (PATH, "#c2348a", "#8a5a2b", "#0f9fb5", "#7a4fd0", "#c8322b")


def font(size: int) -> ImageFont.FreeTypeFont | ImageFont.ImageFont:
    """Pillow's own scalable font, so that a figure looks the same on every machine."""
    return ImageFont.load_default(size)


def fitting(text: str, width: int, size: int) -> str:
    """As much of a line as fits into `width` pixels, with an ellipsis where it is cut."""
    letters, rest = font(size), text
    while rest and letters.getlength(text) > width:
        rest = rest[:-1]
        text = f"{rest}…"
    return text
