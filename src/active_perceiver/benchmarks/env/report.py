"""What `benchmark env` prints and draws."""

from __future__ import annotations

from typing import Any


def format_env_speed(body: dict[str, Any]) -> str:
    """A table of what `measure_env_speed` found."""
    protocol = body["protocol"]
    lines = [
        f"{protocol['scene']}: {protocol['states']} states, {protocol['targets']} targets, observations of"
        f" {protocol['features']}; steps per second, all searches together",
        f"{'environment':18}{'searches':>9}{'median':>13}{'least':>13}{'most':>13}",
    ]
    for speed in body["speeds"]:
        rate = speed["per_second"]
        lines.append(
            f"{speed['environment']:18}{speed['searches']:9}"
            + "".join(f"{rate[key]:13,.0f}" for key in ("median", "least", "most")).replace(",", " ")
        )
    lines += [
        "SearchEnv: Gymnasium, one search. SyncVectorEnv: Gymnasium's, of as many SearchEnv. SearchVectorEnv: this",
        "project's, with observations. Searches: the stepping below it, without observations, on which PPO trains.",
    ]
    return "\n".join(lines)


def speed_curves(body: dict[str, Any]) -> dict[str, list[tuple[int, float, float, float]]]:
    """By environment: searches; least, median and most steps per second."""
    curves: dict[str, list[tuple[int, float, float, float]]] = {}
    for speed in body["speeds"]:
        rate = speed["per_second"]
        point = (speed["searches"], rate["least"], rate["median"], rate["most"])
        curves.setdefault(speed["environment"], []).append(point)
    return curves
