"""Search problems for tests: toy scenes whose features are random Fourier features of the pose."""

import numpy as np

from active_perceiver.envs import Observations, SearchTask
from active_perceiver.policies.training_task import TrainingTask
from helpers.toy import toy_scene


def pose_features(scene, width, rng, noise=0.2):
    """(S, width) float32, positive like pooled backbone features: smooth in the pose, with noise of their own."""
    heading = np.radians(scene.poses[:, 2])
    pose = np.column_stack(
        [scene.poses[:, :2], np.cos(heading), np.sin(heading), scene.poses[:, 3] / 30, np.ones(len(scene))]
    )
    waves = np.cos(pose @ rng.normal(size=(6, width)) + rng.uniform(0, 2 * np.pi, width))
    return (np.maximum(0, waves) + noise * np.abs(rng.normal(size=waves.shape))).astype(np.float32)


def toy_task(seed=0, side=3, targets=2, width=48, pictures=2, mask_errors=0.05, **options):
    """A search whose recogniser errs in some masks."""
    scene = toy_scene(seed, side=side, targets=targets, image_size=24, **options)
    rng = np.random.default_rng(seed)
    shown = np.abs(rng.normal(size=(targets, 1, width))) + 0.2 * rng.normal(size=(targets, pictures, width))
    exact = Observations.from_boxes(pose_features(scene, width, rng), shown.astype(np.float32), scene.boxes)
    wrong = rng.random(exact.masks.shape[:3]) < mask_errors
    masks = np.where(wrong[..., None], 1 - exact.masks, exact.masks)
    return TrainingTask(SearchTask.from_scene(scene), Observations(exact.view_features, exact.target_features, masks))


def random_table(task, seed=0, sharpness=1.0):
    """A random policy table (S, T, A) that tends towards the goals, so that searches end."""
    rng = np.random.default_rng(seed)
    better = task.steps[task.transitions] < task.steps[:, None]  # (S, A, T)
    logits = rng.normal(size=better.shape) * sharpness + 1.5 * better
    table = np.exp(logits - logits.max(axis=1, keepdims=True)).transpose(0, 2, 1)
    return (table / table.sum(axis=-1, keepdims=True)).astype(np.float32)
