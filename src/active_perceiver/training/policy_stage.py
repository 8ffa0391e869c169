"""The last stage of every training: the policy, whatever is searched for."""

from __future__ import annotations

import logging
from collections.abc import Sequence
from dataclasses import fields
from typing import Any

from active_perceiver.agent.goals import GOALS
from active_perceiver.envs.observations import Observations
from active_perceiver.envs.task import SearchTask
from active_perceiver.errors import UserError
from active_perceiver.evaluation.detections import DetectionTable
from active_perceiver.policies.config import LearnerConfig
from active_perceiver.policies.learners import LEARNERS, learner_named
from active_perceiver.policies.training_task import TrainingTask
from active_perceiver.training.config import TrainConfig
from active_perceiver.training.run_folder import RunFolder
from active_perceiver.utils.progress import progress_bar

LOG = logging.getLogger(__name__)


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


def learner_config(config: TrainConfig) -> LearnerConfig:
    """The learner's own defaults, with what a training says otherwise.

    Raises:
        UserError: if it says something that this learner cannot be told.
    """
    learner = learner_named(config.learner)
    known = {field.name for field in fields(learner.config)}
    default_reward = GOALS[config.task].default_reward if "reward" in known else None
    given: dict[str, Any] = {
        "reward": config.reward or default_reward,
        "entropy_weight": config.entropy_weight,
        "seconds": config.policy_seconds,
    }
    given = {name: value for name, value in given.items() if value is not None}
    if unknown := given.keys() - known:
        raise UserError(f"the learner {learner.name} has no {', '.join(unknown)}; leave it out, or use --learner ppo")
    return learner.config(seed=config.seed, **given)


def train_policy(
    config: TrainConfig, training_tasks: Sequence[TrainingTask], run: RunFolder
) -> list[dict[str, float]]:
    """Train the policy, and write it into the folder.

    A learner that takes long keeps its state there, and goes on with what an interrupted training left.

    Returns:
        The learner's history.
    """
    from active_perceiver.policies.export import export_policy, save_network

    learning = learner_config(config)
    for training_task in training_tasks:
        for warning in training_task.task.warnings:
            LOG.info("note: %s", warning)
    checkpoint = run.path / "policy.checkpoint"
    with run.timed("policy"), progress_bar(f"policy by {config.learner}") as report:
        network, history = LEARNERS[config.learner].train(training_tasks, learning, report, checkpoint=checkpoint)
    export_policy(network, run.path / "policy.onnx", force=True)
    save_network(network, run.path / "policy.safetensors", force=True)
    checkpoint.unlink(missing_ok=True)
    return history
