"""What an exported agent weighs, how fast it starts and acts where little is installed, and what 8-bit numbers do."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import tempfile
import time
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from active_perceiver.agent.checksums import check_files
from active_perceiver.agent.config import AgentConfig
from active_perceiver.benchmarks.act.measure import run_process, summary_of, write_pictures
from active_perceiver.benchmarks.config import ExportBenchmarkConfig
from active_perceiver.benchmarks.exported.clean_environment import PACKAGES, clean_variables, make_clean_environment
from active_perceiver.benchmarks.exported.report import action_bars, format_exported
from active_perceiver.benchmarks.runner import Benchmark, ResultBody
from active_perceiver.deploy.export import export_agent
from active_perceiver.errors import UserError
from active_perceiver.figures.speed import parts_figure
from active_perceiver.parallel.run_store import RunStore
from active_perceiver.scenes import open_scene
from active_perceiver.utils.progress import ProgressCallback, console, progress_bar, quiet

CHECKS = 5
"""The time that comparing checksums takes is the median of so many."""


@dataclass(frozen=True)
class ExportBenchmark(Benchmark):
    """What an exported agent weighs, how fast it is, and what 8-bit numbers do."""

    name = "export"
    agent: Path
    settings: ExportBenchmarkConfig

    def prepare(self) -> None:
        """See `Benchmark`."""
        settings = self.settings
        if min(settings.threads, settings.repeats, settings.starts, settings.searches, *settings.frame) < 1:
            raise UserError(
                "threads, repeats, starts, searches and the sides of the camera's pictures must be at least 1"
            )

    def measure(self, store: RunStore) -> ResultBody:
        """See `measure_exported`."""
        return measure_exported(self.agent, self.settings)

    def report(self, body: ResultBody) -> str:
        """See `format_exported`."""
        return format_exported(body)

    def figure(self, body: ResultBody) -> Figure:
        """Where the time of an action goes."""
        return parts_figure(action_bars(body))


def measure_exported(agent: Path, settings: ExportBenchmarkConfig) -> dict[str, Any]:
    """Export an agent twice, with 32-bit and with 8-bit numbers, and measure both.

    Returns:
        "protocol"; "agents": for "fp32" and "int8" {"megabytes" by part and "all"; "ms", "cold_start" and
        "peak_memory_gib" in the environment with the three packages alone, see `measure_act_speed`, with "checking",
        what comparing the checksums takes of loading; "cold_start_here": the same in this one; "start_ratio": of
        both wholes; "evaluation": what `evaluate` says}; "int8_over_fp32": ratios of the median of a whole action,
        of its backbone, and of all megabytes.

    Raises:
        UserError: if the agent or its scenes cannot be used, 8-bit networks cannot be made here, or packages cannot
            be installed.
    """
    config = AgentConfig.load(agent)
    with tempfile.TemporaryDirectory(prefix="active-perceiver-") as name:
        work = Path(name)
        agents: dict[str, dict[str, Any]] = {}
        for label, int8 in (("fp32", False), ("int8", True)):
            calibrate = settings.calibrate if int8 else None
            exported = export_agent(agent, work / label, int8=int8, calibrate=calibrate)
            agents[label] = {"megabytes": {**exported.megabytes, "all": sum(exported.megabytes.values())}}
        python = settings.python
        if python is None:
            with console.status(f"installing {', '.join(PACKAGES)} into a temporary folder"):
                python = make_clean_environment(work / "environment")
        with progress_bar("processes") as report:
            _time(agents, config, settings, python, work, report)
        for label, measured in agents.items():
            measured["evaluation"] = _evaluated(work / label, work, settings.searches)
    whole, backbone = (
        agents["int8"]["ms"][part]["median"] / agents["fp32"]["ms"][part]["median"] for part in ("whole", "backbone")
    )
    megabytes = agents["int8"]["megabytes"]["all"] / agents["fp32"]["megabytes"]["all"]
    protocol = {
        "backbone": config.backbone,
        "image_size": config.image_size,
        "scenes": list(config.branches),
        "calibrated_by": settings.calibrate or "the agent's own pictures",
        "threads": settings.threads,
        "frame": list(settings.frame),
        "starts": settings.starts,
        "repeats": settings.repeats,
        "searches": settings.searches,
        "packages": list(PACKAGES),
    }
    ratios = {"whole action": whole, "backbone": backbone, "megabytes": megabytes}
    return {"protocol": protocol, "agents": agents, "int8_over_fp32": ratios}


def _checking(folder: Path) -> float:
    seconds = []
    for _ in range(CHECKS):
        started = time.perf_counter()
        check_files(folder)
        seconds.append(time.perf_counter() - started)
    return float(np.median(seconds))


def _time(
    agents: dict[str, dict[str, Any]],
    config: AgentConfig,
    settings: ExportBenchmarkConfig,
    python: Path,
    work: Path,
    progress: ProgressCallback = quiet,
) -> None:
    """Act in fresh processes, in the environment of a Python and in this one, and add what that took."""
    scene = open_scene(config.training.scenes[0])
    scene.require_targets()
    common = {"threads": settings.threads, "repeats": settings.repeats, **write_pictures(scene, settings.frame, work)}
    environments = {"clean": (python, clean_variables()), "here": (Path(sys.executable), dict(os.environ))}
    runs: dict[tuple[str, str], list[dict[str, Any]]] = {
        (label, where): [] for label in agents for where in environments
    }
    # By turns, so that a disturbance meets all. The first turn reads files that are in no cache: it does not count.
    for turn in range(settings.starts + 1):
        for (label, where), kept in runs.items():
            request = {"run": "agent", "folder": str(work / label), **common}
            kept.append(run_process(request, *environments[where]))
        progress(turn + 1, settings.starts + 1)
    for label, entry in agents.items():
        clean, here = (summary_of(runs[label, where][1:]) for where in ("clean", "here"))
        entry |= {part: clean[part] for part in ("ms", "cold_start", "peak_memory_gib")}
        entry["cold_start"]["checking"] = _checking(work / label)
        entry["cold_start_here"] = here["cold_start"]
        entry["start_ratio"] = clean["cold_start"]["whole"] / here["cold_start"]["whole"]


def _evaluated(folder: Path, work: Path, searches: int) -> dict[str, Any]:
    """What `active-perceiver evaluate` says of an agent; what it caches of the views goes with the work folder.

    Raises:
        UserError: if it failed.
    """
    out = work / f"{folder.name}.json"
    done = subprocess.run(
        [
            sys.executable, "-m", "active_perceiver", "evaluate", str(folder), "--searches", str(searches),
            "--out", str(out),
        ],
        env={**os.environ, "ACTIVE_PERCEIVER_CACHE": str(work / f"cache_{folder.name}")},
        stdout=subprocess.DEVNULL,  # its progress is on standard error, for the user to see
        check=False,
    )  # fmt: skip
    if done.returncode != 0:
        raise UserError(f"the exported agent could not be evaluated (exit code {done.returncode}); see above")
    result = json.loads(out.read_text())
    kept = ("overall", "per_target", "unseen_pictures", "detection", "stop_evaluation")
    return {name: result[name] for name in kept if name in result}
