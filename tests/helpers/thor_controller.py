"""A stand-in for AI2-THOR's simulator that walks a Scene, and answers as the simulator does.

Its events are the client's own (`ai2thor.server.Event`, made by the client's `create_event` from the bytes that Unity
would send) if the client is installed, else `PlainEvent`s that have what is read of them. The metadata are laid out
as in https://ai2thor.allenai.org/ithor/documentation/environment-state/.
"""

from __future__ import annotations

import math

import numpy as np

from active_perceiver.scenes import Scene
from helpers.toy import COLOURS

HEIGHT = 0.900999
BACKGROUND = (7, 7, 7)

try:
    import ai2thor.server
except ImportError:
    ai2thor = None


class PlainEvent:
    """What is read of the client's Event, without the client."""

    def __init__(self, metadata, image, ids):
        self.metadata = metadata
        size = metadata["screenHeight"], metadata["screenWidth"]
        self.frame = np.flip(np.frombuffer(image, np.uint8).reshape(*size, 3), axis=0)
        colours = np.flip(np.frombuffer(ids, np.uint8).reshape(*size, 4), axis=0)[..., :3]
        self.instance_masks = {}
        self.instance_detections2D = {}
        for entry in metadata["colors"]:
            mask = (colours == entry["color"]).all(-1)
            if "|" in entry["name"] and mask.any():
                rows, columns = np.flatnonzero(mask.any(1)), np.flatnonzero(mask.any(0))
                self.instance_masks[entry["name"]] = mask
                self.instance_detections2D[entry["name"]] = (
                    int(columns[0]), int(rows[0]), int(columns[-1]), int(rows[-1]),
                )  # fmt: skip


def client_event(metadata, image, ids):
    """An event as the client makes it from what Unity sends."""

    class Receiver(ai2thor.server.Server):
        def start(self):
            raise NotImplementedError

        stop = send = receive = start

    server = Receiver(metadata["screenWidth"], metadata["screenHeight"], None)
    sent = {"agents": [metadata], "activeAgentId": 0, "sequenceId": 0}
    return server.create_event(sent, {"image": [image], "image_ids": [ids]})


def toy_masks(scene: Scene, state: int):
    """The pixels of each ball of a toy scene: their colours occur nowhere else."""
    view = scene.view(state)
    return [(view == COLOURS[row]).all(-1) for row in range(len(scene.targets))]


def box_masks(scene: Scene, state: int):
    """The boxes of a scene as if its objects were flat and square."""
    masks = []
    for box in scene.boxes[state]:
        mask = np.zeros((scene.image_size,) * 2, bool)
        if not np.isnan(box).any():
            low = np.round((box[:2] - box[2:] / 2) * scene.image_size).astype(int)
            high = np.round((box[:2] + box[2:] / 2) * scene.image_size).astype(int)
            mask[low[1] : high[1], low[0] : high[0]] = True
        masks.append(mask)
    return masks


