"""An agent with random weights, put together as training does: what it does means nothing, how long it takes does."""

from __future__ import annotations

import shutil
from collections.abc import Sequence
from pathlib import Path

import torch

from active_perceiver.agent.config import AgentConfig, KnownTarget, picture_folder
from active_perceiver.agent.perceiver import ActivePerceiver
from active_perceiver.policies.export import export_policy
from active_perceiver.policies.network import PolicyNetwork
from active_perceiver.recognition.export import export_recogniser
from active_perceiver.recognition.network import RECOGNISERS
from active_perceiver.scenes import Scene
from active_perceiver.scenes.images import image_suffix
from active_perceiver.vision.backbone import FILE_NAME, Backbone


def save_untrained_agent(
    folder: Path, backbone: Backbone, scene: Scene, targets: Sequence[str], recogniser: str = "matching"
) -> None:
    """Write the folder of an agent that was never trained.

    Args:
        folder: where; made if it is not there.
        backbone: its feature extractor, copied into the folder.
        scene: its one policy branch.
        targets: names of what it knows.
        recogniser: kind, a name in `RECOGNISERS`.
    """
    folder.mkdir(parents=True, exist_ok=True)
    if backbone.path != folder / FILE_NAME:
        shutil.copyfile(backbone.path, folder / FILE_NAME)
    shape = (backbone.channels, backbone.map_size, backbone.map_size)
    actions = [action.value for action in scene.actions]
    with torch.random.fork_rng():
        torch.manual_seed(0)
        export_recogniser(RECOGNISERS[recogniser](shape), folder / "recogniser.onnx", 0.0, backbone.fingerprint)
        export_policy(PolicyNetwork(backbone.channels, {scene.name: actions}), folder / "policy.onnx", force=True)
    for name in targets:
        target = scene.targets[scene.target_index(name)]
        pictures = picture_folder(folder, scene.name, name)
        pictures.mkdir(parents=True, exist_ok=True)
        for number, data in enumerate(target.pictures[: target.trained]):
            (pictures / f"{number:02}.{image_suffix(data)}").write_bytes(data)
    AgentConfig(
        backbone=backbone.name,
        image_size=backbone.image_size,
        recogniser=recogniser,
        score_threshold=0.0,  # it sees something in every view, so that all there is to compute is computed
        branches={scene.name: actions},
        targets=[KnownTarget(scene.name, name) for name in targets],
        stop_area_threshold=1.0,
        match_threshold=1.0,
    ).save(folder)
    ActivePerceiver(folder, AgentConfig.load(folder), backbone).gallery.save_pictures()
