"""Training an agent as a whole: features, recogniser, policy, measurement; each stage resumable."""

from __future__ import annotations

import json
import shutil
import time
from collections.abc import Sequence
from dataclasses import asdict, dataclass, fields, replace
from pathlib import Path
from typing import Any

import numpy as np

from active_perceiver import __version__
from active_perceiver.errors import UserError
from active_perceiver.experiments.assembling import agent_config, save_pictures
from active_perceiver.experiments.evaluating import measure_agent
from active_perceiver.experiments.model_card import write_card
from active_perceiver.experiments.result import write_result
from active_perceiver.experiments.searched import check_targets, check_taught, searched_targets
from active_perceiver.experiments.settings import EvaluateSettings, TrainSettings
from active_perceiver.experiments.sightings import Sightings, see_everywhere
from active_perceiver.files import OutputExistsError, replacing
from active_perceiver.perceiver import ActivePerceiver
from active_perceiver.policies import LEARNERS, learner_named
from active_perceiver.policies.config import LearnerConfig
from active_perceiver.policies.problem import Problem
from active_perceiver.progress import console, progress_bar
from active_perceiver.recognition.recogniser import Recogniser
from active_perceiver.recognition.training import CONFIGS, TrainedRecogniser, train_recogniser
from active_perceiver.scenes import Scene, open_scene
from active_perceiver.search.task import SearchTask
from active_perceiver.vision.backbone import Backbone, load_backbone
from active_perceiver.vision.cache import SceneFeatures, scene_features


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
    scenes = _open_scenes(settings.scenes)
    check_targets(scenes, settings.targets)
    taught = _open_scenes(settings.recogniser_scenes) if settings.recogniser_scenes else scenes
    if taught is not scenes:
        for note in check_taught(scenes, taught, settings.targets):
            console.print(f"note: {note}", highlight=False)
    with console.status(f"backbone {settings.backbone}; the first time it is converted, which takes half a minute"):
        backbone = load_backbone(settings.backbone, image_size=settings.image_size)
    features = _features(scenes, backbone)
    return Material(backbone, scenes, features, taught, features if taught is scenes else _features(taught, backbone))


def _open_scenes(sources: Sequence[str]) -> tuple[Scene, ...]:
    scenes = tuple(open_scene(source) for source in sources)
    names = [scene.name for scene in scenes]
    if not names or len(set(names)) != len(names):
        raise UserError(f"training needs scenes of different names, at least one; got {names}")
    return scenes


def _features(scenes: Sequence[Scene], backbone: Backbone) -> tuple[SceneFeatures, ...]:
    features = []
    for scene in scenes:
        with progress_bar(f"features of {scene.name}") as report:
            features.append(scene_features(scene, backbone, report))
    return tuple(features)


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
    _learner_config(settings)
    work = out.with_name(f"{out.name}.part")
    _check_output(settings, out, work, force=force, resume=resume)
    seconds: dict[str, float] = {}
    started = time.monotonic()
    material = prepare(settings)
    _begin(settings, work, resume=resume)
    seconds["features"] = time.monotonic() - started
    recogniser_metrics = _recogniser_stage(settings, material, work, seconds)
    recogniser = Recogniser(work / "recogniser.onnx")
    sightings = _see_all(settings, material, recogniser, seconds)
    history = _policy_stage(settings, sightings, recogniser, work, seconds)
    held_out_views = recogniser_metrics.pop("held_out_views")
    agent_config(settings, material.backbone, sightings, recogniser, held_out_views).save(work)
    save_pictures(sightings, work)
    agent = ActivePerceiver.from_pretrained(work)
    with console.status("measuring"):
        body = measure_agent(agent, sightings, EvaluateSettings(seed=settings.seed))
    body |= {
        "settings": asdict(settings),
        "recogniser": recogniser_metrics,
        "policy_history": history,
        "seconds": {**seconds, "total": time.monotonic() - started},
    }
    write_result(work / "result.json", "train", body)
    write_card(work, agent.config, body)
    (work / "settings.json").unlink()
    if out.exists():
        shutil.rmtree(out)
    work.rename(out)
    return body


