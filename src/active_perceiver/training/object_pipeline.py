"""Training an agent that searches for objects: see `train.Pipeline`."""

from __future__ import annotations

from functools import cached_property

from active_perceiver.agent.config import AgentConfig
from active_perceiver.agent.perceiver import ActivePerceiver
from active_perceiver.envs.observations import Observations
from active_perceiver.evaluation.agent_evaluation import AgentEvaluation
from active_perceiver.evaluation.config import EvaluateConfig
from active_perceiver.evaluation.detections import DetectionTable, detect_all_views
from active_perceiver.evaluation.object_measures import measure_agent
from active_perceiver.policies.training_task import TrainingTask
from active_perceiver.recognition.recogniser import Recogniser
from active_perceiver.training.config import TrainConfig
from active_perceiver.training.policy_augmentation import changed_observations
from active_perceiver.training.policy_stage import policy_tasks
from active_perceiver.training.recogniser_stage import prepare_objects, train_recogniser_stage
from active_perceiver.training.run_folder import RunFolder
from active_perceiver.training.save_agent import agent_config, save_maps, save_pictures
from active_perceiver.training.target_selection import searched_targets
from active_perceiver.training.training_result import RecogniserFigures
from active_perceiver.utils.progress import console


class ObjectPipeline:
    """The stages of a training for objects: a recogniser, what it sees in all views, a policy led by that."""

    def __init__(self, config: TrainConfig, run: RunFolder) -> None:
        self._config, self._run = config, run
        self._data = prepare_objects(config)

    def train_recogniser(self) -> RecogniserFigures:
        """Train the recogniser, unless an earlier run has."""
        figures, self._held_out_views = train_recogniser_stage(self._config, self._data, self._run)
        return figures

    def training_tasks(self) -> list[TrainingTask]:
        """Let the recogniser look at all views, and at changed copies of them for the policy."""
        with self._run.timed("detections"):
            self._detections = self._detect()
        with self._run.timed("changed views"):
            changed = self._detect_in_augmented_views()
        return policy_tasks(self._detections, self._recogniser.threshold, self._config.rank, changed)

    def save(self) -> AgentConfig:
        """Write what makes an agent of the networks."""
        config = agent_config(
            self._config, self._data.backbone, self._detections, self._data.features, self._recogniser,
            self._held_out_views,
        )  # fmt: skip
        config.save(self._run.path)
        save_maps(self._detections, self._run.path)
        save_pictures(self._detections, self._run.path)
        return config

    def measure(self) -> AgentEvaluation:
        """Measure the agent in the scenes it was trained in."""
        agent = ActivePerceiver.from_pretrained(self._run.path)
        with console.status("measuring"):
            return measure_agent(agent, self._detections, EvaluateConfig(seed=self._config.seed))

    @cached_property
    def _recogniser(self) -> Recogniser:
        return Recogniser(self._run.path / "recogniser.onnx")

    def _detect(self) -> list[DetectionTable]:
        scenes = zip(self._data.scenes, self._data.features, strict=True)
        return [
            detect_all_views(scene, features, self._recogniser, searched_targets(scene, self._config.targets))
            for scene, features in scenes
        ]

    def _detect_in_augmented_views(self) -> list[tuple[Observations, ...]]:
        return [
            changed_observations(
                seen,
                self._data.backbone,
                self._recogniser,
                self._recogniser.threshold,
                self._config.view_augmentation,
                self._config.viewpoint_jitter_degrees,
                self._config.seed,
            )
            for seen in self._detections
        ]
