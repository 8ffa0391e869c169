"""The stages that every training has, whatever is searched for: scenes and features first, the policy last."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any, Generic, TypeVar

from active_perceiver.agent.config import AgentConfig, SearchKind
from active_perceiver.envs.observations import Observations
from active_perceiver.envs.task import SearchTask
from active_perceiver.errors import UserError
from active_perceiver.evaluation.detections import DetectionTable
from active_perceiver.policies.config import LearnerConfig
from active_perceiver.policies.learners import LEARNERS, learner_named
from active_perceiver.policies.training_task import TrainingTask
from active_perceiver.scenes import Scene, open_scene
from active_perceiver.training.config import TrainConfig
from active_perceiver.utils.progress import console, progress_bar
from active_perceiver.vision.backbone import Backbone, load_backbone

TrainingData = TypeVar("TrainingData")

DEFAULT_REWARDS: dict[SearchKind, str | None] = {"object": None, "view": "goal"}
"""What the policy is paid for if the settings do not say it; None for the learner's own default."""


@dataclass(frozen=True)
class Pipeline(Generic[TrainingData]):
    """How agents of one kind are trained.

    Attributes:
        prepare: opens scenes and finds features; what is wrong with the settings shows here, before anything is
            written.
        train: trains into a folder, and adds what each stage took to the seconds. Returns the agent's configuration
            and the body of its result.
    """

    prepare: Callable[[TrainConfig], TrainingData]
    train: Callable[[TrainConfig, TrainingData, Path, dict[str, float]], tuple[AgentConfig, dict[str, Any]]]


def open_scenes(sources: Sequence[str]) -> tuple[Scene, ...]:
    """Open scenes to train in.

    Raises:
        UserError: if one cannot be opened, there are none, or two have the same name.
    """
    scenes = tuple(open_scene(source) for source in sources)
    names = [scene.name for scene in scenes]
    if not names or len(set(names)) != len(names):
        raise UserError(f"training needs scenes of different names, at least one; got {names}")
    return scenes


def open_backbone(settings: TrainConfig) -> Backbone:
    """The backbone that the settings name."""
    with console.status(f"backbone {settings.backbone}; the first time it is converted, which takes half a minute"):
        return load_backbone(settings.backbone, image_size=settings.image_size)


def policy_tasks(
    detections: Sequence[DetectionTable],
    threshold: float,
    rank: int,
    changed: Sequence[tuple[Observations, ...]] = (),
) -> list[TrainingTask]:
    """What a policy is trained on: what the recogniser really sees, with the pictures that it was trained on too.

    Args:
        detections: in each scene.
        threshold: presence probability from which on a detection counts.
        rank: goal states are those whose box is at least as large as the `rank`-th largest.
        changed: for each of them, see `TrainingTask.changed`; none if not given.
    """
    return [
        TrainingTask(
            SearchTask.from_scene(seen.scene, seen.names, rank),
            seen.observations(threshold, seen.trained_pictures),
            also,
        )
        for seen, also in zip(detections, changed or [()] * len(detections), strict=True)
    ]


def learner_config(settings: TrainConfig) -> LearnerConfig:
    """The learner's own defaults, with what the settings say otherwise.

    Raises:
        UserError: if they say something that this learner cannot be told.
    """
    learner = learner_named(settings.learner)
    known = {field.name for field in fields(learner.config)}
    default_reward = DEFAULT_REWARDS[settings.task] if "reward" in known else None
    given: dict[str, Any] = {
        "reward": settings.reward or default_reward,
        "entropy_weight": settings.entropy_weight,
        "seconds": settings.policy_seconds,
    }
    given = {name: value for name, value in given.items() if value is not None}
    if unknown := given.keys() - known:
        raise UserError(f"the learner {learner.name} has no {', '.join(unknown)}; leave it out, or use --learner ppo")
    return learner.config(seed=settings.seed, **given)


def train_policy(
    settings: TrainConfig, training_tasks: Sequence[TrainingTask], work: Path, seconds: dict[str, float]
) -> list[dict[str, float]]:
    """Train the policy for some problems, and write it into the folder.

    A learner that takes long keeps its state there, and goes on with what an interrupted training left.

    Returns:
        The learner's history.
    """
    from active_perceiver.policies.export import export_policy, save_network

    config = learner_config(settings)
    for training_task in training_tasks:
        for warning in training_task.task.warnings:
            console.print(f"note: {warning}", highlight=False)
    started = time.monotonic()
    checkpoint = work / "policy.checkpoint"
    with progress_bar(f"policy by {settings.learner}") as report:
        network, history = LEARNERS[settings.learner].train(training_tasks, config, report, checkpoint=checkpoint)
    seconds["policy"] = time.monotonic() - started
    export_policy(network, work / "policy.onnx", force=True)
    save_network(network, work / "policy.safetensors", force=True)
    checkpoint.unlink(missing_ok=True)
    return history
