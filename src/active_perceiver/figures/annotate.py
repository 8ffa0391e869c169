"""Drawing a detection on a view."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from PIL import Image, ImageDraw

from active_perceiver.figures.style import BOX, font
from active_perceiver.recognition.recogniser import Detection
from active_perceiver.scenes.images import square_image


def draw_detection(
    image: NDArray[np.uint8], detection: Detection | None, label: str, size: int = 600
) -> NDArray[np.uint8]:
    """Scale a view and draw the box on it.

    Args:
        image: (H, W, 3) uint8 RGB.
        detection: what is seen, or None to draw no box.
        label: written above the box, with the score.
        size: side of the result in pixels.

    Returns:
        (size, size, 3) uint8.
    """
    # A view that is not square is filled up to the square of which a box tells fractions, as for the agent.
    square = square_image(image, max(image.shape[:2]))
    canvas = Image.fromarray(square).resize((size, size), Image.Resampling.LANCZOS)
    if detection is None:
        return np.asarray(canvas)
    draw = ImageDraw.Draw(canvas)
    centre, extent = detection.box[:2] * size, detection.box[2:] * size
    left, top = np.clip(centre - extent / 2, 0, size - 1)
    right, bottom = np.clip(centre + extent / 2, 0, size - 1)
    draw.rectangle((left, top, right, bottom), outline=BOX, width=max(2, size // 150))
    text, letters = f"{label} {detection.score:.2f}", font(max(12, size // 30))
    _, _, wide, high = draw.textbbox((0, 0), text, font=letters)
    x = min(left, size - wide - 8)
    y = top - high - 8 if top > high + 8 else min(bottom + 2, size - high - 8)
    draw.rectangle((x, y, x + wide + 8, y + high + 6), fill=BOX)
    draw.text((x + 4, y + 2), text, fill="white", font=letters)
    return np.asarray(canvas)
