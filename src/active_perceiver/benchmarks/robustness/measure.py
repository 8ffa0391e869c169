"""What becomes of success when an agent sees something else than it was trained on."""

from __future__ import annotations

import hashlib
import json
import logging
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from active_perceiver.agent.perceiver import ActivePerceiver
from active_perceiver.benchmarks.config import RobustnessConfig
from active_perceiver.benchmarks.robustness.perturbations import CLEAN, CONDITIONS, Condition
from active_perceiver.benchmarks.robustness.perturbed_detections import (
    Queries,
    look_around,
    views_of_new_places,
    with_detections_changed,
)
from active_perceiver.benchmarks.robustness.report import format_robustness
from active_perceiver.benchmarks.runner import Benchmark, ResultBody, share_bars
from active_perceiver.errors import UserError
from active_perceiver.evaluation.agent_evaluation import SEEN
from active_perceiver.evaluation.agent_scenes import agent_scenes
from active_perceiver.evaluation.config import EvaluateConfig
from active_perceiver.evaluation.detections import DetectionTable
from active_perceiver.evaluation.object_measures import measure_agent, with_query_pictures
from active_perceiver.evaluation.stop_evaluation import LIMIT, TRUE_IOU, StopResults
from active_perceiver.evaluation.stop_tables import evaluate_stops
from active_perceiver.figures.robustness import robustness_figure
from active_perceiver.parallel.run_store import RunStore
from active_perceiver.scenes import Scene, open_scene
from active_perceiver.utils.progress import console, progress_bar
from active_perceiver.utils.result import to_jsonable
from active_perceiver.version import __version__
from active_perceiver.vision.backbone import cache_folder

LOG = logging.getLogger(__name__)

RenderRoom = Callable[[Scene, Path, "str | None", "int | None"], None]
"""Renders the room of a scene again into a file: at another hour, or with another arrangement of its things."""

AGENT_FILES = ("config.json", "policy.onnx", "recogniser.onnx")


@dataclass
class RobustnessBenchmark(Benchmark):
    """What becomes of success when an agent sees something else than it was trained on.

    Attributes:
        folder: of the agent.
        settings: what to measure and how.
        render: makes rooms anew, for the conditions that need one.
        resume: take measurements from the work folder that an earlier run has made.
    """

    name = "robustness"
    folder: Path
    settings: RobustnessConfig
    render: RenderRoom
    resume: bool = False

    def prepare(self) -> None:
        """See `Benchmark`; the measurements are kept in the work folder."""
        self.conditions = chosen_conditions(self.settings)
        self.agent = ActivePerceiver.from_pretrained(self.folder)

    def measure(self, store: RunStore) -> ResultBody:
        """See `measure_robustness`."""
        return measure_robustness(self.agent, self.settings, self.conditions, self.render, resume=self.resume)

    def report(self, body: ResultBody) -> str:
        """See `format_robustness`."""
        return format_robustness(body)

    def figure(self, body: ResultBody) -> Figure:
        """Shares of searches by condition."""
        return robustness_figure(share_bars(body["conditions"], "condition"))


def chosen_conditions(settings: RobustnessConfig) -> dict[str, Condition]:
    """What is to be measured, by name; the first one is always how the agent was trained.

    Files that are given take the place of the rooms that would be rendered.

    Raises:
        UserError: if there is no such condition.
    """
    conditions = dict(CONDITIONS)
    for given, field in ((settings.other_hour, "hour"), (settings.moved, "moved")):
        if given:
            conditions = {name: one for name, one in conditions.items() if getattr(one, field) is None}
        for path in given:
            meaning = "the room in another light" if field == "hour" else "the same things lie elsewhere"
            conditions[path.stem] = Condition(f"{meaning}: {path}", file=path, same_boxes=field == "hour")
    if unknown := set(settings.conditions) - set(conditions):
        raise UserError(f"there is no condition {sorted(unknown)}; choose of: {', '.join(conditions)}")
    wanted = {CLEAN, *(settings.conditions or conditions)}
    return {name: one for name, one in conditions.items() if name in wanted}


def measure_robustness(
    agent: ActivePerceiver,
    settings: RobustnessConfig,
    conditions: Mapping[str, Condition],
    render: RenderRoom,
    *,
    resume: bool = False,
) -> dict[str, Any]:
    """Measure an agent under each condition, in the scenes and with the pictures it was trained with.

    Args:
        agent: what to measure; it searches for objects.
        settings: how.
        conditions: what is different, by name.
        render: makes rooms anew.
        resume: take what an earlier run has measured from the work folder.

    Returns:
        "protocol"; "conditions": for each one "condition", "meaning", of the policy's exact evaluation "success",
        "ratio", "mean_steps" and "shortest_mean", by its own word "true_found", "false_found", "not_found" and
        "found_steps" (the mean), "confirmed": the same four if it takes two views to say found, "policy_only": if it
        never explores, of the recogniser in places it was not trained in "auroc", "ap50", "recall" and
        "false_positive_rate", and all that `measure_agent` says of each target.

    Raises:
        AgentError: if the agent searches for views.
        UserError: if a room cannot be had.
    """
    work = settings.work or cache_folder() / "robustness"
    # The names of what is kept say what it follows from, so many agents and protocols share the folder.
    kept = RunStore(work / "conditions")
    scenes = list(agent_scenes(agent))
    asked = [Queries.of(agent, scene, names) for scene, names in scenes]
    plain: dict[str, DetectionTable] = {}
    rows = []
    for number, (name, condition) in enumerate(conditions.items(), 1):
        LOG.info("%s (%d of %d)", name, number, len(conditions))
        rooms = [_room(one.scene, condition, work, render) for one in asked]
        key = _key(agent, settings, name, condition, rooms)
        row = kept.record(key) if resume else None
        if row is None:
            seen = [
                _look(agent, one, room, condition, settings.seed, plain)
                for one, room in zip(asked, rooms, strict=True)
            ]
            measured = _measure(agent, asked, seen, settings)
            row = to_jsonable({"condition": name, "meaning": condition.meaning, **measured})
            kept.keep(key, row)
        rows.append(row)
    protocol = {
        "agent": str(agent.folder),
        "scenes": [scene.name for scene, _ in scenes],
        "targets": [target.name for target in agent.config.targets],
        "pictures": "those trained on",
        "draws": "one for each view, where detections change one for each view and picture: a search that comes back "
        "to a view sees the same again",
        "searches": settings.searches,
        "limit": LIMIT,
        "true_iou": TRUE_IOU,
        "exact_limit": settings.limit,
        "recognition": "views of places not trained in, objects of at least 0.3 % of the view",
        "seed": settings.seed,
    }
    return {"protocol": protocol, "conditions": rows}


