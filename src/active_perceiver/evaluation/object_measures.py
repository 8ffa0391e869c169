"""How good an agent is that searches for objects: its policy, its recogniser, the searches that it ends itself."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from active_perceiver.agent.config import picture_folder
from active_perceiver.agent.perceiver import ActivePerceiver
from active_perceiver.envs.task import SearchTask
from active_perceiver.errors import UserError
from active_perceiver.evaluation import stop_evaluation
from active_perceiver.evaluation.agent_evaluation import SEEN, UNSEEN, AgentEvaluation
from active_perceiver.evaluation.agent_scenes import agent_scenes, features_of
from active_perceiver.evaluation.config import EvaluateConfig
from active_perceiver.evaluation.detections import DetectionTable, detect_all_views
from active_perceiver.evaluation.policy_metrics import evaluate_tables
from active_perceiver.evaluation.stop_tables import Asked, evaluate_stops
from active_perceiver.policies.evaluation import Evaluation
from active_perceiver.policies.policy import policy_table
from active_perceiver.recognition.metrics import RecognitionMetrics
from active_perceiver.scenes import Scene
from active_perceiver.scenes.box_labels import labelled_views
from active_perceiver.utils.progress import console

HeldOutViews = Mapping[str, Sequence[int]]
"""Scene -> views."""


def measure_agent(
    agent: ActivePerceiver,
    detections: Sequence[DetectionTable],
    config: EvaluateConfig,
    held_out_views: HeldOutViews | None = None,
) -> AgentEvaluation:
    """Measure an agent in the scenes it was trained in.

    Searches use pictures that training has seen, and apart from that, in the scenes that hold some out, pictures that
    it has never seen.

    Args:
        agent: what to measure.
        detections: one for each of its branches.
        config: how.
        held_out_views: in which the recogniser is measured; those it was not trained on if not given.
    """
    held_out = agent.config.training.held_out_views if held_out_views is None else held_out_views
    # What the recogniser itself makes of the pictures counts for detection, whatever the agent takes them for.
    taken = _by_pictures([with_query_pictures(agent, seen) for seen in detections])
    policies = {label: _evaluate(agent, asked, config) for label, asked in taken.items()}
    seen_policy = policies[SEEN]
    return AgentEvaluation(
        policy=replace(seen_policy, protocol={**seen_policy.protocol, "pictures": "those trained on"}),
        policy_unseen=policies.get(UNSEEN),
        detection={label: _detection(agent, asked, held_out) for label, asked in _by_pictures(detections).items()},
        stop_protocol={
            "searches": config.searches,
            "limit": stop_evaluation.LIMIT,
            "true_iou": stop_evaluation.TRUE_IOU,
            "confirm": config.confirm,
            "explore": config.explore,
        },
        stops={label: evaluate_stops(agent, asked, config) for label, asked in taken.items()},
    )


def _by_pictures(detections: Sequence[DetectionTable]) -> dict[str, Asked]:
    """Those with the pictures that training has seen, and those of the scenes that hold some out with these."""
    groups: dict[str, Asked] = {SEEN: [(seen, seen.trained_pictures) for seen in detections]}
    if unseen := [(seen, seen.held_out_pictures) for seen in detections if seen.held_out_pictures]:
        groups[UNSEEN] = unseen
    return groups


def with_query_pictures(agent: ActivePerceiver, seen: DetectionTable) -> DetectionTable:
    """What an agent really sees with each picture: with that known picture which it takes the picture for.

    See `ObjectDetector`; where it takes a picture for none of its own, nothing changes.
    """
    picture = np.tile(np.arange(seen.scores.shape[2]), (len(seen.targets), 1))
    target = np.tile(np.arange(len(seen.targets))[:, None], (1, picture.shape[1]))
    for index, embeddings in enumerate(seen.target_embeddings):
        for number, embedding in enumerate(embeddings):
            if match := agent.gallery.match(embedding, seen.scene.name):
                target[index, number] = seen.names.index(match.target.name)
                picture[index, number] = match.picture
    return replace(
        seen,
        target_features=seen.target_features[target, picture],
        target_embeddings=seen.target_embeddings[target, picture],
        scores=seen.scores[:, target, picture],
        boxes=seen.boxes[:, target, picture],
    )


def _evaluate(agent: ActivePerceiver, asked: Asked, config: EvaluateConfig) -> Evaluation:
    """The evaluation with each picture in turn, averaged: a search may start from any of them."""
    searches = []
    for seen, pictures in asked:
        task = SearchTask.from_scene(seen.scene, seen.names, agent.config.training.rank)
        observations = seen.observations(agent.config.score_threshold, pictures)
        tables = [policy_table(agent.policy, observations, seen.scene.name, k) for k in range(len(pictures))]
        searches.append((task, tables))
    return evaluate_tables(searches, config)


def _detection(agent: ActivePerceiver, asked: Asked, held_out: HeldOutViews) -> RecognitionMetrics:
    """How well the agent's targets are recognised in those of the views held out that somebody has labelled."""
    scores, boxes, truth, names = [], [], [], []
    for seen, pictures in asked:
        views = np.array(held_out[seen.scene.name], np.int64)
        views = views[labelled_views(seen.scene)[views]]
        for index, name in enumerate(seen.names):
            for picture in pictures:
                scores.append(seen.scores[views, index, picture])
                boxes.append(seen.boxes[views, index, picture])
                truth.append(seen.scene.boxes[views, seen.targets[index]])
                names.append(np.full(len(views), f"{seen.scene.name}/{name}"))
    return RecognitionMetrics.of(
        np.concatenate(scores),
        np.concatenate(boxes),
        np.concatenate(truth),
        agent.config.score_threshold,
        np.concatenate(names),
    )


def agent_detections(agent: ActivePerceiver, sources: Mapping[str, str] | None = None) -> list[DetectionTable]:
    """What an agent sees in each of the scenes it was trained in; see `agent_scenes`.

    Raises:
        SceneError: if one of them is no longer there.
        UserError: if one has changed since, or holds out a picture that the agent was trained with.
    """
    detections = []
    for scene, names in agent_scenes(agent, sources):
        _check_split(agent, scene, names)
        detections.append(detect_all_views(scene, features_of(scene, agent.backbone), agent.recogniser, names))
    return detections


def _check_split(agent: ActivePerceiver, scene: Scene, names: Sequence[str]) -> None:
    """Figures for pictures never seen would be false if the agent keeps one of them as seen in training."""
    for name in names:
        target = scene.targets[scene.target_index(name)]
        kept = {path.read_bytes() for path in picture_folder(agent.folder, scene.name, name).glob("*")}
        if kept & set(target.pictures[target.trained :]):
            raise UserError(
                f"the agent was trained with pictures of '{name}' that scene '{scene.name}' now holds out; train it "
                "again to measure it there"
            )


def measure_objects(agent: ActivePerceiver, config: EvaluateConfig) -> AgentEvaluation:
    """Open the scenes that an agent was trained in, and measure it there; see `measure_agent`."""
    detections = agent_detections(agent)
    with console.status("measuring"):
        return measure_agent(agent, detections, config)
