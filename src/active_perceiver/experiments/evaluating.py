"""How good an agent is: by the policy's exact success, by the paper's episodes, and by its own word."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from active_perceiver.agent_config import SearchKind, picture_folder
from active_perceiver.errors import UserError
from active_perceiver.experiments import own_word
from active_perceiver.experiments.agent_scenes import agent_scenes
from active_perceiver.experiments.own_word_tables import Asked, measure_own_word
from active_perceiver.experiments.policy_figures import evaluate_tables
from active_perceiver.experiments.result import shown, write_result
from active_perceiver.experiments.settings import EvaluateSettings
from active_perceiver.experiments.sightings import Sightings, see_everywhere
from active_perceiver.experiments.stages import features_of
from active_perceiver.experiments.view_measuring import agent_view_searches, measure_view_agent
from active_perceiver.files import OutputExistsError
from active_perceiver.perceiver import ActivePerceiver
from active_perceiver.policies.evaluation import Evaluation
from active_perceiver.policies.policy import policy_table
from active_perceiver.progress import console
from active_perceiver.recognition.metrics import RecognitionMetrics
from active_perceiver.scenes import Scene
from active_perceiver.scenes.labelling import labelled_views
from active_perceiver.search.task import SearchTask


def measure_agent(
    agent: ActivePerceiver, sightings: Sequence[Sightings], settings: EvaluateSettings
) -> dict[str, Any]:
    """Measure an agent in the scenes it was trained in.

    Searches use pictures that training has seen ("overall", "per_target"), and apart from that, in the scenes that
    hold some out, pictures that it has never seen ("unseen_pictures").

    Args:
        agent: what to measure.
        sightings: one for each of its branches.
        settings: how.

    Returns:
        The body of a result file: protocol, overall, per_target, unseen_pictures, detection, own_word.
    """
    taken = [as_asked(agent, seen) for seen in sightings]
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
        "pictures_seen": [(seen, seen.trained_pictures) for seen in sightings],
        "pictures_unseen": [(seen, seen.held_out_pictures) for seen in sightings if seen.held_out_pictures],
    }
    body["detection"] = {label: _detection(agent, plain[label]).as_dict() for label in groups}
    body["own_word"] = {
        "protocol": {
            "searches": settings.searches,
            "limit": own_word.LIMIT,
            "true_iou": own_word.TRUE_IOU,
            "confirm": settings.confirm,
            "explore": settings.explore,
        },
        **{label: measure_own_word(agent, asked, settings) for label, asked in groups.items()},
    }
    return body


def as_asked(agent: ActivePerceiver, seen: Sightings) -> Sightings:
    """What an agent really sees with each picture: with that known picture which it takes the picture for.

    See `ObjectSeeker`; where it takes a picture for none of its own, nothing changes.
    """
    picture = np.tile(np.arange(seen.scores.shape[2]), (len(seen.targets), 1))
    target = np.tile(np.arange(len(seen.targets))[:, None], (1, picture.shape[1]))
    for index, codes in enumerate(seen.target_codes):
        for number, code in enumerate(codes):
            if match := agent.known.match(code, seen.scene.name):
                target[index, number] = seen.names.index(match.target.name)
                picture[index, number] = match.picture
    return replace(
        seen,
        target_features=seen.target_features[target, picture],
        target_codes=seen.target_codes[target, picture],
        scores=seen.scores[:, target, picture],
        boxes=seen.boxes[:, target, picture],
    )


def _evaluate(agent: ActivePerceiver, asked: Asked, settings: EvaluateSettings) -> Evaluation:
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


def agent_sightings(agent: ActivePerceiver) -> list[Sightings]:
    """What an agent sees in each of the scenes it was trained in.

    Raises:
        SceneError: if one of them is no longer there.
        UserError: if one has changed since, or holds out a picture that the agent was trained with.
    """
    sightings = []
    for scene, names in agent_scenes(agent):
        _check_split(agent, scene, names)
        sightings.append(see_everywhere(scene, features_of(scene, agent.backbone), agent.recogniser, names))
    return sightings


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


def _measure_objects(agent: ActivePerceiver, settings: EvaluateSettings) -> dict[str, Any]:
    sightings = agent_sightings(agent)
    with console.status("measuring"):
        return measure_agent(agent, sightings, settings)


def _measure_views(agent: ActivePerceiver, settings: EvaluateSettings) -> dict[str, Any]:
    searches = agent_view_searches(agent)
    with console.status("measuring"):
        return measure_view_agent(agent, searches, settings)


_MEASURES: dict[SearchKind, Callable[[ActivePerceiver, EvaluateSettings], dict[str, Any]]] = {
    "object": _measure_objects,
    "view": _measure_views,
}


def evaluate_command(folder: Path, settings: EvaluateSettings, out: Path | None, *, force: bool = False) -> None:
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
    words = body["own_word"]["pictures_seen"]
    rows = [*zip(body["per_target"], words["per_target"], strict=True), (body["overall"], words["overall"])]
    for result, word in rows:
        name = "all" if result is body["overall"] else result["target"]
        lines.append(
            f"{name:<14} {shown(result['success']):>8} {shown(result['mean_steps'], '.2f'):>8}"
            f" {shown(result['shortest_mean'], '.2f'):>9} {shown(result['ratio']):>7} {shown(result['spl']):>6}"
            f" {shown(word['true_found'], '.2f'):>12} {shown(word['false_found'], '.2f'):>13}"
        )
    if "detection" in body:  # an agent that searches for views has none
        auroc, ap50 = (shown(body["detection"]["pictures_seen"][name]) for name in ("auroc", "ap50"))
        lines.append(f"detection in places not trained in: AUROC {auroc}, AP50 {ap50}")
    return "\n".join(lines)
