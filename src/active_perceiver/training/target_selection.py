"""Which of a scene's targets are searched for."""

from __future__ import annotations

from collections.abc import Sequence

from active_perceiver.errors import UserError
from active_perceiver.scenes import Scene
from active_perceiver.scenes.bundled import TARGETS_OF_RECORD

OF_RECORD = "record"


def searched_targets(scene: Scene, wanted: Sequence[str]) -> tuple[str, ...]:
    """Names of a scene's targets that are searched for.

    Args:
        scene: where.
        wanted: names of targets, each perhaps with its scene in front ("kitchen_1/mug"); "record" stands for the
            bundled scene's targets of record; nothing for all targets that are visible anywhere.

    Returns:
        In the order they are asked for; none if the scene has none of them.
    """
    if not wanted:
        return tuple(name for index, name in enumerate(scene.target_names) if scene.areas[:, index].any())
    named: list[str] = []
    for name in wanted:
        where, _, target = name.rpartition("/")
        if name == OF_RECORD:
            named += TARGETS_OF_RECORD.get(scene.name, ())
        elif target in scene.target_names and where in ("", scene.name):
            named.append(target)
    return tuple(dict.fromkeys(named))


def check_targets(scenes: Sequence[Scene], wanted: Sequence[str]) -> None:
    """Make sure that every name is a target of some scene, and that something is searched for in every scene.

    Raises:
        UserError: if not; the message says what there is.
    """
    for scene in scenes:
        scene.require_targets()
    for name in wanted:
        if not any(searched_targets(scene, [name]) for scene in scenes):
            if name == OF_RECORD:
                raise UserError(f"only bundled scenes have targets of record ({', '.join(TARGETS_OF_RECORD)})")
            known = ", ".join(sorted({known for scene in scenes for known in scene.target_names}))
            raise UserError(f"no scene has the target {name}; there are {known}")
    for scene in scenes:
        if wanted and not searched_targets(scene, wanted):
            raise UserError(f"scene '{scene.name}' has none of the targets {', '.join(wanted)}; leave it out")


def check_recogniser_scenes(
    scenes: Sequence[Scene], recogniser_scenes: Sequence[Scene], wanted: Sequence[str]
) -> list[str]:
    """Make sure that scenes suit a recogniser that is trained elsewhere.

    Args:
        scenes: where is searched.
        recogniser_scenes: what the recogniser is trained on.
        wanted: see `searched_targets`.

    Returns:
        Sentences on what is searched for though the recogniser is not trained on it.

    Raises:
        UserError: if it would be trained with a picture of a target that a scene holds out, or on a scene without
            targets.
    """
    for scene in recogniser_scenes:
        scene.require_targets()
    used = {
        picture
        for scene in recogniser_scenes
        for target in scene.targets
        for picture in target.pictures[: target.trained]
    }
    visible = {name for scene in recogniser_scenes for name in searched_targets(scene, ())}
    notes = []
    for scene in scenes:
        names = searched_targets(scene, wanted)
        for target in (scene.targets[scene.target_index(name)] for name in names):
            if used & set(target.pictures[target.trained :]):
                raise UserError(
                    f"the recogniser would be trained with pictures of '{target.name}' that scene '{scene.name}' "
                    "holds out; make its scenes anew from this one with `scenes elsewhere`"
                )
        if unknown := [name for name in names if name not in visible]:
            notes.append(
                f"the recogniser is not trained on {', '.join(unknown)}, which {scene.name} is searched for; add "
                "scenes that show them to --recogniser-scenes, or leave them out of --targets"
            )
    return notes
