"""Files in exactly the layouts of other projects, written from a toy scene."""

from __future__ import annotations

import json
from pathlib import Path

import h5py
import networkx
import numpy as np
from PIL import Image
from scipy.io import savemat

from active_perceiver.scenes import Action, Scene
from active_perceiver.scenes.lattice import lattice_transitions, steps_to_goal
from helpers.toy import STEP, toy_scene

ZHU_ORDER = (Action.MOVE_AHEAD, Action.ROTATE_RIGHT, Action.ROTATE_LEFT, Action.MOVE_BACK)
AVD_ACTIONS = {
    "forward": Action.MOVE_AHEAD, "backward": Action.MOVE_BACK, "left": Action.MOVE_LEFT, "right": Action.MOVE_RIGHT,
    "rotate_ccw": Action.ROTATE_LEFT, "rotate_cw": Action.ROTATE_RIGHT,
}  # fmt: skip
SAVN_ACTIONS = (Action.MOVE_AHEAD, Action.ROTATE_LEFT, Action.ROTATE_RIGHT, Action.LOOK_UP, Action.LOOK_DOWN)


def wide(view: np.ndarray, width: int, height: int) -> np.ndarray:
    """A view as a picture of other proportions, grey at either side of a square in the middle."""
    picture = np.full((height, width, 3), 128, np.uint8)
    left = (width - height) // 2
    picture[:, left : left + height] = np.asarray(Image.fromarray(view).resize((height, height)))
    return picture


def zhu_scene(**kwargs) -> Scene:
    """What a dump holds: four headings, no tilt, four actions."""
    return toy_scene(**{"side": 3, "image_size": 24, "tilts": (0.0,), "actions": ZHU_ORDER, **kwargs})


def write_zhu(path: Path, scene: Scene, crops: int = 10) -> None:
    """One `.h5`, with actions in the order of the format."""
    here = np.arange(len(scene))
    graph = np.stack([scene.transitions[:, scene.actions.index(action)] for action in ZHU_ORDER], axis=1)
    distance = np.stack([steps_to_goal(scene.transitions, here == goal) for goal in here], axis=1)
    with h5py.File(path, "w") as file:
        file["observation"] = np.stack([wide(scene.view(state), 400, 300) for state in here])
        file["resnet_feature"] = np.zeros((len(scene), crops, 2048), np.float32)
        file["location"] = scene.poses[:, :2].astype(float)
        file["rotation"] = scene.poses[:, 2].astype(int)
        file["graph"] = np.where(graph == here[:, None], -1, graph).astype(int)
        file["shortest_path_distance"] = distance


def diagonal_transitions(poses: np.ndarray, actions: tuple[Action, ...], step: float) -> np.ndarray:
    """As `lattice_transitions`, but a move at 45 degrees goes one cell along both axes, as in SAVN's data."""
    transitions = lattice_transitions(poses, actions, step)
    slanted = poses[:, 2] % 90 != 0
    state_of = {tuple(np.round(pose, 2).tolist()): state for state, pose in enumerate(poses)}
    for state in np.flatnonzero(slanted):
        angle = np.radians(poses[state, 2])
        moved = poses[state].copy()
        moved[:2] += step * np.sign([np.sin(angle), np.cos(angle)])
        ahead = state_of.get(tuple(np.round(moved, 2).tolist()), state)
        transitions[state, actions.index(Action.MOVE_AHEAD)] = ahead
    return transitions


def savn_scene(headings: tuple[float, ...] = tuple(range(0, 360, 45)), **kwargs) -> Scene:
    """What a folder holds: eight headings, tilts 0 and -30, five actions, diagonal moves."""
    from dataclasses import replace

    scene = toy_scene(
        **{
            "side": 3,
            "image_size": 64,
            "tilts": (-30.0, 0.0),
            "actions": SAVN_ACTIONS,
            "headings": headings,
            **kwargs,
        }
    )
    return replace(scene, transitions=diagonal_transitions(scene.poses, scene.actions, STEP))


def savn_node(pose: np.ndarray) -> str:
    """ "x|z|rotation|horizon", horizon down positive, as `ThorAgentState` writes it."""
    x, z, heading, tilt = pose.tolist()
    return f"{x:0.2f}|{z:0.2f}|{round(heading)}|{round(-tilt)}"


def savn_object(scene: Scene, target: int) -> str:
    """An object's id."""
    return f"{scene.target_names[target].title()}|+{0.1 * target:05.2f}|+00.90|-00.50"


