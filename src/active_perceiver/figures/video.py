"""A search as a video: what the robot sees, its box, what it searches for, and its path from above."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import imageio_ffmpeg
import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from numpy.typing import NDArray
from PIL import Image, ImageDraw

from active_perceiver.figures.annotate import draw_detection
from active_perceiver.figures.floor import draw_floor, draw_path
from active_perceiver.figures.style import GOAL, INK, MUTED, font
from active_perceiver.files import replacing
from active_perceiver.robots.searching import SearchRecord
from active_perceiver.scenes import Scene
from active_perceiver.scenes.images import square_image

VIEW, SIDE = 640, 480  # sizes in pixels; multiples of 16, which the video codec wants
PICTURE, PLAN = 144, 480
FRAMES_PER_SECOND = 4
LAST_FRAME_SECONDS = 2.0


def search_frames(record: SearchRecord, scene: Scene | None, label: str) -> Iterator[NDArray[np.uint8]]:
    """One (640, 1120, 3) uint8 frame for each glimpse of a search.

    Args:
        record: the search.
        scene: for the floor plan; without it, or without poses, only the views are shown.
        label: name of what is searched.
    """
    picture = Image.fromarray(square_image(record.picture, PICTURE))
    poses = [glimpse.pose for glimpse in record.glimpses]
    for index, glimpse in enumerate(record.glimpses):
        frame = Image.new("RGB", (VIEW + SIDE, VIEW), "white")
        frame.paste(Image.fromarray(draw_detection(glimpse.image, glimpse.step.detection, label, VIEW)), (0, 0))
        frame.paste(picture, (VIEW + 8, 8))
        draw = ImageDraw.Draw(frame)
        x = VIEW + PICTURE + 24
        last = index == len(record.glimpses) - 1
        doing = glimpse.step.action.value
        if last:
            doing = "found" if record.found else "not found"
        draw.text((x, 14), f"searching: {label}", fill=INK, font=font(24))
        draw.text((x, 54), f"action {index}", fill=MUTED, font=font(20))
        draw.text((x, 88), doing, fill=GOAL if last and record.found else INK, font=font(28))
        path = [pose for pose in poses[: index + 1] if pose is not None]
        if scene is not None and path:
            frame.paste(Image.fromarray(_plan(scene, path)), (VIEW, VIEW - PLAN))
        yield np.asarray(frame)


def _plan(scene: Scene, path: list[tuple[float, float, float, float]]) -> NDArray[np.uint8]:
    figure = Figure(figsize=(PLAN / 100, PLAN / 100), dpi=100)
    canvas = FigureCanvasAgg(figure)
    axes = figure.add_axes((0.02, 0.02, 0.96, 0.96))
    draw_floor(axes, scene)
    draw_path(axes, path)
    canvas.draw()
    return np.asarray(canvas.buffer_rgba())[..., :3]


def write_video(record: SearchRecord, path: Path, scene: Scene | None, label: str, *, force: bool = False) -> None:
    """Write a search as an MP4 that browsers play.

    Args:
        record: the search.
        path: where to; parent folders are made.
        scene: for the floor plan.
        label: name of what is searched.
        force: replace an existing file.

    Raises:
        OutputExistsError: if the file exists and `force` is false.
    """
    with replacing(path, force) as temporary:
        writer = imageio_ffmpeg.write_frames(
            str(temporary), (VIEW + SIDE, VIEW), fps=FRAMES_PER_SECOND, codec="libx264", quality=7,
            output_params=["-movflags", "+faststart"],
        )  # fmt: skip
        writer.send(None)
        try:
            for frame in search_frames(record, scene, label):
                pixels = np.ascontiguousarray(frame)
                writer.send(pixels)
            for _ in range(round(LAST_FRAME_SECONDS * FRAMES_PER_SECOND)):
                writer.send(pixels)
        finally:
            writer.close()
