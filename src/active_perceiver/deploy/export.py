"""An agent as one folder for a robot: nothing in it is looked up elsewhere, and every file has a checksum."""

from __future__ import annotations

import shutil
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from active_perceiver.agent.checksums import write_checksums
from active_perceiver.agent.config import AgentError, picture_folder
from active_perceiver.agent.exploration import map_file
from active_perceiver.agent.goals import GOALS
from active_perceiver.agent.perceiver import ActivePerceiver
from active_perceiver.agent.target_matching import PICTURES_FILE
from active_perceiver.deploy.quantize import quantise_backbone
from active_perceiver.errors import UserError
from active_perceiver.scenes import open_scene, read_image
from active_perceiver.utils.files import OutputExistsError, check_output, replacing_folder
from active_perceiver.utils.progress import console
from active_perceiver.version import __version__
from active_perceiver.vision.backbone import FILE_NAME

IMAGES = 48
"""A backbone's ranges are set by at most so many pictures; more change nothing that could be measured."""

PARTS = {
    "backbone": (FILE_NAME,),
    "recogniser": ("recogniser.onnx",),
    "policy": ("policy.onnx",),
    "maps of rooms": ("maps",),
    "pictures of targets": ("targets", PICTURES_FILE),
}
"""What takes room in an exported agent, and where it is; the rest is `config.json`, `README.md` and the checksums."""

README = """# {name}: an agent for a robot

It searches {scenes} for {targets}. `active-perceiver export` {version} put it together{numbers};
everything that it needs is in this folder. On the robot (Python 3.10 or newer, no GPU):

```
python3 -m venv robot && . robot/bin/activate
pip install numpy onnxruntime pillow
pip install --no-deps ./active-object-perceiver   # this software: its clone or its wheel
python -m active_perceiver.deploy.try_agent {name} --picture {picture} frame.jpg
```

The last line prints what the agent makes of one image of the camera. A search, with a robot that is any class with
the methods of `active_perceiver.robots.Robot`:

```python
from active_perceiver import ActivePerceiver, SearchConfig, read_image, search

agent = ActivePerceiver.from_pretrained("{name}")
record = search(agent, robot, read_image("{picture}"), SearchConfig(scene="{scene}"))
```

`checksums.json` is compared with the files whenever the agent is loaded.

Nothing of this calls anybody: the software tells ONNX Runtime so before it loads it. If your own program imports
`onnxruntime` before `active_perceiver`, set `ORT_DISABLE_TELEMETRY=1` in its environment.
"""


@dataclass(frozen=True)
class Exported:
    """What was written.

    Attributes:
        folder: where.
        megabytes: by part, see `PARTS`, and the rest.
    """

    folder: Path
    megabytes: dict[str, float]

    def __str__(self) -> str:
        lines = [f"{part:<20} {size:8.2f} MB" for part, size in self.megabytes.items()]
        total = sum(self.megabytes.values())
        lines += [f"{'all':<20} {total:8.2f} MB", f"exported: {self.folder}   how to run it: its README.md"]
        return "\n".join(lines)


def export_agent(
    agent: Path, out: Path, *, int8: bool = False, calibrate: str | None = None, force: bool = False
) -> Exported:
    """Write an agent to a new folder that holds all it needs to run, and nothing else.

    The folder appears whole or not at all, after the agent in it was loaded.

    Args:
        agent: its folder.
        out: the new one.
        int8: whether the backbone computes with 8-bit numbers.
        calibrate: the scene, by name or file, by whose views the ranges of these numbers are set; the agent's own
            pictures of its targets if not given.
        force: replace an agent that is there.

    Raises:
        OutputExistsError: if `out` exists and `force` is false, or is not an agent's folder, or the one exported.
        UserError: if the agent or the scene cannot be read, or int8 is asked for and `onnx` is not installed.
    """
    _check_output(agent, out, force)
    if calibrate is not None and not int8:
        raise UserError("a scene to calibrate by is of use with --int8 only; give that too, or leave out --calibrate")
    loaded = ActivePerceiver.from_pretrained(agent)
    for target in loaded.config.targets:
        if not any(picture_folder(agent, target.scene, target.name).glob("*")):
            raise AgentError(f"{agent} holds no pictures of '{target.name}'; copy the whole agent")
    images = _calibration_images(agent, calibrate) if int8 else []
    with replacing_folder(out, force) as folder:
        for name in ("config.json", "policy.onnx", *loaded.goal_detector.files):
            shutil.copyfile(agent / name, folder / name)
        shutil.copytree(agent / "targets", folder / "targets")
        for branch in loaded.config.branches:
            if (room := map_file(agent, branch)).is_file():
                map_file(folder, branch).parent.mkdir(exist_ok=True)
                shutil.copyfile(room, map_file(folder, branch))
        if int8:
            with console.status(f"8-bit numbers by {len(images)} pictures"):
                quantise_backbone(loaded.backbone.path, folder / FILE_NAME, images, loaded.config.image_size)
        else:
            shutil.copyfile(loaded.backbone.path, folder / FILE_NAME)
        exported = ActivePerceiver.from_pretrained(folder)
        if GOALS[exported.config.task].has_boxes:
            # They depend on the backbone: what was computed with another one does not fit.
            exported.gallery.save_pictures()
        (folder / "README.md").write_text(_readme(exported, out.name, int8), encoding="utf-8")
        write_checksums(folder)
        megabytes = _megabytes(folder)
    return Exported(out, megabytes)


def _check_output(agent: Path, out: Path, force: bool) -> None:
    """Make sure that nothing is replaced that should not be, before anything is computed."""
    if not out.exists():
        return
    if agent.resolve() == out.resolve() or out.resolve() in agent.resolve().parents:
        raise OutputExistsError(f"{out} holds the agent itself; give another folder to export it to")
    check_output(out, force)
    if not (out / "config.json").is_file() and (not out.is_dir() or any(out.iterdir())):
        raise OutputExistsError(f"{out} is not an agent and will not be replaced; give another folder")


def _calibration_images(agent: Path, scene: str | None) -> list[NDArray[np.uint8]]:
    if scene is not None:
        opened = open_scene(scene)
        return [opened.view(state) for state in _spread(len(opened))]
    files = sorted(path for path in (agent / "targets").rglob("*") if path.is_file())
    return [read_image(files[index]) for index in _spread(len(files))]


def _spread(count: int) -> list[int]:
    """At most `IMAGES` numbers below `count`, evenly spread."""
    return np.linspace(0, count - 1, min(IMAGES, count)).round().astype(int).tolist()


def _readme(agent: ActivePerceiver, name: str, int8: bool) -> str:
    config = agent.config
    first = config.targets[0]
    picture = min(picture_folder(agent.folder, first.scene, first.name).glob("*"))
    return README.format(
        name=name,
        scenes=", ".join(config.branches),
        targets=("" if GOALS[config.task].has_boxes else "the views ")
        + ", ".join(dict.fromkeys(target.name for target in config.targets)),
        version=__version__,
        numbers=", its backbone with 8-bit numbers" if int8 else "",
        picture=f"{name}/{picture.relative_to(agent.folder).as_posix()}",
        scene=first.scene,
    )


def _megabytes(folder: Path) -> dict[str, float]:
    sizes = {path: path.stat().st_size / 1e6 for path in folder.rglob("*") if path.is_file()}
    by_part = {
        part: sum(size for path, size in sizes.items() if path.relative_to(folder).parts[0] in names)
        for part, names in PARTS.items()
    }
    return {**by_part, "the rest": sum(sizes.values()) - sum(by_part.values())}
