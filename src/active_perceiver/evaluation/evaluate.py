"""How good an agent is, whatever it searches for: exactly, by episodes, and by the searches that it ends itself."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from active_perceiver.agent.config import GoalName
from active_perceiver.agent.perceiver import ActivePerceiver
from active_perceiver.evaluation.agent_evaluation import SEEN, AgentEvaluation
from active_perceiver.evaluation.config import EvaluateConfig
from active_perceiver.evaluation.object_measures import measure_objects
from active_perceiver.evaluation.view_measures import measure_views
from active_perceiver.utils.result import format_number

MEASURES: dict[GoalName, Callable[[ActivePerceiver, EvaluateConfig], AgentEvaluation]] = {
    "object": measure_objects,
    "view": measure_views,
}


def evaluate(agent: ActivePerceiver, config: EvaluateConfig) -> AgentEvaluation:
    """Measure an agent in the scenes it was trained in; see `measure_agent` and `measure_view_agent`.

    Raises:
        SceneError: if one of the scenes is no longer there.
        UserError: if one has changed since, or holds out a picture that the agent was trained with.
    """
    return MEASURES[agent.config.task](agent, config)


def format_measures(body: dict[str, Any]) -> str:
    """The figures of a result file as a table for the terminal."""
    lines = [
        f"{'target':<14} {'success':>8} {'steps':>8} {'shortest':>9} {'ratio':>7} {'SPL':>6}"
        f" {'found, true':>12} {'found, false':>13}",
    ]
    words = body["stop_evaluation"][SEEN]
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
        auroc, ap50 = (format_number(body["detection"][SEEN][name]) for name in ("auroc", "ap50"))
        lines.append(f"detection in places not trained in: AUROC {auroc}, AP50 {ap50}")
    return "\n".join(lines)
