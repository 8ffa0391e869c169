"""What `--robot KIND:NAME` means: a robot, and where it is."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from active_perceiver.errors import UserError
from active_perceiver.robots import RecordedRobot, Robot
from active_perceiver.robots.ai2thor import ThorConfig, ThorRobot, captured_config, start_controller
from active_perceiver.robots.ros.config_file import load_config, presets
from active_perceiver.robots.ros.robot import RosRobot
from active_perceiver.scenes import Action, Scene, bundled_names, open_scene

ActionsIn = Callable[[str], tuple[Action, ...]]


@dataclass(frozen=True)
class Place:
    """A robot somewhere.

    Attributes:
        robot: what looks and acts; to be left as a context manager.
        name: of the scene or room.
        start: where it begins, in words.
        scene: what is known of the room, for figures; None where nothing is.
    """

    robot: Robot
    name: str
    start: str
    scene: Scene | None


def robot_at(
    text: str, actions: ActionsIn, start: int | None = None, seed: int | None = None, config: str | None = None
) -> Place:
    """The robot that `--robot` names, at its start.

    Args:
        text: kind and name, see `KINDS`.
        actions: those of the agent in the scene or room of a name; a robot not bound to its own does these.
        start: number of a state; drawn if None.
        seed: of that draw.
        config: settings of a ros robot, a preset or a file.

    Raises:
        UserError: if there is no such robot, or it cannot be started.
    """
    kind, _, name = text.partition(":")
    if kind not in (*KINDS, "ros") or not name:
        raise UserError(
            f"'{text}' is no robot this version can drive; give scene:NAME or scene:FILE, room:NAME for a simulated "
            "TurtleBot in a rendered room, ros:ws://HOST:PORT for a robot behind rosbridge, or, for AI2-THOR, "
            "thor:FloorPlan1 or thor:FILE of a scene captured there"
        )
    if kind == "ros":
        return _behind_rosbridge(name, start, config)
    if config is not None:
        raise UserError(f"only a ros robot has settings; leave out --robot-config for {text}")
    return KINDS[kind](name, actions, start, seed)


def _in_scene(name: str, actions: ActionsIn, start: int | None, seed: int | None) -> Place:
    scene = open_scene(name)
    robot = RecordedRobot(scene, start, seed)
    return Place(robot, scene.name, f"state {robot.state}", scene)


def _in_room(name: str, actions: ActionsIn, start: int | None, seed: int | None) -> Place:
    """A simulated robot in a rendered room: near a pose of the lattice, or exactly on the one that is given."""
    from active_perceiver.simulation.simulated_robot import SimulatedRobot, lattice_start, open_room, random_start

    room = open_room(name, seed=seed or 0)
    pose = random_start(room, np.random.default_rng(seed)) if start is None else lattice_start(room, start)
    robot = SimulatedRobot(room, pose, actions=actions(room.name), seed=seed)
    scene = open_scene(room.name) if room.name in bundled_names() else None
    return Place(robot, room.name, _words(pose), scene)


def _words(pose: tuple[float, float, float, float]) -> str:
    x, z, heading, tilt = pose
    return f"x {x:.2f} m, z {z:.2f} m, heading {heading:.0f}, tilt {tilt:.0f}"


def _in_thor(name: str, actions: ActionsIn, start: int | None, seed: int | None) -> Place:
    """A room by name, as rooms are captured if nothing is said; or as a captured scene's file says."""
    captured = open_scene(name) if Path(name).suffix == ".h5" else None
    room, settings = (name, ThorConfig()) if captured is None else captured_config(captured)
    called = room if captured is None else captured.name
    controller = start_controller(room, settings)
    try:
        robot = ThorRobot(controller, settings, actions(called), start, seed)
    except BaseException:
        controller.stop()
        raise
    return Place(robot, called, _words(robot.pose()), captured)


def _behind_rosbridge(url: str, start: int | None, config: str | None) -> Place:
    if config is None:
        raise UserError(f"say what the robot is like: --robot-config FILE, or one of {', '.join(presets())}")
    if start is not None:
        raise UserError("a ros robot starts where it stands; leave out --start")
    robot = RosRobot(url, load_config(config))
    return Place(robot, url, f"{_words(robot.pose() or (0.0, 0.0, 0.0, 0.0))} of its odometry", None)


KINDS: dict[str, Callable[[str, ActionsIn, int | None, int | None], Place]] = {
    "scene": _in_scene,
    "room": _in_room,
    "thor": _in_thor,
}
