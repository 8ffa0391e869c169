"""Training an agent as a whole: features, recogniser, policy, measurement; each stage resumable."""

from __future__ import annotations

import json
import time
from collections.abc import Iterable, Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from active_perceiver.agent.config import AgentConfig, SearchKind
from active_perceiver.agent.perceiver import ActivePerceiver
from active_perceiver.envs.observations import Observations
from active_perceiver.evaluation.agent_scenes import features_of
from active_perceiver.evaluation.config import EvaluateConfig
from active_perceiver.evaluation.detections import DetectionTable, detect_all_views
from active_perceiver.evaluation.evaluate import measure_agent
from active_perceiver.recognition.recogniser import Recogniser
from active_perceiver.recognition.train import CONFIGS, RecogniserConfig, TrainedRecogniser, train_recogniser
from active_perceiver.scenes import Scene
from active_perceiver.scenes.box_labels import label_states
from active_perceiver.scenes.scene import PROPOSED, UNLABELLED
from active_perceiver.training.common import (
    Pipeline,
    learner_config,
    open_backbone,
    open_scenes,
    policy_tasks,
    train_policy,
)
from active_perceiver.training.config import TrainConfig
from active_perceiver.training.model_card import write_card
from active_perceiver.training.policy_augmentation import changed_observations
from active_perceiver.training.run_folder import begin, checked_work_folder, finish
from active_perceiver.training.save_agent import agent_config, save_maps, save_pictures
from active_perceiver.training.target_selection import check_recogniser_scenes, check_targets, searched_targets
from active_perceiver.training.view_pipeline import prepare_views, train_for_views
from active_perceiver.utils.files import replacing
from active_perceiver.utils.progress import console, progress_bar
from active_perceiver.utils.result import write_result
from active_perceiver.vision.backbone import Backbone
from active_perceiver.vision.cache import SceneFeatures


@dataclass(frozen=True, eq=False)
class TrainingData:
    """What training works on.

    Attributes:
        backbone: of the features.
        scenes: where is searched.
        features: of each of them.
        recogniser_scenes: what the recogniser is trained on; the same scenes unless the settings name others.
        recogniser_features: of each of those.
    """

    backbone: Backbone
    scenes: tuple[Scene, ...]
    features: tuple[SceneFeatures, ...]
    recogniser_scenes: tuple[Scene, ...]
    recogniser_features: tuple[SceneFeatures, ...]


def prepare(settings: TrainConfig) -> TrainingData:
    """Open the scenes and compute, or find in the cache, their features.

    Raises:
        UserError: if a scene, a target or the backbone is not to be had, two scenes have the same name, or the
            recogniser would be trained with pictures that the scenes hold out.
    """
    scenes = open_scenes(settings.scenes)
    check_targets(scenes, settings.targets)
    recogniser_scenes = open_scenes(settings.recogniser_scenes) if settings.recogniser_scenes else scenes
    if recogniser_scenes is not scenes:
        for note in check_recogniser_scenes(scenes, recogniser_scenes, settings.targets):
            console.print(f"note: {note}", highlight=False)
    for warning in label_warnings(dict.fromkeys((*scenes, *recogniser_scenes))):
        console.print(f"warning: {warning}", highlight=False, soft_wrap=True)
    backbone = open_backbone(settings)
    features = tuple(features_of(scene, backbone) for scene in scenes)
    recogniser_features = (
        features
        if recogniser_scenes is scenes
        else tuple(features_of(scene, backbone) for scene in recogniser_scenes)
    )
    return TrainingData(backbone, scenes, features, recogniser_scenes, recogniser_features)


def label_warnings(scenes: Iterable[Scene]) -> list[str]:
    """Sentences on views whose boxes nobody has drawn or looked at, and what that means for training."""
    warnings = []
    for scene in scenes:
        unlabelled, proposed = (int((label_states(scene) == state).sum()) for state in (UNLABELLED, PROPOSED))
        if unlabelled:
            warnings.append(
                f"{unlabelled} of {len(scene)} views of {scene.name} are not labelled: no recogniser learns from "
                "them, and none of them is where a search should end; label them with `scenes label`"
            )
        if proposed:
            warnings.append(
                f"the boxes of {proposed} of {len(scene)} views of {scene.name} were proposed by a recogniser and "
                "not accepted: they are learned from as they are; look at them with `scenes label`"
            )
    return warnings


def train_agent(settings: TrainConfig, out: Path, *, force: bool = False, resume: bool = False) -> dict[str, Any]:
    """Train an agent and measure it.

    Everything is written to `OUT.part` first, which becomes `out` when all is done; an interrupted training leaves
    `OUT.part`, and `resume` goes on from the stage it was in.

    Args:
        settings: what to train.
        out: folder of the agent.
        force: replace an agent that is there, and begin anew where one was interrupted.
        resume: go on with an interrupted training, with the same settings.

    Returns:
        The body of its `result.json`.

    Raises:
        OutputExistsError: if there is something already, and neither `force` nor `resume` says what to do.
        UserError: if the settings do not fit the scenes, or differ from those of the interrupted training.
    """
    # What is wrong with the settings or the folder shows before anything long begins, and leaves nothing behind.
    learner_config(settings)
    work = checked_work_folder(settings, out, force=force, resume=resume)
    pipeline = PIPELINES[settings.task]
    started = time.monotonic()
    material = pipeline.prepare(settings)
    begin(settings, work, resume=resume)
    seconds = {"features": time.monotonic() - started}
    config, body = pipeline.train(settings, material, work, seconds)
    body |= {"settings": asdict(settings), "seconds": {**seconds, "total": time.monotonic() - started}}
    write_result(work / "result.json", "train", body)
    write_card(work, config, body)
    finish(work, out)
    return body


