"""How good an agent is: by the policy's exact success, by the paper's episodes, and by its own word."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from active_perceiver.agent.config import SearchKind, picture_folder
from active_perceiver.agent.perceiver import ActivePerceiver
from active_perceiver.envs.task import SearchTask
from active_perceiver.errors import UserError
from active_perceiver.evaluation import stop_evaluation
from active_perceiver.evaluation.agent_scenes import agent_scenes, features_of
from active_perceiver.evaluation.config import EvaluateConfig
from active_perceiver.evaluation.detections import DetectionTable, detect_all_views
from active_perceiver.evaluation.policy_metrics import evaluate_tables
from active_perceiver.evaluation.stop_tables import Asked, evaluate_stops
from active_perceiver.evaluation.view_metrics import agent_view_searches, measure_view_agent
from active_perceiver.policies.evaluation import Evaluation
from active_perceiver.policies.policy import policy_table
from active_perceiver.recognition.metrics import RecognitionMetrics
from active_perceiver.scenes import Scene
from active_perceiver.scenes.box_labels import labelled_views
from active_perceiver.utils.files import OutputExistsError
from active_perceiver.utils.progress import console
from active_perceiver.utils.result import format_number, write_result


def measure_agent(
    agent: ActivePerceiver, detections: Sequence[DetectionTable], settings: EvaluateConfig
) -> dict[str, Any]:
    """Measure an agent in the scenes it was trained in.

    Searches use pictures that training has seen ("overall", "per_target"), and apart from that, in the scenes that
    hold some out, pictures that it has never seen ("unseen_pictures").

    Args:
        agent: what to measure.
        detections: one for each of its branches.
        settings: how.

    Returns:
        The body of a result file: protocol, overall, per_target, unseen_pictures, detection, stop_evaluation.
    """
    taken = [with_query_pictures(agent, seen) for seen in detections]
    groups = {"pictures_seen": [(seen, seen.trained_pictures) for seen in taken]}
    if unseen := [(seen, seen.held_out_pictures) for seen in taken if seen.held_out_pictures]:
        groups["pictures_unseen"] = unseen
    body = _evaluate(agent, groups["pictures_seen"], settings).as_dict()
    body["protocol"]["pictures"] = "those trained on"
    if unseen:
        apart = _evaluate(agent, unseen, settings).as_dict()
        body["unseen_pictures"] = {"overall": apart["overall"], "per_target": apart["per_target"]}
    # What the recogniser itself makes of the pictures, whatever the agent takes them for.
    plain = {
        "pictures_seen": [(seen, seen.trained_pictures) for seen in detections],
        "pictures_unseen": [(seen, seen.held_out_pictures) for seen in detections if seen.held_out_pictures],
    }
    body["detection"] = {label: _detection(agent, plain[label]).as_dict() for label in groups}
    body["stop_evaluation"] = {
        "protocol": {
            "searches": settings.searches,
            "limit": stop_evaluation.LIMIT,
            "true_iou": stop_evaluation.TRUE_IOU,
            "confirm": settings.confirm,
            "explore": settings.explore,
        },
        **{label: evaluate_stops(agent, asked, settings) for label, asked in groups.items()},
    }
    return body


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


def _evaluate(agent: ActivePerceiver, asked: Asked, settings: EvaluateConfig) -> Evaluation:
    """The evaluation with each picture in turn, averaged: a search may start from any of them."""
    searches = []
    for seen, pictures in asked:
        task = SearchTask.from_scene(seen.scene, seen.names, int(agent.config.training["rank"]))
        observations = seen.observations(agent.config.score_threshold, pictures)
        tables = [policy_table(agent.policy, observations, seen.scene.name, k) for k in range(len(pictures))]
        searches.append((task, tables))
    return evaluate_tables(searches, settings)


def _detection(agent: ActivePerceiver, asked: Asked) -> RecognitionMetrics:
    """How well the agent's targets are recognised in views of places that the recogniser was not trained in.

    Views that nobody has labelled are left out.
    """
    scores, boxes, truth, names = [], [], [], []
    for seen, pictures in asked:
        views = np.array(agent.config.training["held_out_views"][seen.scene.name], np.int64)
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


def agent_detections(agent: ActivePerceiver) -> list[DetectionTable]:
    """What an agent sees in each of the scenes it was trained in.

    Raises:
        SceneError: if one of them is no longer there.
        UserError: if one has changed since, or holds out a picture that the agent was trained with.
    """
    detections = []
    for scene, names in agent_scenes(agent):
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


def _measure_objects(agent: ActivePerceiver, settings: EvaluateConfig) -> dict[str, Any]:
    detections = agent_detections(agent)
    with console.status("measuring"):
        return measure_agent(agent, detections, settings)


def _measure_views(agent: ActivePerceiver, settings: EvaluateConfig) -> dict[str, Any]:
    searches = agent_view_searches(agent)
    with console.status("measuring"):
        return measure_view_agent(agent, searches, settings)


_MEASURES: dict[SearchKind, Callable[[ActivePerceiver, EvaluateConfig], dict[str, Any]]] = {
    "object": _measure_objects,
    "view": _measure_views,
}


def evaluate_command(folder: Path, settings: EvaluateConfig, out: Path | None, *, force: bool = False) -> None:
    """Measure an agent, print a table, and write the result if a file is given.

    Raises:
        UserError: if the agent, its scenes or the output file are not what they should be.
    """
    if out is not None and out.exists() and not force:
        raise OutputExistsError(f"{out} exists; give another --out, or --force to replace it")
    agent = ActivePerceiver.from_pretrained(folder, confirm=settings.confirm, explore=settings.explore)
    body = _MEASURES[agent.config.task](agent, settings)
    print(format_measures(body))
    if out is not None:
        write_result(out, "evaluate", body)


def format_measures(body: dict[str, Any]) -> str:
    """The figures of a result file as a table for the terminal."""
    lines = [
        f"{'target':<14} {'success':>8} {'steps':>8} {'shortest':>9} {'ratio':>7} {'SPL':>6}"
        f" {'found, true':>12} {'found, false':>13}",
    ]
    words = body["stop_evaluation"]["pictures_seen"]
    rows = [*zip(body["per_target"], words["per_target"], strict=True), (body["overall"], words["overall"])]
    for result, word in rows:
        name = "all" if result is body["overall"] else result["target"]
        lines.append(
            f"{name:<14} {format_number(result['success']):>8} {format_number(result['mean_steps'], '.2f'):>8}"
            f" {format_number(result['shortest_mean'], '.2f'):>9}"
            f" {format_number(result['ratio']):>7} {format_number(result['spl']):>6}"
            f" {format_number(word['true_found'], '.2f'):>12} {format_number(word['false_found'], '.2f'):>13}"
        )
    if "detection" in body:  # an agent that searches for views has none
        auroc, ap50 = (format_number(body["detection"]["pictures_seen"][name]) for name in ("auroc", "ap50"))
        lines.append(f"detection in places not trained in: AUROC {auroc}, AP50 {ap50}")
    return "\n".join(lines)
