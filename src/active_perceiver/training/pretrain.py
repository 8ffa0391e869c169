"""Training the weights that recognisers of other rooms start from: `active-perceiver pretrain`."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from active_perceiver.evaluation.agent_scenes import features_of
from active_perceiver.recognition.export import save_network
from active_perceiver.recognition.train import CONFIGS
from active_perceiver.training.config import TrainConfig
from active_perceiver.training.inputs import open_backbone, open_scenes
from active_perceiver.training.recogniser_stage import train_scene_recogniser
from active_perceiver.utils.files import check_output

STEPS = 4000
VIEWS = 32


def pretrain(sources: Sequence[str], out: Path, *, steps: int = STEPS, seed: int = 0, force: bool = False) -> float:
    """Train a matching recogniser on all views of some scenes, and write its weights.

    Nothing is held out for judging: how good the weights are shows in other rooms.

    Args:
        sources: scenes, bundled names or files.
        out: the safetensors file.
        steps: of training.
        seed: everything random follows from it.
        force: replace an existing file.

    Returns:
        Seconds of training.

    Raises:
        OutputExistsError: if the file exists and `force` is false.
        UserError: if a scene cannot be opened.
    """
    check_output(out, force)
    scenes = open_scenes(sources)
    backbone = open_backbone(TrainConfig())
    features = [features_of(scene, backbone) for scene in scenes]
    config = replace(CONFIGS["matching"], start="scratch", held_out_places=0.0, steps=steps, views=VIEWS, seed=seed)
    trained = train_scene_recogniser(scenes, features, backbone, config)
    save_network(trained.network, out)
    return trained.seconds
