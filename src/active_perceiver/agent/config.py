"""What an agent's folder says about itself: `config.json` and the pictures of the targets it was trained for."""

from __future__ import annotations

import json
from dataclasses import MISSING, asdict, dataclass, field, fields
from pathlib import Path
from typing import Literal, get_args

from active_perceiver.agent.training_record import TrainingRecord
from active_perceiver.errors import UserError
from active_perceiver.scenes import Action
from active_perceiver.utils.files import replacing
from active_perceiver.utils.json_reader import parse_json
from active_perceiver.utils.stored_names import AGENT, current_names

FORMAT = "active-perceiver-agent"
VERSION = 1

GoalName = Literal["object", "view"]
"""What a picture shows that an agent searches for: an object on its own, or a view of the scene."""


class AgentError(UserError, ValueError):
    """An agent folder that cannot be used; the message says which and what to do."""


@dataclass(frozen=True)
class KnownTarget:
    """A target the policy was trained for.

    Attributes:
        scene: the scene, and policy branch, it was trained in.
        name: the target's name there.
        stop_area_threshold: the agent says found when its own box covers at least this fraction of the image; a
            target that is a view fills it.
    """

    scene: str
    name: str
    stop_area_threshold: float = 1.0


@dataclass(frozen=True)
class AgentConfig:
    """How an agent is put together. Everything in it is plain data.

    Attributes:
        backbone: name of the frozen feature extractor.
        image_size: side in pixels to which views and pictures are scaled.
        recogniser: kind of recogniser, "matching" or "pooled"; None if it searches for views.
        score_threshold: presence probability from which on a detection counts.
        branches: policy branch (scene name) -> names of its actions.
        targets: what the policy was trained for.
        stop_area_threshold: `KnownTarget.stop_area_threshold` for a picture that shows none of them.
        match_threshold: cosine similarity of the recogniser's codes from which on a picture shows a known target.
        training: how it was trained.
        task: what it searches for; agents of before there was a choice search for objects.
        found_similarity: an agent that searches for views says found when the features of what it sees have at least
            this cosine similarity to those of the picture.
    """

    backbone: str
    image_size: int
    recogniser: str | None
    score_threshold: float
    branches: dict[str, list[str]]
    targets: list[KnownTarget]
    stop_area_threshold: float
    match_threshold: float
    training: TrainingRecord = field(default_factory=TrainingRecord)
    task: GoalName = "object"
    found_similarity: float = 1.0

    def __post_init__(self) -> None:
        if self.task not in get_args(GoalName):
            raise AgentError(f"an agent searches for one of {', '.join(get_args(GoalName))}, not '{self.task}'")

    def actions(self, branch: str) -> tuple[Action, ...]:
        """The actions of one branch, in the order of the policy's outputs."""
        return tuple(Action(name) for name in self.branches[branch])

    def save(self, folder: Path) -> None:
        """Write `config.json`, atomically."""
        text = json.dumps({"format": FORMAT, "version": VERSION, **asdict(self)}, indent=2)
        with replacing(folder / "config.json") as temporary:
            temporary.write_text(text + "\n")

    @classmethod
    def load(cls, folder: Path) -> AgentConfig:
        """Read `config.json`.

        Raises:
            AgentError: if the folder is no agent, or one of another version, or the file is damaged.
        """
        path = folder / "config.json"
        try:
            data = parse_json(path.read_bytes())
        except (FileNotFoundError, NotADirectoryError):
            raise AgentError(
                f"{folder} is not an agent: it has no config.json; `active-perceiver train` makes one"
            ) from None
        except (ValueError, OSError) as error:
            raise AgentError(f"{path} cannot be read as JSON: {error}") from None
        if not isinstance(data, dict) or data.pop("format", None) != FORMAT:
            raise AgentError(f"{path} does not describe an agent of this software")
        if (version := data.pop("version", None)) != VERSION:
            raise AgentError(f"{path} has version {version}; this software reads version {VERSION}: update it")
        data = current_names(data, AGENT)
        if data.get("recogniser") == "none":
            data["recogniser"] = None  # as version 0.1 wrote it
        names = {entry.name for entry in fields(cls)}
        optional = {e.name for e in fields(cls) if e.default is not MISSING or e.default_factory is not MISSING}
        if missing := names - optional - data.keys():
            raise AgentError(f"{path} lacks {', '.join(sorted(missing))}; train or copy the agent again")
        try:
            data["targets"] = [KnownTarget(**current_names(target, AGENT)) for target in data["targets"]]
            data["training"] = TrainingRecord.from_json(data.get("training", {}))
            config = cls(**{name: data[name] for name in names & data.keys()})
            for branch in config.branches:
                config.actions(branch)
        except (TypeError, ValueError, AttributeError) as error:
            raise AgentError(f"{path} is damaged: {error}; train or copy the agent again") from None
        return config


def picture_folder(folder: Path, scene: str, target: str) -> Path:
    """Where an agent keeps the pictures of one of its targets."""
    return folder / "targets" / scene / target
