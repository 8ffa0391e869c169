"""Training an agent, as a recipe: scenes and features, recogniser, policy, agent, measurement, card.

Each stage is resumable, and each is a file: `recogniser_stage`, `policy_stage`, `save_agent`, `model_card`; what is
different between the things that agents search for is in `object_pipeline` and `view_pipeline`.
"""

from __future__ import annotations

from pathlib import Path
from typing import Protocol

from active_perceiver.agent.config import AgentConfig, GoalName
from active_perceiver.evaluation.agent_evaluation import AgentEvaluation
from active_perceiver.policies.training_task import TrainingTask
from active_perceiver.training.config import TrainConfig
from active_perceiver.training.model_card import write_card
from active_perceiver.training.object_pipeline import ObjectPipeline
from active_perceiver.training.policy_stage import learner_config, train_policy
from active_perceiver.training.run_folder import RunFolder
from active_perceiver.training.training_result import RecogniserFigures, TrainingResult
from active_perceiver.training.view_pipeline import ViewPipeline
from active_perceiver.utils.result import write_result


class Pipeline(Protocol):
    """What is different between trainings for different goals."""

    def __init__(self, config: TrainConfig, run: RunFolder) -> None:
        """Open scenes and find features; what is wrong with the settings shows here, before anything is written."""

    def train_recogniser(self) -> RecogniserFigures | None:
        """Train what sees the goal, unless an earlier run has; None if nothing has to be trained for that."""
        ...

    def training_tasks(self) -> list[TrainingTask]:
        """Look at all views: what the policy is trained on, a task for each scene."""
        ...

    def save(self) -> AgentConfig:
        """Write what makes an agent of the networks."""
        ...

    def measure(self) -> AgentEvaluation:
        """Measure the agent in the scenes it was trained in."""
        ...


PIPELINES: dict[GoalName, type[Pipeline]] = {"object": ObjectPipeline, "view": ViewPipeline}


def train(config: TrainConfig, out: Path, *, force: bool = False, resume: bool = False) -> TrainingResult:
    """Train an agent and measure it.

    Everything is written to `OUT.part` first, which becomes `out` when all is done; an interrupted training leaves
    `OUT.part`, and `resume` goes on from the stage it was in.

    Args:
        config: what to train.
        out: folder of the agent.
        force: replace an agent that is there, and begin anew where one was interrupted.
        resume: go on with an interrupted training, with the same settings.

    Returns:
        What is in its `result.json`.

    Raises:
        OutputExistsError: if there is something already, and neither `force` nor `resume` says what to do.
        UserError: if the settings do not fit the scenes, or differ from those of the interrupted training.
    """
    learner_config(config)  # what is wrong with it shows before anything long begins
    run = RunFolder(config, out, force=force, resume=resume)
    with run.timed("total"):
        with run.timed("features"):
            pipeline = PIPELINES[config.task](config, run)
        run.begin()
        recogniser = pipeline.train_recogniser()
        tasks = pipeline.training_tasks()
        history = train_policy(config, tasks, run)
        agent = pipeline.save()
        evaluation = pipeline.measure()
    result = TrainingResult(evaluation, recogniser, history, config, run.seconds)
    write_result(run.path / "result.json", "train", result.to_json())
    write_card(run.path, agent, result)
    run.finish()
    return result
