"""The demo's report: one page with what was searched, the pictures, the videos and the numbers."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

from active_perceiver.agent.perceiver import ActivePerceiver
from active_perceiver.envs.task import SearchTask
from active_perceiver.live import SearchRecord
from active_perceiver.recognition.metrics import box_iou
from active_perceiver.reports import page
from active_perceiver.reports.search_card import SearchCard, search_card
from active_perceiver.scenes import Scene
from active_perceiver.utils.result import format_number


@dataclass(frozen=True)
class SearchSummary:
    """How one search of the demo went; the last two are known only to us, not to the agent.

    Attributes:
        target: what was searched.
        start: the state it began in.
        found: the agent's own word.
        actions: taken.
        shortest: fewest actions to a goal state from there.
        iou: overlap of the box drawn last with the true one; 0 if none was drawn or the target is not in view.
    """

    target: str
    start: int
    found: bool
    actions: int
    shortest: int
    iou: float


@dataclass(frozen=True)
class DemoSearch:
    """One search of the demo with everything the report shows of it."""

    record: SearchRecord
    scene: Scene
    task: SearchTask
    summary: SearchSummary
    folder: Path

    @classmethod
    def of(
        cls, record: SearchRecord, scene: Scene, task: SearchTask, start: int, state: int, folder: Path
    ) -> DemoSearch:
        """Compare a finished search for the only target of `task` with the truth.

        Args:
            record: the search.
            scene: where it was.
            task: the search's goals and shortest paths.
            start: the state it began in.
            state: the state it ended in.
            folder: where its files are.
        """
        name = task.targets[0]
        detection = record.step_records[-1].step.detection
        truth = scene.boxes[state, scene.target_index(name)]
        iou = 0.0 if detection is None else float(box_iou(detection.box, truth))
        shortest = int(task.steps[start, 0])
        overlap = iou if iou == iou else 0.0  # NaN where the target is not in view
        return cls(
            record, scene, task, SearchSummary(name, start, record.found, record.actions, shortest, overlap), folder
        )


def write_report(path: Path, agent: ActivePerceiver, body: dict[str, Any], searches: list[DemoSearch]) -> None:
    """Write the report page.

    Args:
        path: the HTML file.
        agent: that searched.
        body: of the result file.
        searches: in the order in which to show them.
    """
    scene = searches[0].scene
    lead = (
        f"An agent was trained in {scene.name}, a room of {len(scene)} views, to search for {len(searches)} of its "
        "objects. Each search below begins far away from the object, with a picture of it that training has never "
        "seen; the agent sees nothing but its camera's view and says by itself when it has found the object."
    )
    page.write_page(
        path,
        "demo_report.html.j2",
        title="Active Object Perceiver: a search from a picture",
        lead=lead,
        cards=[_search_card(item) for item in searches],
        policy=_policy_table(body),
        stops=_stop_table(body),
        recogniser=_recogniser_table(body),
        settings=_settings_table(agent, body),
    )


def _search_card(item: DemoSearch) -> SearchCard:
    summary = item.summary
    verdict = (
        f"{item.record.ending}: {summary.actions} actions, the fewest to a goal state are {summary.shortest}; "
        f"overlap of the last box with the true one {summary.iou:.2f}"
    )
    video = (item.folder / "search.mp4").read_bytes()
    return search_card(item.record, summary.target, verdict, video, item.scene, item.task.goals[:, 0])


def _policy_table(body: dict[str, Any]) -> page.Table:
    rows = []
    for result in [*body["per_target"], {**body["overall"], "target": "all"}]:
        steps = [format_number(result[name], ".2f") for name in ("mean_steps", "shortest_mean")]
        rows.append(
            [
                result["target"],
                format_number(result["success"], ".4f"),
                *steps,
                format_number(result["ratio"], ".3f"),
                format_number(result["spl"], ".3f"),
            ]
        )
    note = "Exact, from the policy's Markov chain: every start from which a goal state can be reached, no sampling."
    head = ["target", "success", "mean actions", "fewest possible", "ratio", "SPL"]
    return page.Table(head, rows, note)


def _stop_table(body: dict[str, Any]) -> page.Table:
    rows = []
    for label, key in (("pictures seen in training", "pictures_seen"), ("pictures never seen", "pictures_unseen")):
        words = body["stop_evaluation"][key]
        for result in [*words["per_target"], {**words["overall"], "target": "all"}]:
            shares = [
                f"{format_number(100 * result[name], '.0f')} %"
                for name in ("true_found", "false_found", "not_found", "at_goal")
            ]
            rows.append([f"{result['target']}, {label}", *shares, format_number(result["mean_steps"], ".1f")])
    protocol = body["stop_evaluation"]["protocol"]
    note = (
        f"{protocol['searches']} searches per target from random starts, at most {protocol['limit']} actions. "
        f"“Found” is true if the drawn box overlaps the true one with an IoU of at least {protocol['true_iou']}."
    )
    head = ["target", "found, true", "found, false", "not found", "at a goal state", "mean actions"]
    return page.Table(head, rows, note)


def _recogniser_table(body: dict[str, Any]) -> page.Table:
    rows = []
    for kind, figures in body["recogniser"].items():
        for pictures in ("seen pictures", "unseen pictures"):
            metrics = figures["metrics"][pictures]
            rates = [
                format_number(metrics[name])
                for name in ("auroc", "ap50", "mean_iou", "recall", "false_positive_rate")
            ]
            rows.append([f"{kind}, {pictures}", *rates, metrics["positives"]])
    note = (
        "“matching” compares the target with every place in the view, “pooled” is the paper's. Objects of at least "
        "0.3 % of the image count; recall and false positives are at the score from which on the agent believes it."
    )
    head = ["recogniser", "AUROC", "AP50", "mean IoU", "recall", "false positives", "views with the target"]
    return page.Table(head, rows, note)


def _settings_table(agent: ActivePerceiver, body: dict[str, Any]) -> page.Table:
    machine = body["machine"]
    rows = [
        ["backbone", f"{agent.config.backbone}, {agent.config.image_size} pixels"],
        ["learner", body["settings"]["learner"]],
        ["seed", body["settings"]["seed"]],
        ["machine", f"{machine['processor']}, {machine['cores']} cores"],
        *[[f"seconds: {name}", f"{seconds:.1f}"] for name, seconds in body["seconds"].items()],
    ]
    return page.Table((), rows)
