"""What `benchmark robustness` says of its conditions: the table."""

from __future__ import annotations

from typing import Any

from active_perceiver.experiments.result import shown


def format_robustness(body: dict[str, Any]) -> str:
    """A table of what `measure_robustness` found."""
    protocol = body["protocol"]
    lines = [
        f"{', '.join(protocol['scenes'])}: {', '.join(protocol['targets'])}; {protocol['searches']} searches each",
        f"{'':14}{'found by one view, %':>28}{'by two views, %':>28}{'policy, exact':>17}{'recogniser':>15}",
        f"{'condition':14}{_WORD_HEAD}{_WORD_HEAD}{'success':>10}{'ratio':>7}{'AUROC':>8}{'AP50':>7}",
    ]
    for row in body["conditions"]:
        lines.append(
            f"{row['condition']:14}{_word(row)}{_word(row['confirmed'])}{100 * row['success']:10.1f}"
            f"{shown(row['ratio'], '.2f'):>7}{shown(row['auroc']):>8}{shown(row['ap50']):>7}"
        )
    lines += [
        f"true: it said found with its box on the target; false: elsewhere; none: not within {protocol['limit']}"
        " actions. By two views: with --confirm.",
        "steps: actions until a true one. success, ratio: arriving at a goal, actions over the fewest possible.",
    ]
    return "\n".join(lines)


_WORD_HEAD = "".join(f"{name:>7}" for name in ("true", "false", "none", "steps"))


def _word(row: dict[str, Any]) -> str:
    shares = "".join(f"{100 * row[key]:7.1f}" for key in ("true_found", "false_found", "not_found"))
    return shares + f"{shown(row['found_steps'], '.1f'):>7}"
