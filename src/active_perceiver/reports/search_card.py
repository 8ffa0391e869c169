"""One search on a page: what was searched, the last view, the path, the video and views on the way."""

from __future__ import annotations

from dataclasses import dataclass

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


@dataclass(frozen=True)
class SearchCard:
    """What a page shows of a search.

    Attributes:
        label: name of what was searched.
        verdict: how it ended, beside the title.
        figures: the picture, the last view, the path if it is known, the video.
        views: some on the way.
    """

    label: str
    verdict: str
    figures: list[page.Figure]
    views: list[page.Figure]


def search_card(
    record: SearchRecord,
    label: str,
    verdict: str,
    video: bytes,
    room: HasFloorPlan | None,
    goals: NDArray[np.bool_] | None = None,
) -> SearchCard:
    """Collect what a page shows of a search.

    Args:
        record: the search.
        label: name of what was searched.
        verdict: how it ended.
        video: MP4 of the search.
        room: for the path; on plain axes if it is not known.
        goals: (S,) bool, goal states of a room that is known.
    """
    last = len(record.step_records) - 1
    figures = [
        page.Figure.of(encode_image(square_image(record.picture, 300)), ".webp", "what to search for"),
        _view(record, last, label, f"the last view: {record.ending}"),
    ]
    path = path_png(record, label, room, goals)
    if path is not None:
        note = "the path, from the orange point to the arrow" if goals is None else "the path; green: goal states"
        figures.append(page.Figure.of(path, ".png", note))
    figures.append(page.Figure.of(video, ".mp4", "the search"))
    views = [
        _view(record, look, label, f"{look}: {record.caption(look)}", 240) for look in key_steps(record, STRIP_VIEWS)
    ]
    return SearchCard(label, verdict, figures, views)


def _view(record: SearchRecord, look: int, label: str, caption: str, size: int = 600) -> page.Figure:
    """What was seen in a look, with its box, on a square of `size` pixels."""
    step_record = record.step_records[look]
    drawn = draw_detection(step_record.image, step_record.step.detection, label, size)
    return page.Figure.of(encode_image(drawn), ".webp", caption)


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
