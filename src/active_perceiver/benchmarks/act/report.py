"""What `benchmark act` prints and draws."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import groupby
from typing import Any

from active_perceiver.benchmarks.act.worker import PARTS
from active_perceiver.utils.result import format_number


def format_act_speed(body: dict[str, Any]) -> str:
    """A table for each backbone, with columns for each number of threads."""
    protocol = body["protocol"]
    width, height = protocol["frame"]
    blocks = [
        _block(list(entries)) for _, entries in groupby(body["actions"], lambda entry: entry["backbone"])
    ]  # fmt: skip
    note = (
        f"{protocol['starts']} processes of {protocol['repeats']} actions each, on JPEG of {width} x {height} pixels;"
        " weights do not change how long anything takes"
    )
    return "\n\n".join([*blocks, note])


def _block(entries: Sequence[dict[str, Any]]) -> str:
    first = entries[0]
    lines = [
        f"{first['backbone']}, {first['image_size']} pixels, weights: {first['weights']}",
        f"{'':30}" + "".join(f"{label:>20}" for label in map(_threads, entries)),
        f"{'ms, median and 95th percentile':30}",
    ]
    for part in (*PARTS, "rest", "whole"):
        lines.append(f"  {part:28}" + "".join(_times(entry["ms"][part]) for entry in entries))
    eager = [entry["torch"] for entry in entries if entry["torch"] is not None]
    if eager:
        lines.append(f"  {'backbone by torch, eager':28}" + "".join(_times(one["ms"]["backbone"]) for one in eager))
    lines.append("from the start of the process to the first command, s")
    for part in first["cold_start"]:
        lines.append(f"  {part:28}" + "".join(f"{entry['cold_start'][part]:20.2f}" for entry in entries))
    if eager:
        label = "torch: import, load, backbone"
        lines.append(f"  {label:28}" + "".join(f"{one['cold_start']['whole']:20.2f}" for one in eager))
    lines.append(f"{'peak memory, GiB':30}" + "".join(_memory(entry) for entry in entries))
    if eager:
        lines.append(f"  {'torch, backbone only':28}" + "".join(_memory(one) for one in eager))
    return "\n".join(lines)


def _times(times: dict[str, float]) -> str:
    return f"{times['median']:11.2f}{times['p95']:9.2f}"


def _memory(entry: dict[str, Any]) -> str:
    return f"{format_number(entry['peak_memory_gib'], '.2f'):>20}"


def time_bars(body: dict[str, Any]) -> dict[str, dict[str, dict[str, float]]]:
    """Median milliseconds by backbone, number of threads and part; torch's backbone beside it."""
    panels: dict[str, dict[str, dict[str, float]]] = {}
    for entry in body["actions"]:
        panel = panels.setdefault(f"{entry['backbone']}, {entry['image_size']} pixels", {})
        label = _threads(entry)
        panel[label] = {part: entry["ms"][part]["median"] for part in (*PARTS, "rest")}
        if entry["torch"] is not None:
            panel[f"{label}, torch"] = {"backbone by torch, eager": entry["torch"]["ms"]["backbone"]["median"]}
    return panels


def _threads(entry: dict[str, Any]) -> str:
    return f"{entry['threads']} thread{'s' if entry['threads'] > 1 else ''}"
