"""The command `active-perceiver train`."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import Annotated

from tyro.conf import OmitArgPrefixes, subcommand

from active_perceiver.cli.help import help_text
from active_perceiver.training.config import TrainConfig


@dataclass
class Train:
    """Train an agent."""

    out: Path
    """Folder of the new agent."""
    settings: OmitArgPrefixes[TrainConfig] = field(default_factory=TrainConfig)
    force: bool = False
    """Replace an agent that is there."""
    resume: bool = False
    """Go on where an interrupted training stopped."""

    def run(self) -> int:
        from active_perceiver.evaluation.evaluate import format_measures
        from active_perceiver.training.train import train

        result = train(self.settings, self.out, force=self.force, resume=self.resume)
        print(format_measures(result.to_json()))
        print(f"agent: {self.out}   measured: {self.out / 'result.json'}")
        return 0


TrainCommand = Annotated[
    Train,
    subcommand(
        "train",
        description=help_text(
            "Train a recogniser and a policy, or, with --task view, a policy alone; the result is a folder that "
            "runs without torch.",
            "train --out kitchen_agent",
            "train --scenes kitchen_1 --targets mug plate --out agent --learner ppo --reward gain",
            "train --task view --scenes kitchen_1 --targets 12 345 700 --out zhu_agent",
        ),
    ),
]
