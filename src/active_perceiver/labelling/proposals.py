"""A recogniser's boxes in views that nobody has labelled, to be corrected by a person."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from active_perceiver.agent.perceiver import ActivePerceiver
from active_perceiver.errors import UserError
from active_perceiver.evaluation.detections import detect_images
from active_perceiver.scenes import Scene, Target
from active_perceiver.scenes.box_labels import label_states
from active_perceiver.scenes.scene import PROPOSED, UNLABELLED
from active_perceiver.utils.progress import ProgressCallback, quiet

PICTURES = 4
"""Pictures that each target is asked for with, at most: each more takes as long as the ones before."""
LEAST_SIDE = 0.01
"""Boxes that are narrower, as a fraction of the image, are left out."""


@dataclass(frozen=True)
class Proposals:
    """What was proposed.

    Attributes:
        views: number of views that nobody had labelled.
        boxes: number of boxes proposed in them of each target, by name.
        threshold: presence probability from which on a box was proposed.
    """

    views: int
    boxes: dict[str, int]
    threshold: float

    def __str__(self) -> str:
        lines = [f"{sum(self.boxes.values())} boxes proposed in {self.views} views (threshold {self.threshold:.2f})"]
        lines += [f"{name:<16} {count:>5}" for name, count in sorted(self.boxes.items(), key=lambda item: -item[1])]
        return "\n".join(lines)


def propose_boxes(
    scene: Scene,
    agent_folder: Path,
    *,
    threshold: float | None = None,
    anew: bool = False,
    progress: ProgressCallback = quiet,
) -> tuple[Scene, Proposals]:
    """Look for a scene's targets in its unlabelled views, which become proposed.

    Targets are asked for with the scene's own pictures, so the agent need not have been trained for them, nor in this
    scene. Of a target's pictures the one that the recogniser is surest with says where it is.

    Args:
        scene: any.
        agent_folder: of an agent that searches for objects.
        threshold: presence probability from which on a box is proposed; the agent's own if None.
        anew: whether views with earlier proposals are looked at again.
        progress: called with the number of views done and of all.

    Raises:
        UserError: if no view is unlabelled, the threshold is no probability, or the agent cannot be used.
    """
    labels = label_states(scene).copy()
    views = np.flatnonzero(np.isin(labels, (UNLABELLED, PROPOSED) if anew else (UNLABELLED,)))
    if not len(views):
        earlier = int((labels == PROPOSED).sum())
        hint = f"; {earlier} have proposals already, which --force makes anew" if earlier else ""
        raise UserError(f"scene '{scene.name}' has no unlabelled views to propose boxes in{hint}")
    if threshold is not None and not 0.0 < threshold < 1.0:
        raise UserError(f"--threshold is a probability between 0 and 1, got {threshold}")
    agent = ActivePerceiver.from_pretrained(agent_folder)
    threshold = agent.recogniser.threshold if threshold is None else threshold
    embeddings = [agent.recogniser.encode_target(agent.backbone.maps(_pictures(target))) for target in scene.targets]
    _, scores, places = detect_images(
        (scene.view(view) for view in views.tolist()),
        len(views),
        agent.backbone,
        agent.recogniser,
        np.concatenate(embeddings)[None],
        progress,
    )
    boxes = scene.boxes.copy()
    boxes[views] = surest_boxes(scores[:, 0], places[:, 0], [len(rows) for rows in embeddings], threshold)
    labels[views] = PROPOSED
    seen = (~np.isnan(boxes[views, :, 0])).sum(axis=0)
    counts = dict(zip(scene.target_names, seen.tolist(), strict=True))
    return replace(scene, boxes=boxes, labels=labels), Proposals(len(views), counts, threshold)


def surest_boxes(
    scores: NDArray[np.float32], places: NDArray[np.float32], pictures: Sequence[int], threshold: float
) -> NDArray[np.float32]:
    """For each target the box found with the picture that is surest, cut at the image's edges.

    Args:
        scores: (N, Q) presence probabilities with Q pictures, those of one target after those of another.
        places: (N, Q, 4) boxes.
        pictures: (T,) number of pictures of each target; together Q.
        threshold: probability from which on it counts.

    Returns:
        (N, T, 4) float32; NaN where nothing was found.
    """
    ends = np.cumsum(pictures)
    best = np.stack(
        [
            end - count + scores[:, end - count : end].argmax(axis=1)
            for end, count in zip(ends, pictures, strict=True)
        ],
        axis=1,
    )
    rows = np.arange(len(scores))[:, None]
    chosen = places[rows, best].astype(np.float64)
    low, high = (np.clip(chosen[..., :2] + sign * chosen[..., 2:] / 2, 0.0, 1.0) for sign in (-1, 1))
    found = (scores[rows, best] >= threshold) & ((high - low).min(axis=2) >= LEAST_SIDE)
    boxes = np.concatenate([(low + high) / 2, high - low], axis=2).astype(np.float32)
    return np.where(found[..., None], boxes, np.float32(np.nan))


def _pictures(target: Target) -> list[NDArray[np.uint8]]:
    """Up to `PICTURES` of a target's pictures, evenly spread; those that are held out are for measuring only."""
    count = min(PICTURES, target.trained)
    return [target.picture(number * target.trained // count) for number in range(count)]
