"""Putting a trained agent together: its configuration, and the pictures by which it knows its targets again."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from active_perceiver.agent_config import AgentConfig, KnownTarget, picture_folder
from active_perceiver.experiments import own_word
from active_perceiver.experiments.likeness import known_similarity, strangers_codes
from active_perceiver.experiments.settings import TrainSettings
from active_perceiver.experiments.sightings import Sightings
from active_perceiver.experiments.view_searches import ViewSearches
from active_perceiver.exploring import RoomMap, map_file
from active_perceiver.files import replacing
from active_perceiver.perceiver import ActivePerceiver
from active_perceiver.recognition.recogniser import Recogniser
from active_perceiver.scenes import bundled_names
from active_perceiver.scenes.images import image_suffix
from active_perceiver.search.task import SearchTask
from active_perceiver.vision.backbone import Backbone
from active_perceiver.vision.cache import SceneFeatures


def agent_config(
    settings: TrainSettings,
    backbone: Backbone,
    sightings: Sequence[Sightings],
    features: Sequence[SceneFeatures],
    recogniser: Recogniser,
    held_out_views: dict[str, list[int]],
) -> AgentConfig:
    """How a trained agent is put together, with what it has to see of each target to say found.

    Args:
        settings: what it was trained with.
        backbone: of the features.
        sightings: what its recogniser sees in each scene.
        features: of these scenes.
        recogniser: the trained one.
        held_out_views: by scene, the views of places it was not trained in.
    """
    known = []
    for seen in sightings:
        task = SearchTask.from_scene(seen.scene, seen.names, settings.rank)
        for index, name in enumerate(seen.names):
            scores, boxes = (array[:, index, : seen.trained] for array in (seen.scores, seen.boxes))
            goals, areas = task.goals[:, index], task.areas[:, index]
            threshold = own_word.found_area(scores, boxes, areas, goals, recogniser.threshold)
            known.append(KnownTarget(seen.scene.name, name, threshold))
    return AgentConfig(
        backbone=backbone.name,
        image_size=backbone.image_size,
        recogniser=settings.recogniser,
        score_threshold=recogniser.threshold,
        branches={seen.scene.name: [action.value for action in seen.scene.actions] for seen in sightings},
        targets=known,
        found_area=float(np.median([target.found_area for target in known])),
        known_similarity=known_similarity(sightings, strangers_codes(sightings, features, recogniser)),
        training={
            "scenes": [_source(source) for source in settings.scenes],
            "recogniser_scenes": [_source(source) for source in settings.recogniser_scenes or settings.scenes],
            "rank": settings.rank,
            "held_out_pictures": {
                seen.scene.name: {target.name: target.held_out for target in seen.scene.targets} for seen in sightings
            },
            "held_out_views": held_out_views,
            "changed_views": settings.changed_views,
            "changed_degrees": settings.changed_degrees,
            "learner": settings.learner,
            "seed": settings.seed,
        },
    )


def _source(source: str) -> str:
    """A bundled scene by name, another by its whole path, so that the agent can be measured from anywhere."""
    return source if source in bundled_names() else str(Path(source).resolve())


def save_pictures(sightings: Sequence[Sightings], work: Path) -> None:
    """Keep the pictures that were trained on, by which the agent knows its targets, and what it makes of them.

    Args:
        sightings: what the agent's recogniser sees in each scene.
        work: the agent's folder, complete but for these.
    """
    for seen in sightings:
        for index in seen.targets:
            target = seen.scene.targets[index]
            _write_pictures(picture_folder(work, seen.scene.name, target.name), target.pictures[: seen.trained])
    ActivePerceiver.from_pretrained(work).known.save_pictures()


def save_maps(sightings: Sequence[Sightings], work: Path) -> None:
    """Keep what the agent remembers of its scenes, to look round in them; see `save_pictures`."""
    for seen in sightings:
        RoomMap.of(seen.scene, seen.view_features).save(map_file(work, seen.scene.name))


def view_agent_config(settings: TrainSettings, backbone: Backbone, searches: Sequence[ViewSearches]) -> AgentConfig:
    """How an agent that searches for views is put together.

    Args:
        settings: what it was trained with.
        backbone: of the features.
        searches: what it was trained to search for in each scene.
    """
    return AgentConfig(
        backbone=backbone.name,
        image_size=backbone.image_size,
        recogniser="none",
        score_threshold=1.0,
        branches={one.scene.name: [action.value for action in one.scene.actions] for one in searches},
        targets=[KnownTarget(one.scene.name, name) for one in searches for name in one.task.targets],
        found_area=1.0,
        known_similarity=1.0,
        training={
            "scenes": [_source(source) for source in settings.scenes],
            "learner": settings.learner,
            "seed": settings.seed,
        },
        task="view",
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
