"""One search on a page: what was searched, the last view, the path, the video and views on the way."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from active_perceiver.figures.annotate import draw_detection
from active_perceiver.figures.filmstrip import key_steps
from active_perceiver.figures.floor import figure_png, trajectory_figure
from active_perceiver.live import SearchRecord
from active_perceiver.reports import page
from active_perceiver.scenes.floor_plan import HasFloorPlan
from active_perceiver.scenes.images import encode_image, square_image

STRIP_VIEWS = 8


def search_card(
    record: SearchRecord,
    label: str,
    verdict: str,
    video: bytes,
    room: HasFloorPlan | None,
    goals: NDArray[np.bool_] | None = None,
) -> str:
    """A piece of a page.

    Args:
        record: the search.
        label: name of what was searched.
        verdict: how it ended, beside the title.
        video: MP4 of the search.
        room: for the path; on plain axes if it is not known.
        goals: (S,) bool, goal states of a room that is known.
    """
    last = record.step_records[-1]
    figures = [
        page.picture(encode_image(square_image(record.picture, 300)), ".webp", "what to search for"),
        page.picture(
            encode_image(draw_detection(last.image, last.step.detection, label)),
            ".webp",
            f"the last view: {record.ending}",
        ),
    ]
    path = path_png(record, label, room, goals)
    if path is not None:
        note = "the path, from the orange point to the arrow" if goals is None else "the path; green: goal states"
        figures.append(page.picture(path, ".png", note))
    figures.append(page.video(video, "the search"))
    steps = [
        page.picture(
            encode_image(draw_detection(step_record.image, step_record.step.detection, label, 240)),
            ".webp",
            f"{look}: {record.caption(look)}",
        )
        for look, step_record in ((look, record.step_records[look]) for look in key_steps(record, STRIP_VIEWS))
    ]
    title = f'<h3>{page.text(label)} <span class="muted">{page.text(verdict)}</span></h3>'
    return f'<section class="card">{title}{page.row(figures)}{page.strip(steps)}</section>'


def path_png(
    record: SearchRecord, label: str, room: HasFloorPlan | None, goals: NDArray[np.bool_] | None = None
) -> bytes | None:
    """A picture of the search's path in the room, as PNG; None if no pose is known.

    Args:
        record: the search.
        label: name of what was searched.
        room: for the floor plan; on plain axes if it is not known.
        goals: (S,) bool, goal states of a room that is known.
    """
    poses = [step_record.pose for step_record in record.step_records if step_record.pose is not None]
    if not poses:
        return None
    return figure_png(trajectory_figure(room, [np.array(poses)], goals, f"{label}: {record.actions} actions"))