def measure_recogniser(settings: TrainSettings) -> dict[str, Any]:
    """Train a recogniser for its figures alone, for example the paper's beside the default one.

    Returns:
        See `_recogniser_figures`.
    """
    return _recogniser_figures(_train_recogniser(settings, prepare(settings)))


def _noted_settings(settings: TrainSettings) -> str:
    """What `settings.json` in the folder of a training in progress holds."""
    return json.dumps({"version": __version__, **asdict(settings)}, indent=2)


def _check_output(settings: TrainSettings, out: Path, work: Path, *, force: bool, resume: bool) -> None:
    """Make sure that nothing is in the way but what may be replaced, and that it is ours to replace."""
    if out.exists() and not force:
        raise OutputExistsError(f"{out} exists; give another --out, or --force to replace it")
    for folder, sign in ((out, "config.json"), (work, "settings.json")):
        if folder.exists() and not (folder / sign).is_file() and (not folder.is_dir() or any(folder.iterdir())):
            raise OutputExistsError(f"{folder} is not an agent and will not be replaced; give another --out")
    if (work / "settings.json").is_file() and resume:
        if (work / "settings.json").read_text() != _noted_settings(settings):
            raise UserError(f"{work} was begun with other settings; give the same ones, or --force to begin anew")
    elif work.exists() and not force:
        raise OutputExistsError(f"{work} is an interrupted training; --resume goes on, --force begins anew")


def _begin(settings: TrainSettings, work: Path, *, resume: bool) -> None:
    """Make or keep the folder of the training in progress, and note the settings in it."""
    if work.exists() and not resume:
        shutil.rmtree(work)
    work.mkdir(parents=True, exist_ok=True)
    with replacing(work / "settings.json") as temporary:
        temporary.write_text(_noted_settings(settings))


def _train_recogniser(settings: TrainSettings, material: Material) -> TrainedRecogniser:
    config = replace(CONFIGS[settings.recogniser], seed=settings.seed)
    if settings.recogniser_steps is not None:
        config = replace(config, steps=settings.recogniser_steps)
    with progress_bar(f"{settings.recogniser} recogniser") as report:
        return train_recogniser(
            material.taught,
            material.taught_features,
            config,
            lambda step, total, loss: report(step, total, f"loss {loss:.3f}"),
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


def _policy_stage(
    settings: TrainSettings,
    sightings: Sequence[Sightings],
    recogniser: Recogniser,
    work: Path,
    seconds: dict[str, float],
) -> list[dict[str, float]]:
    """Train the policy on what the recogniser really sees, with the pictures that it was trained on too."""
    from active_perceiver.policies.export import export_policy, save_network

    config = _learner_config(settings)
    problems = []
    for seen in sightings:
        task = SearchTask.from_scene(seen.scene, seen.names, settings.rank)
        for warning in task.warnings:
            console.print(f"note: {warning}", highlight=False)
        problems.append(Problem(task, seen.observations(recogniser.threshold, seen.trained_pictures)))
    started = time.monotonic()
    with progress_bar(f"policy by {settings.learner}") as report:
        network, history = LEARNERS[settings.learner].train(
            problems, config, lambda record: report(*_policy_progress(record, config))
        )
    seconds["policy"] = time.monotonic() - started
    export_policy(network, work / "policy.onnx", force=True)
    save_network(network, work / "policy.safetensors", force=True)
    return history


def _learner_config(settings: TrainSettings) -> LearnerConfig:
    """The learner's own defaults, with what the settings say otherwise.

    Raises:
        UserError: if they say something that this learner cannot be told.
    """
    learner = learner_named(settings.learner)
    given: dict[str, Any] = {
        "reward": settings.reward,
        "entropy_weight": settings.entropy_weight,
        "seconds": settings.policy_seconds,
    }
    given = {name: value for name, value in given.items() if value is not None}
    known = {field.name for field in fields(learner.config)}
    if unknown := given.keys() - known:
        raise UserError(f"the learner {learner.name} has no {', '.join(unknown)}; leave it out, or use --learner ppo")
    return learner.config(seed=settings.seed, **given)


def _policy_progress(record: dict[str, float], config: LearnerConfig) -> tuple[int, int, str]:
    note = f"success {record['success']:.3f}, {record['ratio']:.3f} x the shortest paths"
    return int(record["iteration"]), config.iterations, note
