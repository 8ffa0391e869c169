"""The command `active-perceiver bridge`: a simulated TurtleBot behind rosbridge, to try things without a robot.

As in `cli/main.py`, a command is a dataclass whose fields are its arguments, their docstrings the help.
"""

from __future__ import annotations

import time
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

from tyro.conf import Positional, subcommand

from active_perceiver.cli.help import help_text
from active_perceiver.errors import UserError


@dataclass
class Bridge:
    """A simulated TurtleBot in a rendered room, behind rosbridge."""

    room: Positional[str]
    """The room, as scenes are called: conference_room, kitchen_1, kitchen_1_hour_dusk, kitchen_1_moved_2."""
    port: int = 9090
    """Where to serve on this machine; 0 for any port that is free."""
    robot_config: str = "turtlebot2"
    """Whose topics to serve: turtlebot2, turtlebot3, turtlebot4, or a YAML file."""
    write_config: Path | None = None
    """Write these settings, with step, tilts and actions of the room, into this YAML file, for --robot-config."""
    start: int | None = None
    """State of the room's lattice to start in; near a random one if not given."""
    seed: int | None = None
    """The start and the wheels' slip follow from it."""
    force: bool = False
    """Replace an existing YAML file."""

    def run(self) -> int:
        import numpy as np

        from active_perceiver.robots.ros.config_file import load_config, save_config
        from active_perceiver.simulation.simulated_robot import (
            bridge_in,
            fitted_config,
            lattice_start,
            open_room,
            random_start,
        )
        from active_perceiver.utils.files import check_output

        if not 0 <= self.port < 65536:
            raise UserError(f"a port is a number in 0..65535, got {self.port}")
        written = self.write_config
        if written is not None:
            check_output(written, self.force)
        preset = load_config(self.robot_config)
        room = open_room(self.room, seed=self.seed or 0)
        settings = fitted_config(room, preset)
        if self.start is None:
            start = random_start(room, np.random.default_rng(self.seed))
        else:
            start = lattice_start(room, self.start)
        with bridge_in(room, start, settings, seed=self.seed, port=self.port) as bridge:
            if written is not None:
                save_config(settings, written, force=self.force)
            x, z, heading, _ = start
            print(f"a TurtleBot at x {x:.2f} m, z {z:.2f} m, heading {heading:.0f} in {self.room}: {bridge.url}")
            config = self.robot_config if written is None else written
            print(
                "search with it, in another terminal: active-perceiver search AGENT --picture PICTURE --robot "
                f"ros:{bridge.url} --robot-config {config}"
            )
            if written is None and settings != preset:
                print(
                    f"step, tilts or actions of {room.name} are not those of {self.robot_config}; --write-config "
                    "FILE writes settings that fit"
                )
            print("Ctrl-C ends it", flush=True)
            try:
                while True:
                    time.sleep(1)
            except KeyboardInterrupt:
                print("ended")
        return 0


BridgeCommand = Annotated[
    Bridge,
    subcommand(
        "bridge",
        description=help_text(
            "Serve a simulated TurtleBot in a rendered room behind rosbridge, on this machine only, until Ctrl-C "
            "(needs the `ros` and the `rooms` extra): for searches with --robot ros:, and for any other client of "
            "rosbridge.",
            "bridge conference_room --write-config robot.yaml",
            "bridge kitchen_1_hour_dusk --port 9091 --seed 3 --write-config robot.yaml",
        ),
    ),
]
