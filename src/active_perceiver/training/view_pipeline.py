"""Training an agent that searches for views of its scenes (Zhu et al., ICRA 2017): see `train.Pipeline`."""

from __future__ import annotations

from active_perceiver.agent.config import AgentConfig
from active_perceiver.agent.perceiver import ActivePerceiver
from active_perceiver.envs.view_task import view_task
from active_perceiver.errors import UserError
from active_perceiver.evaluation.agent_evaluation import AgentEvaluation
from active_perceiver.evaluation.agent_scenes import features_of
from active_perceiver.evaluation.config import EvaluateConfig
from active_perceiver.evaluation.view_measures import measure_view_agent
from active_perceiver.evaluation.view_selection import ViewSearches, chosen_states
from active_perceiver.policies.training_task import TrainingTask
from active_perceiver.training.config import TrainConfig
from active_perceiver.training.inputs import open_backbone, open_scenes
from active_perceiver.training.run_folder import RunFolder
from active_perceiver.training.save_agent import save_views, view_agent_config
from active_perceiver.utils.progress import console

OF_OBJECTS = ("recogniser", "recogniser_scenes", "recogniser_steps", "rank")
"""Settings that say nothing about a search for views."""


class ViewPipeline:
    """The stages of a training for views: features and a policy, no more.

    Raises:
        UserError: if a scene, a view or the backbone is not to be had, or something is said of a recogniser.
    """

    def __init__(self, config: TrainConfig, run: RunFolder) -> None:
        self._config, self._run = config, run
        for name in OF_OBJECTS:
            if getattr(config, name) != getattr(TrainConfig, name):
                raise UserError(f"--task view has no recogniser and no boxes; leave --{name.replace('_', '-')} out")
        scenes = open_scenes(config.scenes)
        states = chosen_states(scenes, config.targets, config.seed)
        for scene, chosen in zip(scenes, states, strict=True):
            view_task(scene, chosen)  # what is wrong with them shows before the features take their time
        self._backbone = open_backbone(config)
        self._searches = tuple(
            ViewSearches(scene, chosen, features_of(scene, self._backbone).view_features)
            for scene, chosen in zip(scenes, states, strict=True)
        )

    def train_recogniser(self) -> None:
        """Do nothing: views are compared by their features."""

    def training_tasks(self) -> list[TrainingTask]:
        """What the policy is trained on."""
        return [one.training_task for one in self._searches]

    def save(self) -> AgentConfig:
        """Write what makes an agent of the policy."""
        config = view_agent_config(self._config, self._backbone, self._searches)
        config.save(self._run.path)
        save_views(self._searches, self._run.path)
        return config

    def measure(self) -> AgentEvaluation:
        """Measure the agent in the scenes it was trained in."""
        agent = ActivePerceiver.from_pretrained(self._run.path)
        with console.status("measuring"):
            return measure_view_agent(agent, self._searches, EvaluateConfig(seed=self._config.seed))
