"""The parts of a result file that measuring an agent gives."""

import numpy as np

from active_perceiver.evaluation.agent_evaluation import SEEN, UNSEEN, AgentEvaluation
from active_perceiver.evaluation.stop_evaluation import StopEvaluation, StopResults
from active_perceiver.policies.evaluation import Evaluation, SearchResult
from active_perceiver.recognition.metrics import RecognitionMetrics

NEVER = SearchResult("attic", "mug", 0.0, np.nan, np.nan, np.nan, np.nan, 0.0)
POLICY = Evaluation({"kind": "exact"}, NEVER, (NEVER,))
ENDED = StopEvaluation("attic", "mug", 4, 0.5, 0.25, 0.25, 0.5, 8.0, 4.0)
STOPS = StopResults((ENDED, StopEvaluation("attic", "pan", 4, 1.0, 0.0, 0.0, 1.0, 4.0, 4.0)))
METRICS = RecognitionMetrics.of(np.array([0.9, 0.1]), np.full((2, 4), 0.5), np.array([[0.5] * 4, [np.nan] * 4]), 0.5)


def test_an_agent_without_a_recogniser_has_no_detection():
    body = AgentEvaluation(POLICY, {"searches": 4}, {SEEN: STOPS}).to_json()
    assert list(body) == ["protocol", "overall", "per_target", "stop_evaluation"]
    assert body["overall"]["mean_steps"] is None
    assert body["stop_evaluation"]["protocol"] == {"searches": 4}
    assert body["stop_evaluation"][SEEN]["overall"]["true_found"] == 0.75
    assert [row["target"] for row in body["stop_evaluation"][SEEN]["per_target"]] == ["mug", "pan"]


def test_pictures_that_training_never_saw_are_apart():
    stops, detection = {SEEN: STOPS, UNSEEN: STOPS}, {SEEN: METRICS, UNSEEN: METRICS}
    body = AgentEvaluation(POLICY, {}, stops, POLICY, detection).to_json()
    assert list(body) == ["protocol", "overall", "per_target", "unseen_pictures", "detection", "stop_evaluation"]
    assert list(body["unseen_pictures"]) == ["overall", "per_target"]
    assert list(body["detection"]) == [SEEN, UNSEEN]
    assert body["detection"][SEEN]["auroc"] == 1.0
    assert set(body["stop_evaluation"]) == {"protocol", SEEN, UNSEEN}
