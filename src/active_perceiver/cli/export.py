"""The command `active-perceiver export`."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

from tyro.conf import Positional, subcommand

from active_perceiver.cli.help import help_text


@dataclass
class Export:
    """An agent as one folder for a robot."""

    agent: Positional[Path]
    """Folder of the agent."""
    out: Positional[Path]
    """The new folder."""
    int8: bool = False
    """Make the backbone compute with 8-bit numbers: smaller and, on most processors, faster; a little less exact."""
    calibrate: str | None = None
    """With --int8: the scene, a bundled name or a file, by whose views the ranges of these numbers are set; the
    agent's own pictures if not given."""
    force: bool = False
    """Replace an agent that is there."""

    def run(self) -> int:
        from active_perceiver.deploy.export import export_agent

        print(export_agent(self.agent, self.out, int8=self.int8, calibrate=self.calibrate, force=self.force))
        return 0


ExportCommand = Annotated[
    Export,
    subcommand(
        "export",
        description=help_text(
            "One folder with all that an agent needs to run; with it a robot needs numpy, onnxruntime and pillow "
            "only.",
            "export kitchen_agent kitchen_robot",
            "export kitchen_agent kitchen_robot_8 --int8 --calibrate kitchen_1",
        ),
    ),
]
