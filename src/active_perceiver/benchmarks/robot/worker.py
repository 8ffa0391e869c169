"""Searches of a simulated robot, done in processes each of which keeps a room and an agent."""

from __future__ import annotations

import math
from contextlib import nullcontext
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from active_perceiver.agent.perceiver import ActivePerceiver
from active_perceiver.benchmarks.config import RobotBenchmarkConfig
from active_perceiver.evaluation.stop_evaluation import TRUE_IOU
from active_perceiver.live import SearchConfig, search
from active_perceiver.recognition.metrics import box_iou
from active_perceiver.robots.pose2d import Pose2D, counted_from
from active_perceiver.scenes import Scene, decode_image, open_scene
from active_perceiver.scenes.angles import signed_angle
from active_perceiver.simulation.diff_drive import NO_NOISE, OdometryNoise
from active_perceiver.simulation.simulated_robot import (
    WEBCAM,
    LiveRoom,
    Pose,
    SimulatedRobot,
    nearest_pose,
    open_room,
    random_start,
)
from active_perceiver.utils.progress import quiet


@dataclass(frozen=True)
class Conditions:
    """How far from what the agent was trained on, and how it searches.

    Attributes:
        centimetres: beside a place of the lattice at the start, at most, along x and z.
        degrees: beside a heading at the start, at most.
        odometry_noise: whether the wheels slip.
        nudge: metres by which things are moved at most.
        own_hour: whether the light is that of the scene instead of the room's hour that was asked for.
        perfect: whether the camera makes no mistakes.
    """

    centimetres: float
    degrees: float
    odometry_noise: bool
    nudge: float
    own_hour: bool = False
    perfect: bool = False


@dataclass(eq=False)
class Lab:
    """Where and how a process searches; what it needs is opened by its first search.

    Attributes:
        folder: of the agent.
        room_name: a name for `open_room`; the agent was trained in its scene.
        conditions: of all searches.
        settings: of the benchmark: seed, limit of actions.
    """

    folder: Path
    room_name: str
    conditions: Conditions
    settings: RobotBenchmarkConfig

    @cached_property
    def agent(self) -> ActivePerceiver:
        """What searches."""
        return ActivePerceiver.from_pretrained(self.folder, 1)

    @cached_property
    def room(self) -> LiveRoom:
        """Where the robot is."""
        return open_room(
            self.room_name.partition("_hour_")[0] if self.conditions.own_hour else self.room_name,
            nudge=self.conditions.nudge,
            seed=self.settings.seed,
            faults=None if self.conditions.perfect else WEBCAM,
            progress=lambda label: nullcontext(quiet),
        )

    @cached_property
    def scene(self) -> Scene:
        """What the agent was trained in."""
        return open_scene(self.room.name)


def search_once(lab: Lab, number: int) -> dict[str, Any]:
    """Search for one of an agent's targets, all by turns, from a start that follows from the search's number.

    Returns:
        "target", "found" (its word), "true" (its box is on the target), "actions", "metres_off" and "degrees_off"
        (from where a robot that does not slip would be, had it begun on the lattice), "collisions".

    Raises:
        UserError: if there is no such room, or no start that the conditions ask for.
    """
    agent, room, conditions, settings = lab.agent, lab.room, lab.conditions, lab.settings
    rng = np.random.default_rng([settings.seed, number])
    names = targets_in(agent, room.name)
    name = names[number % len(names)]
    target = lab.scene.targets[lab.scene.target_index(name)]
    picture = decode_image(target.pictures[rng.integers(target.trained)])
    start = random_start(room, rng, conditions.centimetres, conditions.degrees)
    odometry_noise = OdometryNoise() if conditions.odometry_noise else NO_NOISE
    robot = SimulatedRobot(
        room, start, actions=agent.config.actions(room.name), odometry_noise=odometry_noise, seed=number
    )
    config = SearchConfig(scene=room.name, max_steps=settings.max_steps, max_minutes=float("inf"), seed=number)
    record = search(agent, robot, picture, config)
    end = robot.pose()
    boxes = room.look(end, [name])[1]
    drawn = record.step_records[-1].step.detection
    overlap = 0.0 if drawn is None else float(np.nan_to_num(box_iou(drawn.box[None], boxes))[0])
    metres, degrees = _astray(nearest_pose(room, start), robot)
    return {
        "target": name,
        "found": record.found,
        "true": record.found and overlap >= TRUE_IOU,
        "actions": record.actions,
        "metres_off": metres,
        "degrees_off": degrees,
        "collisions": robot.body.collisions,
    }


def targets_in(agent: ActivePerceiver, scene: str) -> list[str]:
    """The targets that an agent knows in one of its scenes, by name, in its order."""
    return [target.name for target in agent.config.targets if target.scene == scene]


def _astray(lattice: Pose, robot: SimulatedRobot) -> tuple[float, float]:
    """How far, in metres and degrees, a robot is from where its actions would have led on the lattice."""
    planned = robot.driver.plan or Pose2D(0.0, 0.0, 0.0)
    x, z, heading, _ = lattice
    meant = counted_from(Pose2D(x, z, heading), planned.x, planned.z, planned.heading)
    body = robot.body
    return math.hypot(body.x - meant.x, body.z - meant.z), abs(signed_angle(body.heading - meant.heading))