class StandIn:
    """A controller of a scene.

    Args:
        scene: its places are the reachable positions, and its transitions what a move leads to.
        types: AI2-THOR's type of each of the scene's targets.
        blocked: states at which the agent cannot be: Teleport fails.
        ignored: states to which Teleport says that it succeeded, and leaves the agent where it is (issue 1297).
        masks: the pixels of each target in a state.
        fails_after: that many steps, after which the simulator has crashed.
        make_event: of metadata and the bytes that Unity would send.
    """

    def __init__(self, scene, types, *, blocked=(), ignored=(), masks=toy_masks, fails_after=10**9, make_event=None):
        self.scene = scene
        self.blocked, self.ignored = set(blocked), set(ignored)
        self.masks = masks
        self.fails_after = fails_after
        self.make_event = make_event or (client_event if ai2thor else PlainEvent)
        self.ids = [f"{kind}|-0{row}.50|+00.90|+01.{row:02}" for row, kind in enumerate(types)]
        self.types = types
        self.state = 0
        self.steps = []
        self.stopped = 0
        self.last_event = self._event("Initialize", True, None)

    def stop(self):
        self.stopped += 1

    def step(self, action, **arguments):
        if len(self.steps) >= self.fails_after:
            raise TimeoutError(f"Error encountered when running action {action} in scene FloorPlan1.")
        self.steps.append((action, arguments))
        success, returned = getattr(self, f"_{action}")(**arguments)
        self.last_event = self._event(action, success, returned)
        return self.last_event

    def _GetReachablePositions(self):
        places = np.unique(self.scene.poses[:, :2], axis=0)
        order = np.random.default_rng(0).permutation(len(places))
        # As single-precision numbers come through JSON, in no order, and one of them twice.
        listed = [{"x": float(x) + 1e-7, "y": HEIGHT, "z": float(z)} for x, z in places[order]]
        return True, [*listed, listed[0]]

    def _Teleport(self, position, rotation, horizon, standing):
        assert standing
        assert abs(position["y"] - HEIGHT) < 0.001
        wanted = np.array([position["x"], position["z"], rotation["y"] % 360, -horizon])
        off = np.abs(self.scene.poses - wanted)
        off[:, 2] = np.minimum(off[:, 2], 360 - off[:, 2])
        near = np.flatnonzero((off < [0.01, 0.01, 0.1, 0.1]).all(1))
        if not len(near) or int(near[0]) in self.blocked:
            return False, None
        if int(near[0]) not in self.ignored:
            self.state = int(near[0])
        return True, None

    def _move(self, name):
        column = [action.value for action in self.scene.actions].index(name)
        moved = int(self.scene.transitions[self.state, column])
        if moved == self.state:
            return False, None
        self.state = moved
        return True, None

    def _MoveAhead(self, moveMagnitude):
        places = np.unique(self.scene.poses[:, 0])
        diagonal = self.scene.poses[self.state, 2] % 90 != 0
        assert math.isclose(moveMagnitude, (places[1] - places[0]) * (2**0.5 if diagonal else 1), rel_tol=1e-5)
        return self._move("MoveAhead")

    def _MoveBack(self, moveMagnitude):
        return self._move("MoveBack")

    def _MoveLeft(self, moveMagnitude):
        return self._move("MoveLeft")

    def _MoveRight(self, moveMagnitude):
        return self._move("MoveRight")

    def _RotateLeft(self, degrees):
        return self._move("RotateLeft")

    def _RotateRight(self, degrees):
        return self._move("RotateRight")

    def _LookUp(self, degrees):
        return self._move("LookUp")

    def _LookDown(self, degrees):
        return self._move("LookDown")

    def _event(self, action, success, returned):
        x, z, heading, tilt = (float(value) for value in self.scene.poses[self.state])
        size = self.scene.image_size
        colours = [(10 + 40 * row, 200, 30) for row in range(len(self.ids))]
        ids = np.full((size, size, 4), 255, np.uint8)
        ids[..., :3] = BACKGROUND
        masks = self.masks(self.scene, self.state)
        for mask, colour in zip(masks, colours, strict=True):
            ids[mask, :3] = colour
        metadata = {
            "agentId": 0,
            "agent": {
                "name": "agent",
                "position": {"x": x, "y": HEIGHT, "z": z},
                # As Unity's quaternions come back.
                "rotation": {"x": -0.0, "y": heading or 359.99997, "z": 0.0},
                "cameraHorizon": -tilt + 1e-5,
                "isStanding": True,
                "inHighFrictionArea": False,
            },
            "objects": [
                {
                    "name": f"{kind}_{row}", "objectId": name, "objectType": kind, "visible": False,
                    "pickupable": kind != "Fridge", "distance": 3.0,
                    "position": {"x": 0.0, "y": 0.9, "z": 0.0}, "rotation": {"x": 0.0, "y": 0.0, "z": 0.0},
                }
                for row, (kind, name) in enumerate(zip(self.types, self.ids, strict=True))
            ],
            "colors": [
                *({"name": name, "color": list(colour)} for name, colour in zip(self.ids, colours, strict=True)),
                {"name": "Floor", "color": list(BACKGROUND)},
            ],
            "lastAction": action,
            "lastActionSuccess": success,
            "errorMessage": "" if success else "Collided",
            "errorCode": "",
            "actionReturn": returned,
            "screenWidth": size,
            "screenHeight": size,
            "sceneName": "FloorPlan1_physics",
            "thirdPartyCameras": [],
            "sequenceId": 0,
        }  # fmt: skip
        # Unity sends images from the bottom upwards.
        image = np.flip(self.scene.view(self.state), axis=0).tobytes()
        return self.make_event(metadata, image, np.flip(ids, axis=0).tobytes())
