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
from active_perceiver.figures.floor import draw_path, draw_room
from active_perceiver.figures.style import GOAL, INK, MUTED, fitting, font
from active_perceiver.live.search_loop import SearchRecord
from active_perceiver.scenes.floor_plan import HasFloorPlan
from active_perceiver.scenes.images import square_image
from active_perceiver.utils.files import replacing
from active_perceiver.utils.progress import ProgressCallback, quiet

VIEW, SIDE = 640, 480  # sizes in pixels; multiples of 16, which the video codec wants
PICTURE, PLAN = 144, 480
FRAMES_PER_SECOND = 4
LAST_FRAME_SECONDS = 2.0

Pose = tuple[float, float, float, float]


def search_frames(record: SearchRecord, room: HasFloorPlan | None, label: str) -> Iterator[NDArray[np.uint8]]:
    """One (640, 1120, 3) uint8 frame for each step of a search.

    Args:
        record: the search.
        room: for the floor plan; without it the path is shown on plain axes, without poses not at all.
        label: name of what is searched.
    """
    picture = Image.fromarray(square_image(record.picture, PICTURE))
    poses = [step_record.pose for step_record in record.step_records]
    whole = [pose for pose in poses if pose is not None]
    plan = _Plan(room, whole) if whole else None
    for index, step_record in enumerate(record.step_records):
        frame = Image.new("RGB", (VIEW + SIDE, VIEW), "white")
        frame.paste(
            Image.fromarray(draw_detection(step_record.image, step_record.step.detection, label, VIEW)), (0, 0)
        )
        frame.paste(picture, (VIEW + 8, 8))
        draw = ImageDraw.Draw(frame)
        x = VIEW + PICTURE + 24
        last = index == len(record.step_records) - 1
        done = step_record.step.found and (last or record.dry_run)
        count = f"look {index + 1}" if record.dry_run else f"action {index}"
        draw.text((x, 14), fitting(f"searching: {label}", SIDE - PICTURE - 32, 24), fill=INK, font=font(24))
        draw.text((x, 54), f"{count}, {step_record.seconds:.1f} s", fill=MUTED, font=font(20))
        draw.text((x, 88), record.caption(index), fill=GOAL if done else INK, font=font(28))
        path = [pose for pose in poses[: index + 1] if pose is not None]
        if plan is not None and path:
            frame.paste(Image.fromarray(plan.image(path)), (VIEW, VIEW - PLAN))
        yield np.asarray(frame)


class _Plan:
    """A room on which a path grows: the room is drawn once, the path anew each time, which is several times as fast.

    Args:
        room: what is known of it.
        whole: the whole path, which fits in.
    """

    def __init__(self, room: HasFloorPlan | None, whole: list[Pose]) -> None:
        figure = Figure(figsize=(PLAN / 100, PLAN / 100), dpi=100)
        self._canvas = FigureCanvasAgg(figure)
        self._axes = figure.add_axes((0.02, 0.02, 0.96, 0.96) if room is not None else (0.13, 0.1, 0.84, 0.84))
        draw_room(self._axes, room, [whole])
        self._axes.update_datalim(np.array(whole)[:, :2])
        self._axes.autoscale_view()
        self._axes.set_autoscale_on(False)
        self._canvas.draw()
        self._empty = self._canvas.copy_from_bbox(figure.bbox)

    def image(self, path: list[Pose]) -> NDArray[np.uint8]:
        """The room with a path, (PLAN, PLAN, 3) uint8."""
        before = set(self._axes.get_children())
        draw_path(self._axes, path)
        drawn = [artist for artist in self._axes.get_children() if artist not in before]
        self._canvas.restore_region(self._empty)
        for artist in sorted(drawn, key=lambda artist: artist.get_zorder()):
            self._axes.draw_artist(artist)
            artist.remove()
        return np.asarray(self._canvas.buffer_rgba())[..., :3].copy()


def write_video(
    record: SearchRecord,
    path: Path,
    room: HasFloorPlan | None,
    label: str,
    *,
    force: bool = False,
    report: ProgressCallback = quiet,
) -> None:
    """Write a search as an MP4 that browsers play.

    Args:
        record: the search.
        path: where to; parent folders are made.
        room: for the floor plan; without it the path is shown on plain axes.
        label: name of what is searched.
        force: replace an existing file.
        report: called after every frame.

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
            for number, frame in enumerate(search_frames(record, room, label), 1):
                pixels = np.ascontiguousarray(frame)
                writer.send(pixels)
                report(number, len(record.step_records))
            for _ in range(round(LAST_FRAME_SECONDS * FRAMES_PER_SECOND)):
                writer.send(pixels)
        finally:
            writer.close()
