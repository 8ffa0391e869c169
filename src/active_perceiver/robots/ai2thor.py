"""AI2-THOR, a simulator of furnished rooms (https://ai2thor.allenai.org), as a robot; extra `thor`, client 5.0.

What is read here of an event: `frame` (H, W, 3) RGB; `metadata["agent"]` with `position`, `rotation.y` (degrees
clockwise from above, 0 along +z, as ours) and `cameraHorizon` (degrees, down positive: ours with the other sign);
`metadata["lastActionSuccess"]`; see https://ai2thor.allenai.org/ithor/documentation/environment-state/.

This part was tested with the client's own events, not with the simulator itself: see docs/ai2thor.md.
"""

from __future__ import annotations

import math
import os
import re
import sys
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from active_perceiver.errors import UserError
from active_perceiver.robots.robot import StopOnExit, check_action
from active_perceiver.scenes import EIGHT_ACTIONS, Action, Scene
from active_perceiver.scenes.angles import signed_angle
from active_perceiver.scenes.lattice import LOOK, MOVE_DIRECTION, TURN, lattice_poses

# How far from where it was asked to be an agent may stand. Teleport says that it succeeded even if the agent was
# moved aside, or did not move: https://github.com/allenai/ai2thor/issues/956 and 1297.
METRES_OFF, DEGREES_OFF = 0.02, 1.0
# What the simulator's agent can do with its head.
LOWEST_TILT, HIGHEST_TILT = -60.0, 30.0
# A few reachable positions cannot be teleported to: https://github.com/allenai/ai2thor/issues/746.
START_ATTEMPTS = 50

ThorPose = tuple[float, float, float, float]


class ThorError(UserError, RuntimeError):
    """AI2-THOR is missing, could not be started or did not do what was asked; the message says what to do."""


class Controller(Protocol):
    """What is used of `ai2thor.controller.Controller`."""

    @property
    def last_event(self) -> Any:
        """What the last action led to, an `ai2thor.server.Event`."""
        ...

    def step(self, action: str, **arguments: Any) -> Any:
        """Carry out an action and return its event."""
        ...

    def stop(self) -> None:
        """End the simulator."""
        ...


@dataclass(frozen=True)
class ThorConfig:
    """How a room of AI2-THOR is cut into states, and its camera.

    Attributes:
        grid: metres between neighbouring places, and moved by one action.
        turn: degrees turned by one action, 90 or 45. At 45 degrees a move leads one cell on along both axes.
        tilts: degrees, evenly spaced, up positive; -60 to 30 is what the agent can do.
        image_size: side of the square views in pixels.
        fov: field of view in degrees.
    """

    grid: float = 0.25
    turn: float = 90.0
    tilts: tuple[float, ...] = (-30.0, 0.0, 30.0)
    image_size: int = 300
    fov: float = 75.0

    def __post_init__(self) -> None:
        steps = np.round(np.diff(self.tilts), 6)
        rules = {
            "grid must be in 0.05..2 metres": 0.05 <= self.grid <= 2,
            "turn must be 90 or 45 degrees": self.turn in (45.0, 90.0),
            "tilts must rise evenly, each in -60..30 degrees": len(self.tilts) > 0
            and all(LOWEST_TILT <= tilt <= HIGHEST_TILT for tilt in self.tilts)
            and len(np.unique(steps)) < 2
            and (steps > 0).all(),
            "image_size must be in 16..4096 pixels": 16 <= self.image_size <= 4096,
            "fov must be in 10..150 degrees": 10 <= self.fov <= 150,
        }
        for rule, kept in rules.items():
            if not kept:
                raise ThorError(f"{rule}, got {getattr(self, rule.split()[0])}")

    @property
    def headings(self) -> tuple[float, ...]:
        """All headings in degrees, from 0 on."""
        return tuple(float(heading) for heading in np.arange(0, 360, self.turn))


def captured_source(room: str, settings: ThorConfig, client: str) -> str:
    """What a captured scene says of where it comes from; `captured_config` reads it.

    Args:
        room: AI2-THOR's name of it.
        settings: how it was captured.
        client: version of AI2-THOR's client.
    """
    return f"AI2-THOR {room}, grid {settings.grid:g} m, client {client}"


