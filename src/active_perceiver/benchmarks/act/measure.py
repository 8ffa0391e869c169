"""How long one action takes, from an encoded picture to the command, and what a start costs."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.figure import Figure
from PIL import Image

from active_perceiver.agent.config import AgentConfig
from active_perceiver.benchmarks.act.report import format_act_speed, time_bars
from active_perceiver.benchmarks.act.worker import PARTS
from active_perceiver.benchmarks.config import ActSpeedConfig
from active_perceiver.benchmarks.runner import Benchmark, ResultBody
from active_perceiver.errors import UserError
from active_perceiver.figures.speed import parts_figure
from active_perceiver.parallel.run_store import RunStore
from active_perceiver.scenes import Scene, open_scene
from active_perceiver.scenes.images import encode_image
from active_perceiver.utils.progress import ProgressCallback, progress_bar, quiet
from active_perceiver.vision.backbone import BACKBONES, FILE_NAME, cached_path, check_backbone, load_backbone

# Different views take differently long to decode; these are spread over the scene.
FRAMES = 32
# An agent is usually trained for so many targets.
TARGETS = 4


@dataclass(frozen=True)
class _Subject:
    """An agent to measure."""

    folder: Path
    backbone: str
    image_size: int
    weights: str


@dataclass(frozen=True)
class ActBenchmark(Benchmark):
    """How long one action takes."""

    name = "act"
    settings: ActSpeedConfig

    def prepare(self) -> None:
        """See `Benchmark`."""
        _check(self.settings)

    def measure(self, store: RunStore) -> ResultBody:
        """See `measure_act_speed`."""
        with progress_bar("processes") as report:
            return measure_act_speed(self.settings, report)

    def report(self, body: ResultBody) -> str:
        """See `format_act_speed`."""
        return format_act_speed(body)

    def figure(self, body: ResultBody) -> Figure:
        """Where the time of an action goes."""
        return parts_figure(time_bars(body))


def measure_act_speed(settings: ActSpeedConfig, progress: ProgressCallback = quiet) -> ResultBody:
    """Time actions in fresh processes, one after the other.

    Args:
        settings: what to measure.
        progress: called with the processes done and to do.

    Returns:
        "protocol"; "actions": for each backbone and number of threads {"backbone", "image_size", "weights",
        "threads", "ms": for each part, the "rest" and the "whole" {"median", "p95", "mean"}, "cold_start": median
        seconds of its parts and the whole, "peak_memory_gib", "torch_imported", "torch": the same of the backbone
        run eagerly by torch, None if it is not installed}. Means of the parts and the rest add up to the whole's.
    """
    scene = open_scene(settings.scene)
    scene.require_targets()
    actions = []
    with tempfile.TemporaryDirectory(prefix="active-perceiver-") as name:
        work = Path(name)
        pictures = write_pictures(scene, settings.frame, work)
        kinds = 1 if find_spec("torch") is None else 2
        subjects = [settings.agent] if settings.agent is not None else list(settings.backbones or BACKBONES)
        total = len(subjects) * len(settings.threads) * settings.starts * kinds
        processes = iter(range(1, total + 1))
        for subject in _subjects(settings, scene, work):
            for threads in settings.threads:
                about = {"backbone": subject.backbone, "image_size": subject.image_size}
                common = {"frames": pictures["frames"], "threads": threads, "repeats": settings.repeats}
                agent = {"run": "agent", "folder": str(subject.folder), "picture": pictures["picture"], **common}
                eager = {"run": "torch", **about, **common}
                runs: list[list[dict[str, Any]]] = [[], []]
                # By turns, so that a disturbance meets both.
                for _ in range(settings.starts):
                    for kept, request in zip(runs, (agent, eager)[:kinds], strict=False):
                        kept.append(run_process(request))
                        progress(next(processes), total, f"{subject.backbone}, {threads} thread(s)")
                measured = summary_of(runs[0])
                torch = summary_of(runs[1]) if runs[1] else None
                actions.append({**about, "weights": subject.weights, "threads": threads, **measured, "torch": torch})
    protocol = {
        "scene": scene.name,
        "frames": len(pictures["frames"]),
        "frame": list(settings.frame),
        "encoding": "jpeg",
        "starts": settings.starts,
        "repeats": settings.repeats,
        "torch_weights": "random",
    }
    return {"protocol": protocol, "actions": actions}


def _check(settings: ActSpeedConfig) -> None:
    if not settings.threads or min(*settings.threads, settings.repeats, settings.starts, *settings.frame) < 1:
        raise UserError("threads, repeats, starts and the sides of the camera's pictures must be at least 1")
    if settings.agent is not None and settings.backbones:
        raise UserError("an agent has a backbone of its own; give --agent or --backbones, not both")
    for name in settings.backbones:
        check_backbone(name, settings.image_size)


def _subjects(settings: ActSpeedConfig, scene: Scene, work: Path) -> Iterator[_Subject]:
    if settings.agent is not None:
        config = AgentConfig.load(settings.agent)
        yield _Subject(settings.agent, config.backbone, config.image_size, "the agent's")
        return
    for name in settings.backbones or BACKBONES:
        folder = work / name
        weights = _make_agent(folder, name, settings.image_size, scene)
        yield _Subject(folder, name, settings.image_size, weights)


def _make_agent(folder: Path, name: str, image_size: int, scene: Scene) -> str:
    """Write an agent with random weights; says of which origin those of its backbone are."""
    try:
        from active_perceiver.benchmarks.act.untrained_agent import save_untrained_agent
        from active_perceiver.vision.untrained import save_untrained_backbone
    except ImportError as error:
        raise UserError(
            f"making an agent with random weights needs {error.name}: pip install 'active-perceiver[train]', or give "
            "a trained agent with --agent"
        ) from None
    cached = cached_path(name, image_size).exists()
    if cached:
        backbone = load_backbone(name, image_size=image_size, threads=1)
    else:
        backbone = save_untrained_backbone(name, folder / FILE_NAME, image_size, threads=1)
    save_untrained_agent(folder, backbone, scene, scene.target_names[:TARGETS])
    return "published backbone, random recogniser and policy" if cached else "random"


def write_pictures(scene: Scene, frame: tuple[int, int], work: Path) -> dict[str, Any]:
    """What the camera sees, and a picture of the first target, as files."""
    frames = []
    for number, state in enumerate(np.linspace(0, len(scene) - 1, min(FRAMES, len(scene)), dtype=int).tolist()):
        image = Image.fromarray(scene.view(state)).resize(frame, Image.Resampling.BICUBIC)
        path = work / f"frame_{number:02}.jpg"
        path.write_bytes(encode_image(np.asarray(image), "jpeg"))
        frames.append(str(path))
    picture = work / "picture"
    picture.write_bytes(scene.targets[0].pictures[0])
    return {"frames": frames, "picture": str(picture)}


def run_process(
    request: dict[str, Any], python: Path | str = sys.executable, variables: Mapping[str, str] = os.environ
) -> dict[str, Any]:
    """What a fresh process prints; see `worker.py`.

    Args:
        request: what it is to do.
        python: the interpreter.
        variables: of its environment; numbers of threads are added.

    Raises:
        UserError: if it failed; what it says last is why.
    """
    threads = str(request["threads"])
    done = subprocess.run(
        [
            str(python), "-m", "active_perceiver.benchmarks.act.worker",
            json.dumps({**request, "launched": time.time()}),
        ],
        env={**variables, "OMP_NUM_THREADS": threads, "OPENBLAS_NUM_THREADS": threads},
        capture_output=True, text=True, check=False,
    )  # fmt: skip
    if done.returncode != 0:
        said = done.stderr.strip().splitlines() or [f"exit code {done.returncode}"]
        raise UserError(f"acting failed: {said[-1]}")
    return json.loads(done.stdout)


def summary_of(runs: Sequence[dict[str, Any]]) -> dict[str, Any]:
    """One description of the processes that did the same."""
    seconds = {part: np.concatenate([run["seconds"][part] for run in runs]) for part in runs[0]["seconds"]}
    if "whole" in seconds:
        rest = seconds["whole"] - sum(seconds[part] for part in PARTS)
        seconds = {**{part: seconds[part] for part in PARTS}, "rest": rest, "whole": seconds["whole"]}
    memory = [run["peak_memory_gib"] for run in runs]
    return {
        "ms": {part: _spread(1000 * times) for part, times in seconds.items()},
        "cold_start": {
            part: float(np.median([run["cold_start"][part] for run in runs])) for part in runs[0]["cold_start"]
        },
        "peak_memory_gib": None if None in memory else max(memory),
        "torch_imported": any(run["torch"] for run in runs),
    }


def _spread(times: Any) -> dict[str, float]:
    return {
        "median": float(np.median(times)),
        "p95": float(np.percentile(times, 95)),
        "mean": float(times.mean()),
    }
