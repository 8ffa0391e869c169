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


def font(size: int) -> ImageFont.FreeTypeFont | ImageFont.ImageFont:
    """Pillow's own scalable font, so that a figure looks the same on every machine."""
    return ImageFont.load_default(size)
