"""Scenes: finite sets of views on a pose lattice, their files, and graph questions about them."""

from active_perceiver.scenes.bundled import bundled_names, open_scene
from active_perceiver.scenes.floor_plan import FloorPlan
from active_perceiver.scenes.image_files import ImageError
from active_perceiver.scenes.images import decode_image, read_image
from active_perceiver.scenes.lattice import EIGHT_ACTIONS, TURTLEBOT_ACTIONS, Action
from active_perceiver.scenes.scene import Scene, SceneError, Target
from active_perceiver.scenes.storage import load_scene, save_scene

__all__ = [
    "EIGHT_ACTIONS",
    "TURTLEBOT_ACTIONS",
    "Action",
    "FloorPlan",
    "ImageError",
    "Scene",
    "SceneError",
    "Target",
    "bundled_names",
    "decode_image",
    "load_scene",
    "open_scene",
    "read_image",
    "save_scene",
]
