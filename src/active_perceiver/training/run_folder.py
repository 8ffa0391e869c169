"""The folder of a training in progress: `OUT.part`, which becomes the agent when all is done."""

from __future__ import annotations

import json
import shutil
from dataclasses import asdict
from pathlib import Path

from active_perceiver import __version__
from active_perceiver.errors import UserError
from active_perceiver.training.config import TrainConfig
from active_perceiver.utils.files import OutputExistsError, replacing


def checked_work_folder(settings: TrainConfig, out: Path, *, force: bool, resume: bool) -> Path:
    """Where a training is written until it is done, if nothing is in the way but what may be replaced.

    Args:
        settings: what is to be trained.
        out: folder of the agent.
        force: replace an agent that is there, and begin anew where a training was interrupted.
        resume: go on with an interrupted training.

    Raises:
        OutputExistsError: if there is something already, and neither `force` nor `resume` says what to do, or it is
            not ours to replace.
        UserError: if the interrupted training has other settings.
    """
    work = out.with_name(f"{out.name}.part")
    if out.exists() and not force:
        raise OutputExistsError(f"{out} exists; give another --out, or --force to replace it")
    for folder, sign in ((out, "config.json"), (work, "settings.json")):
        if folder.exists() and not (folder / sign).is_file() and (not folder.is_dir() or any(folder.iterdir())):
            raise OutputExistsError(f"{folder} is not an agent and will not be replaced; give another --out")
    if (work / "settings.json").is_file() and resume:
        if (work / "settings.json").read_text() != _noted(settings):
            raise UserError(f"{work} was begun with other settings; give the same ones, or --force to begin anew")
    elif work.exists() and not force:
        raise OutputExistsError(f"{work} is an interrupted training; --resume goes on, --force begins anew")
    return work


def begin(settings: TrainConfig, work: Path, *, resume: bool) -> None:
    """Make or keep the folder of the training in progress, and note the settings in it."""
    if work.exists() and not resume:
        shutil.rmtree(work)
    work.mkdir(parents=True, exist_ok=True)
    with replacing(work / "settings.json") as temporary:
        temporary.write_text(_noted(settings))


def finish(work: Path, out: Path) -> None:
    """Make the folder of the training the agent's."""
    (work / "settings.json").unlink()
    if out.exists():
        shutil.rmtree(out)
    work.rename(out)


def _noted(settings: TrainConfig) -> str:
    """What `settings.json` in the folder of a training in progress holds."""
    return json.dumps({"version": __version__, **asdict(settings)}, indent=2)