def captured_config(scene: Scene) -> tuple[str, ThorConfig]:
    """The room that a scene was captured in, and how.

    Raises:
        ThorError: if the scene does not come from AI2-THOR.
    """
    found = re.match(r"AI2-THOR (\w+), grid ([\d.e-]+) m,", scene.source)
    if not found:
        raise ThorError(f"scene '{scene.name}' was not captured in AI2-THOR; search in it as --robot scene:FILE")
    headings = np.unique(scene.poses[:, 2])
    return found[1], ThorConfig(
        grid=float(found[2]),
        turn=90.0 if len(headings) <= 4 else 45.0,
        tilts=tuple(np.unique(scene.poses[:, 3]).tolist()),
        image_size=scene.image_size,
        fov=scene.fov,
    )


def start_controller(scene: str, settings: ThorConfig) -> Controller:
    """Start the simulator in one of its rooms.

    Args:
        scene: such as "FloorPlan1".
        settings: grid, turns and camera follow from it.

    Raises:
        ThorError: if the client is not installed or the simulator does not start.
    """
    try:
        from ai2thor.controller import Controller as Client
        from ai2thor.platform import CloudRendering
    except ImportError as error:
        raise ThorError(
            f"AI2-THOR's client cannot be imported ({error}); install it: pip install 'active-perceiver[thor]'"
        ) from None
    # Without a display the simulator draws through Vulkan.
    headless = sys.platform == "linux" and not os.environ.get("DISPLAY")
    try:
        controller: Controller = Client(
            scene=scene,
            gridSize=settings.grid,
            rotateStepDegrees=settings.turn,
            snapToGrid=settings.turn == 90,  # which would undo moves at 45 degrees
            renderInstanceSegmentation=True,
            width=settings.image_size,
            height=settings.image_size,
            fieldOfView=settings.fov,
            **({"platform": CloudRendering} if headless else {}),
        )
    except Exception as error:  # the client raises whatever its parts do, bare Exceptions among it
        raise ThorError(
            f"AI2-THOR could not be started in {scene} ({_first_line(error)}); check the name of the room and, at "
            "the first start, that the simulator can be downloaded (without internet the client speaks of an invalid "
            "commit_id); without a display it needs Vulkan: sudo apt-get install libvulkan1 vulkan-tools"
        ) from None
    return controller


def thor_step(controller: Controller, action: str, **arguments: Any) -> Any:
    """Carry out an action and return its event, whether it succeeded or not.

    Raises:
        ThorError: if the simulator crashed, did not answer or does not know the action.
    """
    try:
        return controller.step(action=action, **arguments)
    except Exception as error:  # as above
        raise ThorError(
            f"AI2-THOR failed at {action} ({_first_line(error)}); start the command again, a capture with --resume"
        ) from None


def _first_line(error: Exception) -> str:
    return (str(error).strip().splitlines() or [type(error).__name__])[0]


def succeeded(event: Any) -> bool:
    """Whether an event's action was carried out."""
    return bool(event.metadata["lastActionSuccess"])


def event_image(event: Any) -> NDArray[np.uint8]:
    """What the camera saw, (H, W, 3) uint8 RGB.

    Raises:
        ThorError: if the event has no such image.
    """
    frame = event.frame
    if not isinstance(frame, np.ndarray) or frame.dtype != np.uint8 or frame.shape[2:] != (3,):
        raise ThorError("AI2-THOR sent no image; start it with renderImage left on")
    # The client's frame is a view that runs from the bottom upwards.
    return np.ascontiguousarray(frame)


def event_pose(event: Any) -> ThorPose:
    """Where the agent stands and looks: x, z in metres, heading in 0..360 and tilt in degrees, up positive."""
    agent = event.metadata["agent"]
    horizon = signed_angle(float(agent["cameraHorizon"]))
    heading = round(float(agent["rotation"]["y"]), 3) % 360
    return float(agent["position"]["x"]), float(agent["position"]["z"]), heading, round(-horizon, 3) + 0.0


def reachable_positions(controller: Controller) -> NDArray[np.float64]:
    """Where the agent can stand: (P, 3) x, y, z in metres, sorted by x, then z. They follow from where it stands now.

    Raises:
        ThorError: if there are none.
    """
    event = thor_step(controller, "GetReachablePositions")
    found = event.metadata["actionReturn"] if succeeded(event) else None
    if not found:
        reason = event.metadata.get("errorMessage") or "it lists none"
        raise ThorError(f"AI2-THOR says of no position that it can be reached ({reason}); try another scene or grid")
    positions = np.array([[place["x"], place["y"], place["z"]] for place in found], np.float64)
    rounded = np.round(positions, 3)
    # Some rooms list a position twice.
    _, first = np.unique(rounded[:, [0, 2]], axis=0, return_index=True)
    return rounded[first]


