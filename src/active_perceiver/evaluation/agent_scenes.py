"""The scenes that an agent was trained in, opened again to measure it there."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from active_perceiver.agent.perceiver import ActivePerceiver
from active_perceiver.errors import UserError
from active_perceiver.scenes import Scene, open_scene
from active_perceiver.utils.progress import progress_bar
from active_perceiver.vision.backbone import Backbone
from active_perceiver.vision.cache import SceneFeatures, scene_features


def agent_scenes(
    agent: ActivePerceiver, sources: Mapping[str, str] | None = None
) -> Iterator[tuple[Scene, list[str]]]:
    """Each of an agent's scenes with the names of the targets it was trained for there.

    Args:
        agent: whose record names the scenes.
        sources: scene -> name or file, where one is to be opened from elsewhere.

    Raises:
        SceneError: if one of them is no longer there.
        UserError: if there is another one in its place.
    """
    for branch, recorded in zip(agent.config.branches, agent.config.training.scenes, strict=True):
        source = (sources or {}).get(branch, recorded)
        scene = open_scene(source)
        if scene.name not in agent.config.branches:
            raise UserError(f"the agent was trained in {list(agent.config.branches)}, but {source} is '{scene.name}'")
        yield scene, [target.name for target in agent.config.targets if target.scene == scene.name]


def features_of(scene: Scene, backbone: Backbone) -> SceneFeatures:
    """A scene's features, with a progress bar."""
    with progress_bar(f"features of {scene.name}") as report:
        return scene_features(scene, backbone, report)
