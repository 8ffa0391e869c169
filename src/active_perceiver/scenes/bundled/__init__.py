"""The scenes shipped with the software, and opening a scene by name or path."""

from __future__ import annotations

from pathlib import Path

from active_perceiver.scenes.scene import Scene, SceneError
from active_perceiver.scenes.storage import load_scene

FOLDER = Path(__file__).parent

# Four objects in each room, as in the paper's tables; sixteen different ones in the four rooms of the simulation.
# What else is annotated can be searched for as well.
TARGETS_OF_RECORD: dict[str, tuple[str, ...]] = {
    "kitchen_1": ("mug", "plate", "bread", "apple"),
    "kitchen_2": ("bowl", "kettle", "toaster", "banana"),
    "living_room_1": ("remote_control", "laptop", "lamp", "cushion"),
    "living_room_2": ("book", "vase", "clock", "bag"),
    "conference_room": ("scissors", "stapler", "mug", "bag"),
}


def bundled_names() -> list[str]:
    """Names of the shipped scenes."""
    return sorted(path.stem for path in FOLDER.glob("*.h5"))


def scene_path(name_or_path: str | Path) -> Path:
    """The file of a bundled scene by name, or of any scene by path.

    Raises:
        SceneError: if it is neither; the message lists the bundled names.
    """
    if str(name_or_path) in bundled_names():
        return FOLDER / f"{name_or_path}.h5"
    path = Path(name_or_path)
    if path.is_file():
        return path
    known = ", ".join(bundled_names()) or "none"
    raise SceneError(f"'{name_or_path}' is neither a bundled scene ({known}) nor a scene file")


def open_scene(name_or_path: str | Path) -> Scene:
    """Load a bundled scene by name, or any scene file by path (see `load_scene` for what may be raised)."""
    return load_scene(scene_path(name_or_path))
