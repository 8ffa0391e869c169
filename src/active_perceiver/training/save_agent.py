"""Putting a trained agent together: its configuration, and the pictures by which it knows its targets again."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from active_perceiver.agent.config import AgentConfig, KnownTarget, picture_folder
from active_perceiver.agent.exploration import ViewMap, map_file
from active_perceiver.agent.found_criterion import stop_area_threshold
from active_perceiver.agent.goals.view_goal import VIEW
from active_perceiver.agent.perceiver import ActivePerceiver
from active_perceiver.agent.training_record import TrainingRecord
from active_perceiver.envs.task import SearchTask
from active_perceiver.evaluation.detections import DetectionTable
from active_perceiver.evaluation.view_selection import ViewSearches
from active_perceiver.recognition.recogniser import Recogniser
from active_perceiver.scenes import bundled_names
from active_perceiver.scenes.images import image_suffix
from active_perceiver.training.config import TrainConfig
from active_perceiver.training.match_threshold import distractor_embeddings, match_threshold
from active_perceiver.utils.files import replacing
from active_perceiver.vision.backbone import Backbone
from active_perceiver.vision.cache import SceneFeatures


def agent_config(
    config: TrainConfig,
    backbone: Backbone,
    detections: Sequence[DetectionTable],
    features: Sequence[SceneFeatures],
    recogniser: Recogniser,
    held_out_views: dict[str, list[int]],
) -> AgentConfig:
    """How a trained agent is put together, with what it has to see of each target to say found.

    Args:
        config: what it was trained with.
        backbone: of the features.
        detections: what its recogniser sees in each scene.
        features: of these scenes.
        recogniser: the trained one.
        held_out_views: by scene, the views of places it was not trained in.
    """
    known = []
    for seen in detections:
        task = SearchTask.from_scene(seen.scene, seen.names, config.rank)
        for index, name in enumerate(seen.names):
            scores, boxes = (array[:, index, : seen.trained] for array in (seen.scores, seen.boxes))
            goals, areas = task.goals[:, index], task.areas[:, index]
            threshold = stop_area_threshold(scores, boxes, areas, goals, recogniser.threshold)
            known.append(KnownTarget(seen.scene.name, name, threshold))
    return AgentConfig(
        backbone=backbone.name,
        image_size=backbone.image_size,
        recogniser=config.recogniser,
        score_threshold=recogniser.threshold,
        branches={seen.scene.name: [action.value for action in seen.scene.actions] for seen in detections},
        targets=known,
        stop_area_threshold=float(np.median([target.stop_area_threshold for target in known])),
        match_threshold=match_threshold(detections, distractor_embeddings(detections, features, recogniser)),
        training=TrainingRecord(
            scenes=tuple(map(_source, config.scenes)),
            recogniser_scenes=tuple(map(_source, config.recogniser_scenes or config.scenes)),
            rank=config.rank,
            held_out_pictures={
                seen.scene.name: {target.name: target.held_out for target in seen.scene.targets}
                for seen in detections
            },
            held_out_views=held_out_views,
            view_augmentation=config.view_augmentation,
            viewpoint_jitter_degrees=config.viewpoint_jitter_degrees,
            learner=config.learner,
            seed=config.seed,
        ),
    )


def _source(source: str) -> str:
    """A bundled scene by name, another by its whole path, so that the agent can be measured from anywhere."""
    return source if source in bundled_names() else str(Path(source).resolve())


def save_pictures(detections: Sequence[DetectionTable], work: Path) -> None:
    """Keep the pictures that were trained on, by which the agent knows its targets, and what it makes of them.

    Args:
        detections: what the agent's recogniser sees in each scene.
        work: the agent's folder, complete but for these.
    """
    for seen in detections:
        for index in seen.targets:
            target = seen.scene.targets[index]
            _write_pictures(picture_folder(work, seen.scene.name, target.name), target.pictures[: seen.trained])
    ActivePerceiver.from_pretrained(work).gallery.save_pictures()


def save_maps(detections: Sequence[DetectionTable], work: Path) -> None:
    """Keep what the agent remembers of its scenes, to look round in them; see `save_pictures`."""
    for seen in detections:
        ViewMap.of(seen.scene, seen.view_features).save(map_file(work, seen.scene.name))


def view_agent_config(config: TrainConfig, backbone: Backbone, searches: Sequence[ViewSearches]) -> AgentConfig:
    """How an agent that searches for views is put together.

    Args:
        config: what it was trained with.
        backbone: of the features.
        searches: what it was trained to search for in each scene.
    """
    return AgentConfig(
        backbone=backbone.name,
        image_size=backbone.image_size,
        recogniser=None,
        score_threshold=1.0,
        branches={one.scene.name: [action.value for action in one.scene.actions] for one in searches},
        targets=[KnownTarget(one.scene.name, name) for one in searches for name in one.task.targets],
        stop_area_threshold=1.0,
        match_threshold=1.0,
        training=TrainingRecord(tuple(map(_source, config.scenes)), config.learner, config.seed),
        task=VIEW.name,
        found_similarity=max(one.found_similarity() for one in searches),
    )


def save_views(searches: Sequence[ViewSearches], work: Path) -> None:
    """Keep the views that are searched for: pictures to search with, and by which the scene is known again."""
    for one in searches:
        for name, state in zip(one.task.targets, one.states, strict=True):
            _write_pictures(picture_folder(work, one.scene.name, name), [one.scene.views[state]])


def _write_pictures(folder: Path, pictures: Sequence[bytes]) -> None:
    folder.mkdir(parents=True, exist_ok=True)
    for number, data in enumerate(pictures):
        with replacing(folder / f"{number:02}.{image_suffix(data)}") as temporary:
            temporary.write_bytes(data)