def write_savn(folder: Path, scene: Scene, key: str = "links", boxes: bool = False) -> None:
    """`grid.json`, `graph.json`, `images.hdf5`, `visible_object_map.json` and, with boxes, `metadata.json`."""
    folder.mkdir(parents=True)
    nodes = [savn_node(pose) for pose in scene.poses]
    graph = networkx.DiGraph()
    graph.add_nodes_from(nodes)
    for state, row in enumerate(scene.transitions):
        graph.add_edges_from((nodes[state], nodes[after]) for after in row if after != state)
    (folder / "graph.json").write_text(json.dumps(networkx.node_link_data(graph, edges=key)))
    places = np.unique(scene.poses[:, :2], axis=0).tolist()
    (folder / "grid.json").write_text(json.dumps([{"x": x, "y": 0.9, "z": z} for x, z in places]))
    with h5py.File(folder / "images.hdf5", "w") as file:
        for state, node in enumerate(nodes):
            file.create_dataset(node, data=scene.view(state))
    visible = {
        savn_object(scene, target): [nodes[state] for state in np.flatnonzero(scene.areas[:, target] > 0)]
        for target in range(len(scene.targets))
    }
    (folder / "visible_object_map.json").write_text(json.dumps(visible))
    if boxes:
        (folder / "metadata.json").write_text(json.dumps(_metadata(scene, nodes)))


def _metadata(scene: Scene, nodes: list[str]) -> dict:
    size = scene.image_size
    content = {}
    for state, node in enumerate(nodes):
        found = {}
        for target in np.flatnonzero(scene.areas[state] > 0).tolist():
            x, y, width, height = (scene.boxes[state, target] * size).tolist()
            corners = [x - width / 2, y - height / 2, x + width / 2, y + height / 2]
            found[savn_object(scene, target)] = [round(value) for value in corners]
        objects = [
            {"objectId": savn_object(scene, target), "visible": savn_object(scene, target) in found}
            for target in range(len(scene.targets))
        ]
        content[node] = {"objects": objects, "instance_detections2D": found}
    return content


def avd_scene(**kwargs) -> Scene:
    """What a folder holds: twelve headings, no tilt, six actions."""
    wanted = {
        "side": 3, "image_size": 96, "tilts": (0.0,), "actions": tuple(AVD_ACTIONS.values()),
        "headings": tuple(range(0, 360, 30)), **kwargs,
    }  # fmt: skip
    return toy_scene(**wanted)


def avd_name(state: int) -> str:
    """Scene type, number and scan, number of the image, camera: fifteen digits."""
    return f"00011{state + 1:06}0101.jpg"


def avd_records(scene: Scene, scale: float = 250.0) -> list[dict]:
    """The records of `image_structs`, of views that were all reconstructed."""
    records = []
    for state, (x, z, heading, _) in enumerate(scene.poses.astype(float)):
        angle = np.radians(heading)
        direction = np.array([[np.sin(angle)], [0.0], [np.cos(angle)]])
        right = np.array([np.cos(angle), 0.0, -np.sin(angle)])
        place = np.array([[x], [1.2], [z]]) * 1000.0 / scale
        turn = np.stack([right, [0.0, 1.0, 0.0], direction[:, 0]])
        records.append(
            {
                "image_name": avd_name(state), "t": -turn @ place, "R": turn, "world_pos": place,
                "direction": direction, "quat": np.zeros((4, 1)), "scaled_world_pos": place * scale,
                "image_id": str(state), "camera_id": "1", "cluster_id": float(state // 12), "rotate_cw": -1.0,
                "rotate_ccw": -1.0, "translate_forward": -1.0, "translate_backward": -1.0,
            }
        )  # fmt: skip
    return records


def write_records(path: Path, records: list[dict], scale: float = 250.0) -> None:
    """`image_structs.mat`: a 1 x N struct array and the scale."""
    kinds = [(key, object) for key in records[0]]
    structs = np.empty((1, len(records)), kinds)
    for column, record in enumerate(records):
        structs[0, column] = tuple(record.values())
    savemat(path, {"image_structs": structs, "scale": scale})


def avd_annotations(scene: Scene, width: int, height: int) -> dict:
    """The content of `annotations.json`, instances numbered from 1."""
    content = {}
    for state in range(len(scene)):
        boxes = []
        for target in np.flatnonzero(scene.areas[state] > 0).tolist():
            x, y, across, high = (scene.boxes[state, target] * height).tolist()
            left = x - across / 2 + (width - height) / 2
            top = y - high / 2
            boxes.append([*(round(v) for v in (left, top, left + across, top + high)), target + 1, 1])
        entry: dict = {"bounding_boxes": boxes}
        for key, action in AVD_ACTIONS.items():
            after = int(scene.transitions[state, scene.actions.index(action)])
            entry[key] = "" if after == state else avd_name(after)
        content[avd_name(state)] = entry
    return content


def write_avd(folder: Path, scene: Scene, width: int = 320, height: int = 180) -> None:
    """`jpg_rgb/`, `annotations.json`, `image_structs.mat`, and beside the folder `instance_id_map.txt`."""
    (folder / "jpg_rgb").mkdir(parents=True)
    for state in range(len(scene)):
        picture = Image.fromarray(wide(scene.view(state), width, height))
        picture.save(folder / "jpg_rgb" / avd_name(state), quality=95)
    (folder / "annotations.json").write_text(json.dumps(avd_annotations(scene, width, height)))
    write_records(folder / "image_structs.mat", avd_records(scene))
    lines = [f"{name} {number}" for number, name in enumerate(scene.target_names, 1)]
    (folder.parent / "instance_id_map.txt").write_text("\n".join(lines) + "\n")
