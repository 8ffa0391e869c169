"""Training an agent as a whole: features, recogniser, policy, measurement; each stage resumable."""

from __future__ import annotations

import json
import time
from collections.abc import Iterable, Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from active_perceiver.agent_config import AgentConfig, SearchKind
from active_perceiver.experiments.assembling import agent_config, save_maps, save_pictures
from active_perceiver.experiments.changed_views import changed_observations
from active_perceiver.experiments.evaluating import measure_agent
from active_perceiver.experiments.model_card import write_card
from active_perceiver.experiments.result import write_result
from active_perceiver.experiments.searched import check_targets, check_taught, searched_targets
from active_perceiver.experiments.settings import EvaluateSettings, TrainSettings
from active_perceiver.experiments.sightings import Sightings, see_everywhere
from active_perceiver.experiments.stages import (
    Pipeline,
    features_of,
    learner_config,
    open_backbone,
    open_scenes,
    policy_problems,
    train_policy,
)
from active_perceiver.experiments.view_training import prepare_views, train_for_views
from active_perceiver.experiments.work_folder import begin, checked_work_folder, finish
from active_perceiver.files import replacing
from active_perceiver.perceiver import ActivePerceiver
from active_perceiver.progress import console, progress_bar
from active_perceiver.recognition.recogniser import Recogniser
from active_perceiver.recognition.training import CONFIGS, RecogniserConfig, TrainedRecogniser, train_recogniser
from active_perceiver.scenes import Scene
from active_perceiver.scenes.labelling import label_states
from active_perceiver.scenes.scene import PROPOSED, UNLABELLED
from active_perceiver.search.observations import Observations
from active_perceiver.vision.backbone import Backbone
from active_perceiver.vision.cache import SceneFeatures


@dataclass(frozen=True, eq=False)
class Material:
    """What training works on.

    Attributes:
        backbone: of the features.
        scenes: where is searched.
        features: of each of them.
        taught: what the recogniser is trained on; the same scenes unless the settings name others.
        taught_features: of each of those.
    """

    backbone: Backbone
    scenes: tuple[Scene, ...]
    features: tuple[SceneFeatures, ...]
    taught: tuple[Scene, ...]
    taught_features: tuple[SceneFeatures, ...]


def prepare(settings: TrainSettings) -> Material:
    """Open the scenes and compute, or find in the cache, their features.

    Raises:
        UserError: if a scene, a target or the backbone is not to be had, two scenes have the same name, or the
            recogniser would be trained with pictures that the scenes hold out.
    """
    scenes = open_scenes(settings.scenes)
    check_targets(scenes, settings.targets)
    taught = open_scenes(settings.recogniser_scenes) if settings.recogniser_scenes else scenes
    if taught is not scenes:
        for note in check_taught(scenes, taught, settings.targets):
            console.print(f"note: {note}", highlight=False)
    for warning in label_warnings(dict.fromkeys((*scenes, *taught))):
        console.print(f"warning: {warning}", highlight=False, soft_wrap=True)
    backbone = open_backbone(settings)
    features = tuple(features_of(scene, backbone) for scene in scenes)
    taught_features = features if taught is scenes else tuple(features_of(scene, backbone) for scene in taught)
    return Material(backbone, scenes, features, taught, taught_features)


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


def train_agent(settings: TrainSettings, out: Path, *, force: bool = False, resume: bool = False) -> dict[str, Any]:
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
    settings: TrainSettings, material: Material, work: Path, seconds: dict[str, float]
) -> tuple[AgentConfig, dict[str, Any]]:
    """Recogniser, policy and measurement of an agent that searches for objects; see `Pipeline.train`."""
    recogniser_metrics = _recogniser_stage(settings, material, work, seconds)
    recogniser = Recogniser(work / "recogniser.onnx")
    sightings = _see_all(settings, material, recogniser, seconds)
    changed = _see_changed(settings, material, sightings, recogniser, seconds)
    history = _policy_stage(settings, sightings, changed, recogniser, work, seconds)
    held_out_views = recogniser_metrics.pop("held_out_views")
    config = agent_config(settings, material.backbone, sightings, material.features, recogniser, held_out_views)
    config.save(work)
    save_maps(sightings, work)
    save_pictures(sightings, work)
    agent = ActivePerceiver.from_pretrained(work)
    with console.status("measuring"):
        body = measure_agent(agent, sightings, EvaluateSettings(seed=settings.seed))
    return config, body | {"recogniser": recogniser_metrics, "policy_history": history}


def measure_recogniser(settings: TrainSettings) -> dict[str, Any]:
    """Train a recogniser for its figures alone, for example the paper's beside the default one.

    Returns:
        See `_recogniser_figures`.
    """
    return _recogniser_figures(_train_recogniser(settings, prepare(settings)))


def _train_recogniser(settings: TrainSettings, material: Material) -> TrainedRecogniser:
    config = replace(CONFIGS[settings.recogniser], seed=settings.seed)
    if settings.recogniser_steps is not None:
        config = replace(config, steps=settings.recogniser_steps)
    return teach(material.taught, material.taught_features, material.backbone, config)


def teach(
    scenes: Sequence[Scene], features: Sequence[SceneFeatures], backbone: Backbone, config: RecogniserConfig
) -> TrainedRecogniser:
    """Train a recogniser, with a progress bar; see `train_recogniser`."""
    with progress_bar(f"{config.kind} recogniser") as report:
        return train_recogniser(
            scenes,
            features,
            config,
            lambda step, total, loss: report(step, total, f"loss {loss:.3f}"),
            backbone=backbone,
            further_progress=lambda done, total: report(done, total, "making further views and pictures"),
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
    settings: TrainSettings, material: Material, work: Path, seconds: dict[str, float]
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


def _held_out_views(material: Material, trained: TrainedRecogniser) -> dict[str, list[int]]:
    """For each scene, by name, the views that the recogniser was not trained on: all, if it was trained elsewhere."""
    taught = zip(material.taught, trained.validation_views, strict=True)
    held_out = {scene.content_hash: views for scene, views in taught}
    return {
        scene.name: np.flatnonzero(held_out.get(scene.content_hash, np.ones(len(scene)))).tolist()
        for scene in material.scenes
    }


def _see_all(
    settings: TrainSettings, material: Material, recogniser: Recogniser, seconds: dict[str, float]
) -> list[Sightings]:
    started = time.monotonic()
    sightings = []
    for scene, features in zip(material.scenes, material.features, strict=True):
        sightings.append(see_everywhere(scene, features, recogniser, searched_targets(scene, settings.targets)))
    seconds["detections"] = time.monotonic() - started
    return sightings


def _see_changed(
    settings: TrainSettings,
    material: Material,
    sightings: Sequence[Sightings],
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
            settings.changed_views,
            settings.changed_degrees,
            settings.seed,
        )
        for seen in sightings
    ]
    seconds["changed views"] = time.monotonic() - started
    return changed


def _policy_stage(
    settings: TrainSettings,
    sightings: Sequence[Sightings],
    changed: Sequence[tuple[Observations, ...]],
    recogniser: Recogniser,
    work: Path,
    seconds: dict[str, float],
) -> list[dict[str, float]]:
    problems = policy_problems(sightings, recogniser.threshold, settings.rank, changed)
    return train_policy(settings, problems, work, seconds)


PIPELINES: dict[SearchKind, Pipeline[Any]] = {
    "object": Pipeline(prepare, _train_for_objects),
    "view": Pipeline(prepare_views, train_for_views),
}
