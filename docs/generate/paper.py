"""The paper's tables in our rooms, from the result files of `reproduce`."""

from __future__ import annotations

from docs.generate.markdown import percent, result, table
from docs.generate.package import FULL, format_choices, format_recogniser, format_table_1, format_table_2


def table_1() -> str:
    """Table I, one part for each setup."""
    return format_table_1(result("reproduction/table1")["rows"], FULL)


def table_2() -> str:
    """Table II."""
    return format_table_2(result("reproduction/table2")["rows"])


def recogniser() -> str:
    """The paper's recogniser, cross-validated, in each room."""
    return format_recogniser(result("reproduction/table1")["recogniser"])


def choices() -> str:
    """What the paper leaves open, chosen otherwise."""
    return format_choices(result("reproduction/choices")["rows"])


def views() -> str:
    """Searches for views instead of objects."""
    rows = []
    for learner in ("mirror-descent", "ppo"):
        body = result(f"reproduction/views_{learner}")
        overall = body["overall"]
        steps = (f"{overall['mean_steps']:.2f}", f"{overall['shortest_mean']:.2f}", f"{overall['ratio']:.3f}")
        rows.append((learner, percent(overall["success"]), *steps, f"{body['seconds']['policy']:.0f} s"))
    return table(("learner", "success", "actions", "fewest possible", "ratio", "policy trained in"), rows)
