"""A search as one picture: what was searched, some views on the way, the last one with its box, the path."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from PIL import Image, ImageDraw

from active_perceiver.figures.annotate import draw_detection
from active_perceiver.figures.floor import figure_image, trajectory_figure
from active_perceiver.figures.style import INK, font
from active_perceiver.live.search_loop import SearchRecord
from active_perceiver.scenes import Scene
from active_perceiver.scenes.images import square_image

TILE, GAP, CAPTION = 260, 10, 30


def key_steps(record: SearchRecord, count: int) -> list[int]:
    """Numbers of `count` steps that tell the story: evenly spread, the first and the last among them."""
    return sorted({round(at) for at in np.linspace(0, len(record.step_records) - 1, count)})


def filmstrip(record: SearchRecord, scene: Scene, label: str, views: int = 4) -> NDArray[np.uint8]:
    """Lay a search out in a row.

    Args:
        record: the search.
        scene: for the floor plan.
        label: name of what was searched.
        views: how many views to show.

    Returns:
        (H, W, 3) uint8.
    """
    tiles = [(square_image(record.picture, TILE), f"find this {label.replace('_', ' ')}")]
    for index in key_steps(record, views):
        step_record = record.step_records[index]
        tiles.append(
            (
                draw_detection(step_record.image, step_record.step.detection, label, TILE),
                f"{index}: {record.caption(index)}",
            )
        )
    poses = np.array([step_record.pose for step_record in record.step_records if step_record.pose is not None])
    plan = figure_image(trajectory_figure(scene, [poses]))
    tiles.append((square_image(plan, TILE), f"the path, {record.actions} actions"))
    strip = Image.new("RGB", (len(tiles) * (TILE + GAP) + GAP, TILE + CAPTION + 2 * GAP), "white")
    draw = ImageDraw.Draw(strip)
    for index, (tile, caption) in enumerate(tiles):
        x = GAP + index * (TILE + GAP)
        strip.paste(Image.fromarray(tile), (x, GAP))
        draw.text((x + 2, GAP + TILE + 6), caption, fill=INK, font=font(17))
    return np.asarray(strip)
