"""One search, live: what `search` does, and what the demo does for each of its targets."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from PIL import Image

from active_perceiver.experiments.result import write_result
from active_perceiver.experiments.robot_places import robot_at
from active_perceiver.figures.annotate import draw_detection
from active_perceiver.figures.floor import figure_png, trajectory_figure
from active_perceiver.figures.video import write_video
from active_perceiver.files import OutputExistsError, replacing
from active_perceiver.perceiver import ActivePerceiver
from active_perceiver.robots import Glimpse, SearchRecord, search
from active_perceiver.scenes import Action, Scene, read_image


def search_command(
    agent_folder: Path,
    picture: Path,
    robot: str,
    *,
    robot_config: str | None = None,
    start: int | None = None,
    branch: str | None = None,
    max_steps: int = 200,
    max_seconds: float = 600.0,
    seed: int | None = None,
    threads: int | None = None,
    confirm: bool = False,
    explore: bool = True,
    out: Path | None = None,
    force: bool = False,
) -> bool:
    """Search, print each step, and write video, path, final view and the steps if a folder is given.

    Returns:
        Whether the agent says that it found what it searched for.

    Raises:
        UserError: if the picture, the agent, the robot or the output folder are not what they should be.
    """
    image = read_image(picture)
    if out is not None and out.exists() and not force and any(out.iterdir()):
        raise OutputExistsError(f"{out} is not empty; give another --out, or --force to replace what is in it")
    agent = ActivePerceiver.from_pretrained(agent_folder, threads, confirm=confirm, explore=explore)

    def actions_in(name: str) -> tuple[Action, ...]:
        """Those of the policy branch that will be used there; `search` refuses one that there is not."""
        branches = agent.config.branches
        chosen = branch or name
        return agent.config.actions(chosen if chosen in branches else next(iter(branches)))

    place = robot_at(robot, actions_in, start, seed, robot_config)
    if branch is None and place.name in agent.config.branches:
        branch = place.name
    with place.robot as driven:
        print(f"searching for {picture.name} in {place.name}, from {place.start}, at most {max_steps} actions")
        record = search(
            agent, driven, image, branch=branch, max_steps=max_steps, max_seconds=max_seconds, seed=seed,
            on_glimpse=_print_glimpse,
        )  # fmt: skip
    print(verdict(record))
    if out is not None:
        write_search(record, place.scene, picture.stem, out, place.name)
        path = "" if place.scene is None else "path.png, "
        print(f"written: {out}/search.mp4, {path}final.png, search.json")
    return record.found


def _print_glimpse(actions: int, glimpse: Glimpse) -> None:
    step = glimpse.step
    seen = (
        "-"
        if step.detection is None
        else f"{step.detection.score:.2f}, {100 * step.detection.area:.1f} % of the view"
    )
    print(f"{actions:>4}  sees {seen:<26} {'found' if step.found else step.action.value}", flush=True)


def verdict(record: SearchRecord) -> str:
    """One line on how a search ended."""
    if record.found:
        return f"found after {record.actions} actions in {record.seconds:.1f} s"
    return f"not found: gave up after {record.actions} actions, {record.seconds:.1f} s"


def write_search(record: SearchRecord, scene: Scene | None, label: str, out: Path, name: str) -> None:
    """Write `search.mp4`, `path.png`, `final.png` and `search.json` into a folder.

    Args:
        record: the search.
        scene: for the floor plan; without it there is no `path.png`.
        label: name of what was searched.
        out: the folder.
        name: of the scene or room.
    """
    write_video(record, out / "search.mp4", scene, label, force=True)
    if scene is not None:
        with replacing(out / "path.png") as temporary:
            temporary.write_bytes(path_png(record, scene, label))
    last = record.glimpses[-1]
    with replacing(out / "final.png") as temporary:
        Image.fromarray(draw_detection(last.image, last.step.detection, label)).save(temporary)
    steps = [
        {
            "pose": glimpse.pose,
            "action": glimpse.step.action.value,
            "score": None if glimpse.step.detection is None else glimpse.step.detection.score,
            "box": None if glimpse.step.detection is None else glimpse.step.detection.box.tolist(),
            "probabilities": glimpse.step.probabilities.tolist(),
            "found": glimpse.step.found,
        }
        for glimpse in record.glimpses
    ]
    body = {"scene": name, "found": record.found, "actions": record.actions, "seconds": record.seconds}
    write_result(out / "search.json", "search", {**body, "steps": steps})


def path_png(record: SearchRecord, scene: Scene, label: str, goals: np.ndarray | None = None) -> bytes:
    """The search's path on the floor plan, with the goal states if they are known."""
    poses = [glimpse.pose for glimpse in record.glimpses if glimpse.pose is not None]
    return figure_png(trajectory_figure(scene, [np.array(poses)], goals, f"{label}: {record.actions} actions"))
