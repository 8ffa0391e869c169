"""What measuring an agent gives, whatever it searches for."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from active_perceiver.evaluation.stop_evaluation import StopResults
from active_perceiver.policies.evaluation import Evaluation
from active_perceiver.recognition.metrics import RecognitionMetrics

SEEN = "pictures_seen"
"""The key of what is measured with pictures that training has seen."""

UNSEEN = "pictures_unseen"
"""The key of what is measured with pictures that training has never seen."""


@dataclass(frozen=True)
class AgentEvaluation:
    """How good an agent is in the scenes it was trained in.

    Attributes:
        policy: its searches as the policy leads them, with pictures that training has seen.
        stop_protocol: how the searches that it ends itself were measured.
        stops: these searches, for `SEEN` and, where scenes hold some out, `UNSEEN` pictures.
        policy_unseen: as `policy`, with pictures that training has never seen; None if the scenes hold none out.
        detection: its recogniser in views it was not trained on, by the keys of `stops`; empty if it has none.
    """

    policy: Evaluation
    stop_protocol: Mapping[str, Any]
    stops: Mapping[str, StopResults]
    policy_unseen: Evaluation | None = None
    detection: Mapping[str, RecognitionMetrics] = field(default_factory=dict)

    def to_json(self) -> dict[str, Any]:
        """The body of a result file: protocol, overall, per_target, unseen_pictures, detection, stop_evaluation."""
        body = self.policy.as_dict()
        if self.policy_unseen is not None:
            unseen = self.policy_unseen.as_dict()
            body["unseen_pictures"] = {"overall": unseen["overall"], "per_target": unseen["per_target"]}
        if self.detection:
            body["detection"] = {label: metrics.as_dict() for label, metrics in self.detection.items()}
        stops = {label: results.to_json() for label, results in self.stops.items()}
        body["stop_evaluation"] = {"protocol": dict(self.stop_protocol), **stops}
        return body
