"""The state of an A3C training in a file, so that one that was interrupted goes on."""

from __future__ import annotations

import json
from dataclasses import asdict, dataclass
from pathlib import Path

import torch
from safetensors import SafetensorError, safe_open
from safetensors.torch import save_file

from active_perceiver.errors import SearchError
from active_perceiver.policies.a3c.worker import SharedWeights
from active_perceiver.policies.config import A3cConfig
from active_perceiver.policies.monitor import Record
from active_perceiver.utils.files import replacing

_KINDS = ("weights", "squares")


@dataclass
class Checkpoint:
    """How far a training has come; the weights themselves are `SharedWeights`.

    Attributes:
        config: the settings it was begun with, as JSON.
        updates: of the shared weights so far.
        samples: steps of all episodes so far.
        episodes: how many each worker has lived.
        history: records so far.
    """

    config: str
    updates: int
    samples: int
    episodes: list[int]
    history: list[Record]

    @classmethod
    def start(cls, config: A3cConfig, workers: int) -> Checkpoint:
        """Of a training that has not begun."""
        return cls(_settings(config), 0, 0, [0] * workers, [])

    def save(self, path: Path, shared: SharedWeights) -> None:
        """Write the state and the weights, atomically."""
        tensors = {f"weights.{name}": value.detach() for name, value in shared.network.named_parameters()}
        names = [name for name, _ in shared.network.named_parameters()]
        tensors |= {f"squares.{name}": square for name, square in zip(names, shared.squares, strict=True)}
        with replacing(path) as temporary:
            save_file(tensors, temporary, {"a3c": json.dumps(asdict(self))})

    @classmethod
    def load(cls, path: Path, config: A3cConfig, shared: SharedWeights) -> Checkpoint:
        """Read the state, and the weights into `shared`.

        Args:
            path: as `save` wrote it.
            config: must be what the training was begun with.
            shared: of the same problems; is overwritten.

        Raises:
            SearchError: if the file is damaged, or of another training.
        """
        try:
            with safe_open(path, "pt") as file:
                state = cls(**json.loads(file.metadata()["a3c"]))
                tensors = {name: file.get_tensor(name) for name in file.keys()}  # noqa: SIM118
        except (SafetensorError, KeyError, TypeError, ValueError, OSError) as error:
            raise SearchError(f"{path} is no checkpoint of a3c ({error}); remove it to begin anew") from None
        parameters = dict(shared.network.named_parameters())
        expected = {
            f"{kind}.{name}": value.shape for name, value in parameters.items() for kind in ("weights", "squares")
        }
        if state.config != _settings(config) or {name: value.shape for name, value in tensors.items()} != expected:
            raise SearchError(f"{path} was begun with other settings or scenes; give the same, or remove it")
        with torch.no_grad():
            for (name, parameter), square in zip(parameters.items(), shared.squares, strict=True):
                parameter.copy_(tensors[f"weights.{name}"])
                square.copy_(tensors[f"squares.{name}"])
        return state


def _settings(config: A3cConfig) -> str:
    return json.dumps(asdict(config))