def _room(scene: Scene, condition: Condition, work: Path, render: RenderRoom) -> Scene:
    """What the agent's scene looks like under a condition."""
    path = condition.file
    if condition.hour is not None or condition.moved is not None:
        change = f"hour_{condition.hour}" if condition.hour is not None else f"moved_{condition.moved}"
        path = work / "rooms" / f"{scene.name}_{change}.h5"
        if not path.is_file():
            render(scene, path, condition.hour, condition.moved)
    if path is None:
        return scene
    room = open_scene(path)
    if room.actions != scene.actions:
        raise UserError(f"{path} has other actions than '{scene.name}', in which the agent was trained; give another")
    if (condition.same_boxes or condition.hour is not None) and not _same_boxes(room, scene):
        raise UserError(
            f"{path} does not show '{scene.name}' from the same places with everything where it was; to have it "
            "rendered again, remove the file, or do not give it"
        )
    return room


def _same_boxes(room: Scene, scene: Scene) -> bool:
    if room.poses.shape != scene.poses.shape or not np.allclose(room.poses, scene.poses, atol=1e-3):
        return False
    names = [name for name in scene.target_names if name in room.target_names]
    there, here = (one.boxes[:, [one.target_index(name) for name in names]] for one in (room, scene))
    return bool(names) and np.allclose(there, here, atol=1e-3, equal_nan=True)


def _key(
    agent: ActivePerceiver, settings: RobustnessConfig, name: str, condition: Condition, rooms: Sequence[Scene]
) -> str:
    """A name for a measurement that no other agent's, condition's or protocol's has."""
    digest = hashlib.sha256()
    for file in AGENT_FILES:
        digest.update((agent.folder / file).read_bytes())
    facts: list[Any] = [__version__, name, condition.meaning, [room.content_hash for room in rooms]]
    facts += [settings.searches, settings.limit, settings.seed]
    digest.update(json.dumps(facts).encode())
    return f"{name.replace(' ', '_').replace('%', 'percent')}-{digest.hexdigest()[:16]}"


def _look(
    agent: ActivePerceiver,
    one: Queries,
    room: Scene,
    condition: Condition,
    seed: int,
    plain: dict[str, DetectionTable],
) -> DetectionTable:
    """What the agent sees in a room under a condition; what it sees there with its own eyes is kept in `plain`."""
    seen = plain.get(room.content_hash) if condition.image is None else None
    if seen is None:
        with progress_bar(f"looking in {one.scene.name}") as report:
            seen = look_around(agent, one, room, condition.image, seed, report)
        if condition.image is None:
            plain[room.content_hash] = seen
    if condition.detections is None:
        return seen
    return with_detections_changed(seen, condition.detections, agent.config.score_threshold, seed)


def _measure(
    agent: ActivePerceiver, asked: Sequence[Queries], seen: Sequence[DetectionTable], settings: RobustnessConfig
) -> dict[str, Any]:
    """The figures of one condition, see `measure_robustness`."""
    how = EvaluateConfig(limit=settings.limit, searches=settings.searches, seed=settings.seed)
    with console.status("measuring"):
        measured = measure_agent(agent, seen, how, views_of_new_places(agent, asked, seen))
        groups = [(with_query_pictures(agent, one), one.trained_pictures) for one in seen]
        confirmed = evaluate_stops(agent, groups, replace(how, confirm=True))
        policy_only = evaluate_stops(agent, groups, replace(how, explore=False))
    stops, detection, policy = measured.stops[SEEN], measured.detection[SEEN].as_dict(), measured.policy.as_dict()
    return {
        **{key: policy["overall"][key] for key in ("success", "ratio", "mean_steps", "shortest_mean")},
        **_stop_rates(stops),
        "confirmed": _stop_rates(confirmed),
        "policy_only": _stop_rates(policy_only),
        **{key: detection[key] for key in ("auroc", "ap50", "recall", "false_positive_rate")},
        "per_target": policy["per_target"],
        "per_target_stop_evaluation": stops.to_json()["per_target"],
        "views": [len(one.scene) for one in seen],
    }


def _stop_rates(stops: StopResults) -> dict[str, float | None]:
    return {
        **{key: stops.overall[key] for key in ("true_found", "false_found", "not_found")},
        "found_steps": _mean([result.mean_steps for result in stops.per_target]),
    }


def _mean(values: Sequence[float]) -> float | None:
    """Of those that are numbers: a target that is never found has no steps."""
    there = [value for value in values if np.isfinite(value)]
    return float(np.mean(there)) if there else None
