"""What `scenes info` says about a scene."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from PIL import Image

from active_perceiver.figures.contact_sheet import contact_sheet
from active_perceiver.scenes import Scene
from active_perceiver.scenes.lattice import goal_states, islands, steps_to_goal
from active_perceiver.utils.files import replacing


def describe(scene: Scene) -> str:
    """A few lines on the whole and one on each target."""
    places = len(np.unique(scene.positions))
    each = np.bincount(scene.positions)
    views = f"{each.max()}" if each.min() == each.max() else f"{each.min()} to {each.max()}"
    tilts = len(np.unique(scene.poses[:, 3]))
    blocked = float((scene.transitions == np.arange(len(scene))[:, None]).mean())
    megabytes = sum(len(view) for view in scene.views) / 1e6
    parts = islands(scene.transitions).max() + 1
    actions = ", ".join(action.value for action in scene.actions)
    size = f"{scene.image_size} x {scene.image_size} pixels"
    lines = [
        f"{scene.name}: {scene.source}",
        f"  views      {len(scene)} of {size}, {scene.fov:g} degrees, {megabytes:.1f} MB",
        f"  poses      {places} places, {views} views at each, {tilts} tilt(s), {parts} island(s)",
        f"  actions    {actions}; {100 * blocked:.0f} % blocked",
        f"  content    {scene.content_hash}",
        "",
    ]
    if not scene.targets:
        return "\n".join([*lines, "  no objects are marked; its views can be searched for, with train --task view"])
    lines.append(
        f"  {'target':<14} {'seen in':>8} {'largest box':>12} {'goals':>6} {'steps to a goal':>16}"
        f" {'pictures':>9} + held out"
    )
    goals = goal_states(scene.areas)
    for index, target in enumerate(scene.targets):
        steps = steps_to_goal(scene.transitions, goals[:, index])
        way = steps[steps > 0]
        distance = f"{way.mean():.1f} (most {way.max()})" if len(way) else "-"
        lines.append(
            f"  {target.name:<14} {100 * (scene.areas[:, index] > 0).mean():>6.1f} % "
            f"{100 * scene.areas[:, index].max():>10.2f} % {goals[:, index].sum():>6} {distance:>16} "
            f"{target.trained:>9} + {target.held_out}"
        )
    return "\n".join(lines)


def write_contact_sheet(scene: Scene, path: Path, *, force: bool = False) -> None:
    """Write the contact sheet as an image file.

    Raises:
        OutputExistsError: if the file exists and `force` is false.
    """
    with replacing(path, force) as temporary:
        Image.fromarray(contact_sheet(scene)).save(temporary)
