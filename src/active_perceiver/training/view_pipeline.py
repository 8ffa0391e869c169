"""Training an agent that searches for views of its scenes (Zhu et al., ICRA 2017): features and policy, no more."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

from active_perceiver.agent.config import AgentConfig
from active_perceiver.agent.perceiver import ActivePerceiver
from active_perceiver.envs.view_task import view_task
from active_perceiver.errors import UserError
from active_perceiver.evaluation.agent_scenes import features_of
from active_perceiver.evaluation.config import EvaluateConfig
from active_perceiver.evaluation.view_metrics import measure_view_agent
from active_perceiver.evaluation.view_selection import ViewSearches, chosen_states
from active_perceiver.training.common import open_backbone, open_scenes, train_policy
from active_perceiver.training.config import TrainConfig
from active_perceiver.training.save_agent import save_views, view_agent_config
from active_perceiver.utils.progress import console
from active_perceiver.vision.backbone import Backbone

OF_OBJECTS = ("recogniser", "recogniser_scenes", "recogniser_steps", "rank")
"""Settings that say nothing about a search for views."""


@dataclass(frozen=True, eq=False)
class ViewTrainingData:
    """What training works on.

    Attributes:
        backbone: of the features.
        searches: for each scene, what is searched for there.
    """

    backbone: Backbone
    searches: tuple[ViewSearches, ...]


def prepare_views(settings: TrainConfig) -> ViewTrainingData:
    """Open the scenes, choose the views, and compute, or find in the cache, the features.

    Raises:
        UserError: if a scene, a view or the backbone is not to be had, or something is said of a recogniser.
    """
    for name in OF_OBJECTS:
        if getattr(settings, name) != getattr(TrainConfig, name):
            raise UserError(f"--task view has no recogniser and no boxes; leave --{name.replace('_', '-')} out")
    scenes = open_scenes(settings.scenes)
    states = chosen_states(scenes, settings.targets, settings.seed)
    for scene, chosen in zip(scenes, states, strict=True):
        view_task(scene, chosen)  # what is wrong with them shows before the features take their time
    backbone = open_backbone(settings)
    searches = (
        ViewSearches(scene, chosen, features_of(scene, backbone).view_features)
        for scene, chosen in zip(scenes, states, strict=True)
    )
    return ViewTrainingData(backbone, tuple(searches))


def train_for_views(
    settings: TrainConfig, material: ViewTrainingData, work: Path, seconds: dict[str, float]
) -> tuple[AgentConfig, dict[str, Any]]:
    """Policy and measurement of an agent that searches for views; see `Pipeline.train`."""
    history = train_policy(settings, [one.training_task for one in material.searches], work, seconds)
    config = view_agent_config(settings, material.backbone, material.searches)
    config.save(work)
    save_views(material.searches, work)
    agent = ActivePerceiver.from_pretrained(work)
    with console.status("measuring"):
        body = measure_view_agent(agent, material.searches, EvaluateConfig(seed=settings.seed))
    return config, body | {"policy_history": history}