def teleport(controller: Controller, pose: ThorPose, height: float) -> Any | None:
    """Put the agent somewhere: the event, or None if it is not there afterwards.

    Args:
        controller: of the simulator.
        pose: x, z, heading, tilt.
        height: the y of the reachable position.

    Raises:
        ThorError: if the simulator crashed.
    """
    x, z, heading, tilt = (float(value) for value in pose)
    event = thor_step(
        controller, "Teleport", position={"x": x, "y": height, "z": z}, rotation={"x": 0.0, "y": heading, "z": 0.0},
        horizon=-tilt, standing=True,
    )  # fmt: skip
    if not succeeded(event):
        return None
    there = event_pose(event)
    turned = abs(signed_angle(there[2] - heading))
    is_there = math.hypot(there[0] - x, there[1] - z) <= METRES_OFF
    return event if is_there and turned <= DEGREES_OFF and abs(there[3] - tilt) <= DEGREES_OFF else None


class ThorRobot(StopOnExit):
    """The agent of an AI2-THOR room; leaving it as a context manager ends the simulator.

    Args:
        controller: of the simulator, see `start_controller`.
        settings: those that it was started with, and those of the scene that the policy was trained in.
        actions: what it may do, in the order of the policy's outputs.
        start: number of a pose of the lattice over the reachable positions; a state, in a scene captured whole.
        seed: of the choice of a start, if none is given.

    Raises:
        ThorError: if the agent cannot be put there.
    """

    def __init__(
        self,
        controller: Controller,
        settings: ThorConfig | None = None,
        actions: tuple[Action, ...] = EIGHT_ACTIONS,
        start: int | None = None,
        seed: int | None = None,
    ) -> None:
        self.controller = controller
        self.settings = settings or ThorConfig()
        self._actions = actions
        positions = reachable_positions(controller)
        poses = lattice_poses(positions[:, [0, 2]], self.settings.headings, self.settings.tilts)
        if start is not None and not 0 <= start < len(poses):
            raise ThorError(f"this room has starts 0 to {len(poses) - 1}; there is no start {start}")
        drawn = np.random.default_rng(seed).permutation(len(poses))[:START_ATTEMPTS].tolist()
        for number in drawn if start is None else [start]:
            x, z, heading, tilt = poses[number].tolist()
            height = float(positions[number * len(positions) // len(poses), 1])
            event = teleport(controller, (x, z, heading, tilt), height)
            if event is not None:
                self._event = event
                return
        raise ThorError("AI2-THOR's agent could not be put at a start; give another --start or another seed")

    @property
    def actions(self) -> tuple[Action, ...]:
        """What it may do."""
        return self._actions

    def look(self) -> NDArray[np.uint8]:
        """The current view, (H, W, 3) uint8 RGB.

        Raises:
            ThorError: if the simulator sent none.
        """
        return event_image(self._event)

    def pose(self) -> ThorPose:
        """Where it stands and looks."""
        return event_pose(self._event)

    def execute(self, action: Action) -> bool:
        """Carry out one action. What the simulator refuses, and a look beyond the outermost tilt, changes nothing.

        Returns:
            Whether the simulator carried it out.

        Raises:
            ThorError: if the robot may not do this, or the simulator crashed.
        """
        check_action(action, self._actions, ThorError)
        _, _, heading, tilt = self.pose()
        if action in MOVE_DIRECTION:
            diagonal = round(heading / 45) % 2 == 1
            arguments = {"moveMagnitude": self.settings.grid * (math.sqrt(2) if diagonal else 1.0)}
        elif action in TURN:
            arguments = {"degrees": self.settings.turn}
        else:
            tilts = np.array(self.settings.tilts)
            beyond = tilts[(tilts - tilt) * LOOK[action] > DEGREES_OFF]
            if not len(beyond):
                return False
            arguments = {"degrees": float(np.abs(beyond - tilt).min())}
        self._event = thor_step(self.controller, action.value, **arguments)
        return succeeded(self._event)

    def stop(self) -> None:
        """Nothing moves between two actions."""

    def close(self) -> None:
        """End the simulator."""
        self.controller.stop()
