"""The stage of a training for objects that comes first: the recogniser, and its figures."""

from __future__ import annotations

import json
import logging
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from active_perceiver.evaluation.agent_scenes import features_of
from active_perceiver.recognition.train import CONFIGS, RecogniserConfig, TrainedRecogniser, train_recogniser
from active_perceiver.scenes import Scene
from active_perceiver.training.config import TrainConfig
from active_perceiver.training.inputs import label_warnings, open_backbone, open_scenes
from active_perceiver.training.run_folder import RunFolder
from active_perceiver.training.target_selection import check_recogniser_scenes, check_targets
from active_perceiver.training.training_result import RecogniserFigures
from active_perceiver.utils.files import replacing
from active_perceiver.utils.progress import progress_bar
from active_perceiver.vision.backbone import Backbone
from active_perceiver.vision.cache import SceneFeatures

LOG = logging.getLogger(__name__)


@dataclass(frozen=True, eq=False)
class ObjectData:
    """What a training for objects works on.

    Attributes:
        backbone: of the features.
        scenes: where is searched.
        features: of each of them.
        recogniser_scenes: what the recogniser is trained on; the same scenes unless the training names others.
        recogniser_features: of each of those.
    """

    backbone: Backbone
    scenes: tuple[Scene, ...]
    features: tuple[SceneFeatures, ...]
    recogniser_scenes: tuple[Scene, ...]
    recogniser_features: tuple[SceneFeatures, ...]


def prepare_objects(config: TrainConfig) -> ObjectData:
    """Open the scenes and compute, or find in the cache, their features.

    Raises:
        UserError: if a scene, a target or the backbone is not to be had, two scenes have the same name, or the
            recogniser would be trained with pictures that the scenes hold out.
    """
    scenes = open_scenes(config.scenes)
    check_targets(scenes, config.targets)
    recogniser_scenes = open_scenes(config.recogniser_scenes) if config.recogniser_scenes else scenes
    if recogniser_scenes is not scenes:
        for note in check_recogniser_scenes(scenes, recogniser_scenes, config.targets):
            LOG.info("note: %s", note)
    for warning in label_warnings(dict.fromkeys((*scenes, *recogniser_scenes))):
        LOG.warning("warning: %s", warning)
    backbone = open_backbone(config)
    features = tuple(features_of(scene, backbone) for scene in scenes)
    if recogniser_scenes is scenes:
        return ObjectData(backbone, scenes, features, scenes, features)
    recogniser_features = tuple(features_of(scene, backbone) for scene in recogniser_scenes)
    return ObjectData(backbone, scenes, features, recogniser_scenes, recogniser_features)


def train_recogniser_stage(
    config: TrainConfig, data: ObjectData, run: RunFolder
) -> tuple[RecogniserFigures, dict[str, list[int]]]:
    """Train the recogniser, unless an earlier run has; `recogniser.json` is written last and vouches for the rest.

    Returns:
        Its figures, and for each scene, by name, the views that it was not trained on.
    """
    done = run.path / "recogniser.json"
    if not done.is_file():
        trained = _trained(config, data)
        trained.save(run.path)
        noted = {**RecogniserFigures.of(trained).to_json(), "held_out_views": _held_out_views(data, trained)}
        with replacing(done) as temporary:
            temporary.write_text(json.dumps(noted))
    noted = json.loads(done.read_text())
    figures = RecogniserFigures.from_json(noted)
    run.seconds["recogniser"] = figures.seconds
    return figures, noted["held_out_views"]


def measure_recogniser(config: TrainConfig) -> RecogniserFigures:
    """Train a recogniser for its figures alone, for example the paper's beside the default one."""
    return RecogniserFigures.of(_trained(config, prepare_objects(config)))


def _trained(config: TrainConfig, data: ObjectData) -> TrainedRecogniser:
    recogniser = replace(CONFIGS[config.recogniser], seed=config.seed)
    if config.recogniser_steps is not None:
        recogniser = replace(recogniser, steps=config.recogniser_steps)
    return train_scene_recogniser(data.recogniser_scenes, data.recogniser_features, data.backbone, recogniser)


def train_scene_recogniser(
    scenes: Sequence[Scene], features: Sequence[SceneFeatures], backbone: Backbone, config: RecogniserConfig
) -> TrainedRecogniser:
    """Train a recogniser, with a progress bar; see `train_recogniser`."""
    with progress_bar(f"{config.kind} recogniser") as report:
        return train_recogniser(scenes, features, config, report, backbone=backbone)


def _held_out_views(data: ObjectData, trained: TrainedRecogniser) -> dict[str, list[int]]:
    """For each scene, by name, the views that the recogniser was not trained on: all, if it was trained elsewhere."""
    recogniser_scenes = zip(data.recogniser_scenes, trained.validation_views, strict=True)
    held_out = {scene.content_hash: views for scene, views in recogniser_scenes}
    return {
        scene.name: np.flatnonzero(held_out.get(scene.content_hash, np.ones(len(scene)))).tolist()
        for scene in data.scenes
    }
