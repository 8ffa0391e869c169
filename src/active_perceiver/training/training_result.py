"""What a training gives besides the agent: how good it is, how it was learned, what that took."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass
from typing import Any

from active_perceiver.evaluation.agent_evaluation import AgentEvaluation
from active_perceiver.recognition.train import TrainedRecogniser
from active_perceiver.training.config import TrainConfig

PROTOCOL = (
    "views of places not trained in; objects of at least 0.3 % of the image count as there, smaller ones neither as "
    "there nor as absent"
)


@dataclass(frozen=True)
class RecogniserFigures:
    """How good a recogniser is in places it was not trained in, and how it was trained.

    Attributes:
        metrics: as `TrainedRecogniser.metrics`, each the fields of a `RecognitionMetrics`.
        config: the fields of its `RecogniserConfig`.
        seconds: of its training.
    """

    metrics: Mapping[str, Mapping[str, Any]]
    config: Mapping[str, Any]
    seconds: float

    @classmethod
    def of(cls, trained: TrainedRecogniser) -> RecogniserFigures:
        """Those of a recogniser that has just been trained."""
        metrics = {name: metrics.as_dict() for name, metrics in trained.metrics.items()}
        return cls(metrics, asdict(trained.config), trained.seconds)

    def to_json(self) -> dict[str, Any]:
        """Plain data, see `from_json`."""
        return {"protocol": PROTOCOL, **asdict(self)}

    @classmethod
    def from_json(cls, data: Mapping[str, Any]) -> RecogniserFigures:
        """Read what `to_json` gave; what else is in it is left out."""
        return cls(data["metrics"], data["config"], data["seconds"])


@dataclass(frozen=True)
class TrainingResult:
    """A training's `result.json`.

    Attributes:
        evaluation: of the agent.
        recogniser: its figures; None if the agent has none.
        policy_history: the learner's.
        config: what was trained.
        seconds: stage -> what it took, and "total".
    """

    evaluation: AgentEvaluation
    recogniser: RecogniserFigures | None
    policy_history: list[dict[str, float]]
    config: TrainConfig
    seconds: Mapping[str, float]

    def to_json(self) -> dict[str, Any]:
        """The body of the result file."""
        recogniser = {} if self.recogniser is None else {"recogniser": self.recogniser.to_json()}
        return {
            **self.evaluation.to_json(),
            **recogniser,
            "policy_history": self.policy_history,
            "settings": asdict(self.config),
            "seconds": dict(self.seconds),
        }
