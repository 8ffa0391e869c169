"""What `benchmark robustness` says of its conditions: the table."""

from __future__ import annotations

from typing import Any

from active_perceiver.utils.result import format_number


def format_robustness(body: dict[str, Any]) -> str:
    """A table of what `measure_robustness` found."""
    protocol = body["protocol"]
    lines = [
        f"{', '.join(protocol['scenes'])}: {', '.join(protocol['targets'])}; {protocol['searches']} searches each",
        f"{'':14}{'by its own word, %':>27}{'two views, %':>21}{'not exploring, %':>21}{'policy, exact':>16}"
        f"{'recogniser':>15}",
        f"{'condition':14}{_ENDS}{'steps':>7}{_ENDS}{_ENDS}{'success':>10}{'ratio':>6}{'AUROC':>9}{'AP50':>6}",
    ]
    for row in body["conditions"]:
        lines.append(
            f"{row['condition']:14}{_ends(row)}{format_number(row['found_steps'], '.1f'):>7}{_ends(row['confirmed'])}"
            f"{_ends(row['policy_only'])}{100 * row['success']:10.1f}{format_number(row['ratio'], '.2f'):>6}"
            f"{format_number(row['auroc']):>9}{format_number(row['ap50']):>6}"
        )
    lines += [
        f"true: it said found with its box on the target; false: elsewhere; none: not within {protocol['limit']}"
        " actions. Two views: with --confirm.",
        "steps: actions until a true one. success, ratio: arriving at a goal, actions over the fewest possible.",
    ]
    return "\n".join(lines)


_ENDS = "".join(f"{name:>{width}}" for name, width in (("true", 8), ("false", 6), ("none", 6)))


def _ends(row: dict[str, Any]) -> str:
    """How its searches ended, as the columns of `_ENDS`."""
    widths = {"true_found": 8, "false_found": 6, "not_found": 6}
    return "".join(f"{100 * row[key]:{width}.1f}" for key, width in widths.items())
