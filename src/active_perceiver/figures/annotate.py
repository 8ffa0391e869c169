"""Drawing a detection on a view."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from PIL import Image, ImageDraw

from active_perceiver.figures.style import BOX, PADDING, fitting, font
from active_perceiver.recognition.recogniser import Detection


def draw_detection(
    image: NDArray[np.uint8], detection: Detection | None, label: str, size: int = 600
) -> NDArray[np.uint8]:
    """Scale a view and draw the box on it; a view that is not square lies in the middle of a square.

    Args:
        image: (H, W, 3) uint8 RGB.
        detection: what is seen, or None to draw no box.
        label: written above the box, with the score.
        size: side of the result in pixels.

    Returns:
        (size, size, 3) uint8.
    """
    # A box tells fractions of a square: the agent fills up a view that is not one (see `square_image`).
    height, width = (max(1, round(side * size / max(image.shape[:2]))) for side in image.shape[:2])
    view = Image.fromarray(image).resize((width, height), Image.Resampling.LANCZOS)
    canvas = Image.new("RGB", (size, size), PADDING)
    canvas.paste(view, ((size - width) // 2, (size - height) // 2))
    if detection is None:
        return np.asarray(canvas)
    draw = ImageDraw.Draw(canvas)
    centre, extent = detection.box[:2] * size, detection.box[2:] * size
    left, top = np.clip(centre - extent / 2, 0, size - 1)
    right, bottom = np.clip(centre + extent / 2, 0, size - 1)
    draw.rectangle((left, top, right, bottom), outline=BOX, width=max(2, size // 150))
    height = max(12, size // 30)
    text, letters = f"{fitting(label, size // 2, height)} {detection.score:.2f}", font(height)
    _, _, wide, high = draw.textbbox((0, 0), text, font=letters)
    x = min(left, size - wide - 8)
    y = top - high - 8 if top > high + 8 else min(bottom + 2, size - high - 8)
    draw.rectangle((x, y, x + wide + 8, y + high + 6), fill=BOX)
    draw.text((x + 4, y + 2), text, fill="white", font=letters)
    return np.asarray(canvas)
