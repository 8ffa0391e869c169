"""The command `active-perceiver demo`."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path
from typing import Annotated

from tyro.conf import subcommand

from active_perceiver.cli.help import help_text


@dataclass
class Demo:
    """The main job on a bundled room."""

    out: Path = Path("demo")
    """Folder for the agent, the report, the videos and result.json."""
    seed: int = 0
    """Training and searches follow from it."""
    force: bool = False
    """Replace what an earlier demo left in the folder."""
    resume: bool = False
    """Go on where an interrupted demo stopped."""

    def run(self) -> int:
        from active_perceiver.cli.demo_run import SETTINGS, run_demo

        run_demo(self.out, replace(SETTINGS, seed=self.seed), force=self.force, resume=self.resume)
        return 0


DemoCommand = Annotated[
    Demo,
    subcommand(
        "demo",
        description=help_text(
            "Train on the bundled kitchen, measure, search for four objects from pictures, write a report.",
            "demo",
            "demo --out my_demo --seed 3",
        ),
    ),
]