def _train_for_objects(
    settings: TrainConfig, material: TrainingData, work: Path, seconds: dict[str, float]
) -> tuple[AgentConfig, dict[str, Any]]:
    """Recogniser, policy and measurement of an agent that searches for objects; see `Pipeline.train`."""
    recogniser_metrics = _recogniser_stage(settings, material, work, seconds)
    recogniser = Recogniser(work / "recogniser.onnx")
    detections = _see_all(settings, material, recogniser, seconds)
    changed = _see_changed(settings, material, detections, recogniser, seconds)
    history = _policy_stage(settings, detections, changed, recogniser, work, seconds)
    held_out_views = recogniser_metrics.pop("held_out_views")
    config = agent_config(settings, material.backbone, detections, material.features, recogniser, held_out_views)
    config.save(work)
    save_maps(detections, work)
    save_pictures(detections, work)
    agent = ActivePerceiver.from_pretrained(work)
    with console.status("measuring"):
        body = measure_agent(agent, detections, EvaluateConfig(seed=settings.seed))
    return config, body | {"recogniser": recogniser_metrics, "policy_history": history}


def measure_recogniser(settings: TrainConfig) -> dict[str, Any]:
    """Train a recogniser for its figures alone, for example the paper's beside the default one.

    Returns:
        See `_recogniser_figures`.
    """
    return _recogniser_figures(_train_recogniser(settings, prepare(settings)))


def _train_recogniser(settings: TrainConfig, material: TrainingData) -> TrainedRecogniser:
    config = replace(CONFIGS[settings.recogniser], seed=settings.seed)
    if settings.recogniser_steps is not None:
        config = replace(config, steps=settings.recogniser_steps)
    return train_scene_recogniser(material.recogniser_scenes, material.recogniser_features, material.backbone, config)


def train_scene_recogniser(
    scenes: Sequence[Scene], features: Sequence[SceneFeatures], backbone: Backbone, config: RecogniserConfig
) -> TrainedRecogniser:
    """Train a recogniser, with a progress bar; see `train_recogniser`."""
    with progress_bar(f"{config.kind} recogniser") as report:
        return train_recogniser(
            scenes,
            features,
            config,
            report,
            backbone=backbone,
        )


def _recogniser_figures(trained: TrainedRecogniser) -> dict[str, Any]:
    """Metrics on views of places not trained in, with pictures seen and not seen, and how it was trained."""
    return {
        "protocol": "views of places not trained in; objects of at least 0.3 % of the image count as there, "
        "smaller ones neither as there nor as absent",
        "metrics": {name: metrics.as_dict() for name, metrics in trained.metrics.items()},
        "config": asdict(trained.config),
        "seconds": trained.seconds,
    }


def _recogniser_stage(
    settings: TrainConfig, material: TrainingData, work: Path, seconds: dict[str, float]
) -> dict[str, Any]:
    """Train the recogniser, unless an earlier run has; `recogniser.json` is written last and vouches for the rest."""
    done = work / "recogniser.json"
    if not done.is_file():
        trained = _train_recogniser(settings, material)
        trained.save(work)
        held_out = _held_out_views(material, trained)
        with replacing(done) as temporary:
            temporary.write_text(json.dumps({**_recogniser_figures(trained), "held_out_views": held_out}))
    figures = json.loads(done.read_text())
    seconds["recogniser"] = figures["seconds"]
    return figures


def _held_out_views(material: TrainingData, trained: TrainedRecogniser) -> dict[str, list[int]]:
    """For each scene, by name, the views that the recogniser was not trained on: all, if it was trained elsewhere."""
    recogniser_scenes = zip(material.recogniser_scenes, trained.validation_views, strict=True)
    held_out = {scene.content_hash: views for scene, views in recogniser_scenes}
    return {
        scene.name: np.flatnonzero(held_out.get(scene.content_hash, np.ones(len(scene)))).tolist()
        for scene in material.scenes
    }


def _see_all(
    settings: TrainConfig, material: TrainingData, recogniser: Recogniser, seconds: dict[str, float]
) -> list[DetectionTable]:
    started = time.monotonic()
    detections = []
    for scene, features in zip(material.scenes, material.features, strict=True):
        detections.append(detect_all_views(scene, features, recogniser, searched_targets(scene, settings.targets)))
    seconds["detections"] = time.monotonic() - started
    return detections


def _see_changed(
    settings: TrainConfig,
    material: TrainingData,
    detections: Sequence[DetectionTable],
    recogniser: Recogniser,
    seconds: dict[str, float],
) -> list[tuple[Observations, ...]]:
    started = time.monotonic()
    changed = [
        changed_observations(
            seen,
            material.backbone,
            recogniser,
            recogniser.threshold,
            settings.view_augmentation,
            settings.viewpoint_jitter_degrees,
            settings.seed,
        )
        for seen in detections
    ]
    seconds["changed views"] = time.monotonic() - started
    return changed


def _policy_stage(
    settings: TrainConfig,
    detections: Sequence[DetectionTable],
    changed: Sequence[tuple[Observations, ...]],
    recogniser: Recogniser,
    work: Path,
    seconds: dict[str, float],
) -> list[dict[str, float]]:
    training_tasks = policy_tasks(detections, recogniser.threshold, settings.rank, changed)
    return train_policy(settings, training_tasks, work, seconds)


PIPELINES: dict[SearchKind, Pipeline[Any]] = {
    "object": Pipeline(prepare, _train_for_objects),
    "view": Pipeline(prepare_views, train_for_views),
}
