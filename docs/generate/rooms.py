"""What is bundled: scenes, their Gymnasium ids, kinds of things."""

from __future__ import annotations

from docs.generate.markdown import table
from docs.generate.package import OBJECTS, TARGETS_OF_RECORD, bundled_names, open_scene, scene_id, scene_path


def bundled() -> str:
    """The bundled scenes."""
    head = ("scene", "views", "places", "actions", "targets", "pictures of each", "MB", "targets of record")
    rows = []
    for name in bundled_names():
        scene = open_scene(name)
        target = scene.targets[0]
        rows.append(
            (
                name,
                str(len(scene)),
                str(len({*scene.positions.tolist()})),
                str(len(scene.actions)),
                str(len(scene.targets)),
                f"{target.trained} + {target.held_out} held out",
                f"{scene_path(name).stat().st_size / 1e6:.1f}",
                ", ".join(TARGETS_OF_RECORD[name]),
            )
        )
    return table(head, rows)


def gymnasium_ids() -> str:
    """The ids of all environments."""
    rows = [
        (f"`{scene_id(name)}`", name, str(len(open_scene(name).actions)), ", ".join(TARGETS_OF_RECORD[name]))
        for name in bundled_names()
    ]
    own = "`scene=`, a bundled name or your own file"
    rows.append(("`ActivePerceiver/Search-v0`", own, "the scene's", "all targets of the scene"))
    return table(("id", "scene", "actions", "searched for, if nothing is said"), rows)


def kinds() -> str:
    """The kinds of things that generated rooms hold."""
    names = [name.replace("_", " ") for name in sorted(OBJECTS)]
    return f"{len(names)} kinds: {', '.join(names)}."
