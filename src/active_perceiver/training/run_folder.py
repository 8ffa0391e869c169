"""The folder of a training in progress: `OUT.part`, which becomes the agent when all is done."""

from __future__ import annotations

import json
import shutil
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import asdict
from pathlib import Path

from active_perceiver.errors import UserError
from active_perceiver.training.config import TrainConfig
from active_perceiver.utils.files import OutputExistsError, replacing
from active_perceiver.version import __version__


class RunFolder:
    """Where a training is written until it is done, and how long its stages took.

    Made before anything long begins: what is in the way shows then, and nothing is written before `begin`.

    Args:
        config: what is to be trained.
        out: folder of the agent.
        force: replace an agent that is there, and begin anew where a training was interrupted.
        resume: go on with an interrupted training.

    Attributes:
        path: of the folder.
        seconds: stage -> what it took; see `timed`.

    Raises:
        OutputExistsError: if there is something already, and neither `force` nor `resume` says what to do, or it is
            not ours to replace.
        UserError: if the interrupted training has other settings.
    """

    def __init__(self, config: TrainConfig, out: Path, *, force: bool, resume: bool) -> None:
        self.path = out.with_name(f"{out.name}.part")
        self.seconds: dict[str, float] = {}
        self._out, self._resume = out, resume
        self._noted = json.dumps({"version": __version__, **asdict(config)}, indent=2)
        if out.exists() and not force:
            raise OutputExistsError(f"{out} exists; give another --out, or --force to replace it")
        for folder, sign in ((out, "config.json"), (self.path, "settings.json")):
            if folder.exists() and not (folder / sign).is_file() and (not folder.is_dir() or any(folder.iterdir())):
                raise OutputExistsError(f"{folder} is not an agent and will not be replaced; give another --out")
        if self._note.is_file() and resume:
            if self._note.read_text() != self._noted:
                raise UserError(
                    f"{self.path} was begun with other settings; give the same ones, or --force to begin anew"
                )
        elif self.path.exists() and not force:
            raise OutputExistsError(f"{self.path} is an interrupted training; --resume goes on, --force begins anew")

    @property
    def _note(self) -> Path:
        return self.path / "settings.json"

    def begin(self) -> None:
        """Make or keep the folder, and note the settings in it."""
        if self.path.exists() and not self._resume:
            shutil.rmtree(self.path)
        self.path.mkdir(parents=True, exist_ok=True)
        with replacing(self._note) as temporary:
            temporary.write_text(self._noted)

    def finish(self) -> None:
        """Make the folder the agent's."""
        self._note.unlink()
        if self._out.exists():
            shutil.rmtree(self._out)
        self.path.rename(self._out)

    @contextmanager
    def timed(self, stage: str) -> Iterator[None]:
        """Note what the block takes as the seconds of a stage."""
        started = time.monotonic()
        yield
        self.seconds[stage] = time.monotonic() - started
