"""The small trained agent that the tests share: they copy what is committed in `tests/data/toy_agent`.

Made again, after a change of what an agent's folder holds or of `toy_scene`, by

    PYTHONPATH=tests python -m helpers.toy_agent
"""

from __future__ import annotations

import shutil
import tempfile
from dataclasses import replace
from pathlib import Path
from unittest import mock

from active_perceiver.policies.config import LearnerConfig
from active_perceiver.scenes import save_scene
from active_perceiver.training import policy_stage
from active_perceiver.training.config import TrainConfig
from active_perceiver.training.train import train
from helpers.toy import toy_scene

FOLDER = Path(__file__).parents[1] / "data" / "toy_agent"
SCENE = "/data/toy_0.h5"
"""Stands in the agent's files for the path of the scene's file, wherever that is."""
HIDDEN = 32
"""Width of the policy's layers; 512 of a real one would take 6 MB."""
LEFT_OUT = ("recogniser.safetensors",)
"""Weights to train on with, 1 MB, which nothing needs to run it."""


def train_config(scene_file: Path) -> TrainConfig:
    """A training of seconds that finds the balls of the toy scene."""
    return TrainConfig(scenes=(str(scene_file),), recogniser_steps=120, image_size=96, viewpoint_jitter_degrees=10.0)


def make(folder: Path = FOLDER) -> None:
    """Train the agent, and put it in the place of the one that is there."""
    configured = policy_stage.learner_config

    def narrow(settings: TrainConfig) -> LearnerConfig:
        return replace(configured(settings), hidden=HIDDEN)

    with tempfile.TemporaryDirectory() as name:
        scene_file, made = Path(name) / "toy_0.h5", Path(name) / "agent"
        save_scene(toy_scene(), scene_file)
        with mock.patch.object(policy_stage, "learner_config", narrow):
            train(train_config(scene_file), made)
        for left_out in LEFT_OUT:
            (made / left_out).unlink()
        _rename_scene(made, str(scene_file), SCENE)
        shutil.rmtree(folder, ignore_errors=True)
        shutil.copytree(made, folder)


def copy(folder: Path, scene_file: Path) -> Path:
    """Copy the agent into a folder that is not there yet, as one that was trained on this file of the toy scene."""
    shutil.copytree(FOLDER, folder)
    _rename_scene(folder, SCENE, str(scene_file))
    return folder


def _rename_scene(folder: Path, before: str, after: str) -> None:
    for path in (*folder.glob("*.json"), folder / "README.md"):
        path.write_text(path.read_text().replace(before, after))


if __name__ == "__main__":
    make()
