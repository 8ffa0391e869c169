"""The command `active-perceiver pretrain`."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

from tyro.conf import subcommand

from active_perceiver.cli.help import help_text


@dataclass
class Pretrain:
    """Weights for recognisers to start from."""

    scenes: tuple[str, ...]
    """Bundled names or scene files; none of the rooms that recognisers will be trained in."""
    out: Path
    """The safetensors file."""
    steps: int = 4000
    """Training steps."""
    seed: int = 0
    """Everything random follows from it."""
    force: bool = False
    """Replace an existing file."""

    def run(self) -> int:
        from active_perceiver.training.pretrain import pretrain

        seconds = pretrain(self.scenes, self.out, steps=self.steps, seed=self.seed, force=self.force)
        print(f"weights: {self.out} ({seconds:.0f} s)")
        return 0


PretrainCommand = Annotated[
    Pretrain,
    subcommand(
        "pretrain",
        description=help_text(
            "Train the weights that recognisers of other rooms start from.",
            "pretrain --scenes rooms/kitchen_101.h5 rooms/living_room_101.h5 --out weights.safetensors",
        ),
    ),
]
