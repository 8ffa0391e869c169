"""The demo: the whole job on the bundled kitchen, from a picture of a mug to the mug in a box."""

from __future__ import annotations

import json
import time
from dataclasses import asdict, replace
from pathlib import Path
from typing import Any

import numpy as np
from PIL import Image

from active_perceiver.agent.perceiver import ActivePerceiver
from active_perceiver.envs.task import SearchTask
from active_perceiver.errors import UserError
from active_perceiver.evaluation.evaluate import format_measures
from active_perceiver.figures.filmstrip import filmstrip
from active_perceiver.live import SearchConfig, search
from active_perceiver.reports.demo_report import DemoSearch, write_report
from active_perceiver.reports.search_report import verdict, write_search
from active_perceiver.robots import RecordedRobot
from active_perceiver.scenes import Scene, open_scene
from active_perceiver.training.config import TrainConfig
from active_perceiver.training.recogniser_stage import measure_recogniser
from active_perceiver.training.train import train
from active_perceiver.utils.files import OutputExistsError, replacing
from active_perceiver.utils.result import write_result

SETTINGS = TrainConfig(scenes=("kitchen_1",), targets=("mug", "plate", "bread", "apple"))


def run_demo(
    out: Path, settings: TrainConfig = SETTINGS, *, force: bool = False, resume: bool = False
) -> dict[str, Any]:
    """Train, measure, search and report; prints where to look.

    Args:
        out: folder for everything.
        settings: what to train, in one scene; starts and actions follow from their seed too.
        force: replace what an earlier demo left there.
        resume: go on where an interrupted demo stopped.

    Returns:
        The body of the result file.

    Raises:
        OutputExistsError: if the folder holds a demo and neither `force` nor `resume` is set.
    """
    started = time.monotonic()
    if (out / "result.json").exists() and not (force or resume):
        raise OutputExistsError(f"{out} holds a demo already; give another --out, or --force to replace it")
    _check_same_settings(out, settings, resume)
    agent_done = _finished(out / "agent" / "result.json", resume)
    pooled_done = _finished(out / "pooled_recogniser.json", resume)
    trained = agent_done or train(settings, out / "agent", force=force, resume=resume).to_json()
    pooled = pooled_done or _pooled_figures(settings, out)
    agent = ActivePerceiver.from_pretrained(out / "agent")
    scene = open_scene(settings.scenes[0])
    found = [_search_for(agent, scene, name, out, settings.seed) for name in settings.targets]
    body = {
        **trained,
        "recogniser": {"matching": trained["recogniser"], "pooled": pooled},
        "searches": [asdict(item.summary) for item in found],
    }
    # What an interrupted demo had finished took its time too.
    earlier = (agent_done["seconds"]["total"] if agent_done else 0.0) + (
        pooled_done["seconds"] if pooled_done else 0.0
    )
    body["seconds"] = {**trained["seconds"], "demo": earlier + time.monotonic() - started}
    result = write_result(out / "result.json", "demo", body)
    write_report(out / "report.html", agent, result, found)
    print(format_measures(body))
    for item in found:
        print(f"{item.summary.target}: {verdict(item.record)}")
    print(f"\nlook at {out}/report.html; videos are {out}/<target>/search.mp4, numbers in {out}/result.json")
    return result


def _check_same_settings(out: Path, settings: TrainConfig, resume: bool) -> None:
    """A demo can only go on with the settings it was begun with."""
    trained = _finished(out / "agent" / "result.json", resume)
    if trained is not None and trained["settings"] != json.loads(json.dumps(asdict(settings))):
        raise UserError(f"{out} was begun with other settings; give the same ones, or --force to begin anew")


def _finished(path: Path, resume: bool) -> dict[str, Any] | None:
    """The result of a stage that an interrupted demo has finished."""
    return json.loads(path.read_text()) if resume and path.is_file() else None


def _pooled_figures(settings: TrainConfig, out: Path) -> dict[str, Any]:
    """The figures of the paper's recogniser on the same split, kept for a demo that is interrupted later."""
    figures = measure_recogniser(replace(settings, recogniser="pooled")).to_json()
    with replacing(out / "pooled_recogniser.json") as temporary:
        temporary.write_text(json.dumps(figures))
    return figures


def _search_for(agent: ActivePerceiver, scene: Scene, name: str, out: Path, seed: int) -> DemoSearch:
    """One search, from far away, with a picture that training has not seen."""
    task = SearchTask.from_scene(scene, [name])
    target = scene.targets[scene.target_index(name)]
    picture = target.picture(min(target.trained, len(target.pictures) - 1))
    far = np.argsort(-task.steps[:, 0], kind="stable")[: len(scene) // 10]
    start = int(np.random.default_rng([seed, scene.target_index(name)]).choice(far))
    with RecordedRobot(scene, start) as robot:
        record = search(agent, robot, picture, SearchConfig(scene=scene.name, seed=seed))
    write_search(record, scene, name, out / name, scene.name)
    strip = filmstrip(record, scene, name)
    with replacing(out / name / "filmstrip.png") as temporary:
        Image.fromarray(strip).save(temporary)
    return DemoSearch.of(record, scene, task, start, robot.state, out / name)
