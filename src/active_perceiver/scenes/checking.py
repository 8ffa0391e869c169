"""What is wrong with a scene beyond what its loading refuses, and what that means for a search."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass

import numpy as np

from active_perceiver.scenes.image_files import ImageError
from active_perceiver.scenes.lattice import UNREACHABLE, goal_states, islands, steps_to_goal
from active_perceiver.scenes.scene import PROPOSED, UNLABELLED, Scene

# Below this fraction of the image (10 x 10 of 300 x 300 pixels) even the largest box is hardly recognisable.
TINY_AREA = 0.0011


@dataclass(frozen=True)
class SceneIssue:
    """One finding.

    Attributes:
        text: a sentence: what is wrong and what that means.
        fatal: whether the scene, or one of its objects, cannot be searched because of it. Islands alone are no
            reason: a search can start where a goal can be reached, and the finding says how many states that are not.
    """

    text: str
    fatal: bool = False


def scene_issues(scene: Scene) -> list[SceneIssue]:
    """Everything a person should know before training in this scene; fatal findings first."""
    found = [*_moves(scene), *_targets(scene), *_labels(scene), *_views(scene)]
    return sorted(found, key=lambda problem: not problem.fatal)


def _moves(scene: Scene) -> list[SceneIssue]:
    blocked = scene.transitions == np.arange(len(scene))[:, None]
    if blocked.all():
        return [SceneIssue("every action is blocked in every state: a robot could not move at all", fatal=True)]
    found = []
    stuck = int(blocked.all(axis=1).sum())
    if stuck:
        found.append(SceneIssue(f"{stuck} states have no way out: a search that gets there is lost"))
    parts = np.bincount(islands(scene.transitions))
    if len(parts) > 1:
        found.append(
            SceneIssue(
                f"the states fall into {len(parts)} islands of {', '.join(str(size) for size in parts[:5])}"
                f"{' ...' if len(parts) > 5 else ''} states: from one no way leads to another and back, and a search "
                "finds only what is on its own; if the robot can go there, moves or views between them are missing: "
                "check the spacing and the headings, or give the moves (moves.csv)"
            )
        )
    for column, action in enumerate(scene.actions):
        if blocked[:, column].all():
            found.append(SceneIssue(f"{action.value} is blocked in every state: it could be left out"))
    return found


def _targets(scene: Scene) -> list[SceneIssue]:
    if not scene.targets:
        return [SceneIssue("no objects are marked: only views can be searched for, with `train --task view`")]
    if scene.labels is not None and not scene.labels.any():
        return []  # what is not labelled yet is said in `_labels`
    found = []
    goals = goal_states(scene.areas)
    for index, name in enumerate(scene.target_names):
        largest = float(scene.areas[:, index].max())
        if largest == 0:
            found.append(
                SceneIssue(f"'{name}' is never visible: it can be no target of a search", fatal=not goals.any())
            )
            continue
        if largest < TINY_AREA:
            pixels = np.sqrt(largest) * scene.image_size
            found.append(SceneIssue(f"'{name}' is at most {pixels:.0f} pixels large: too small to be recognised"))
        unreachable = int((steps_to_goal(scene.transitions, goals[:, index]) == UNREACHABLE).sum())
        if unreachable == len(scene) - int(goals[:, index].sum()) > 0:
            found.append(SceneIssue(f"no goal state of '{name}' can be reached from anywhere else", fatal=True))
        elif unreachable:
            found.append(
                SceneIssue(
                    f"from {unreachable} states no goal state of '{name}' can be reached; no search starts there"
                )
            )
    return found


def _labels(scene: Scene) -> list[SceneIssue]:
    if scene.labels is None:
        return []
    unlabelled, proposed = (int((scene.labels == state).sum()) for state in (UNLABELLED, PROPOSED))
    found = []
    if unlabelled:
        found.append(
            SceneIssue(
                f"{unlabelled} views are not labelled: no recogniser learns from them, and no search ends there; see"
                " `scenes label`"
            )
        )
    if proposed:
        found.append(
            SceneIssue(f"the boxes of {proposed} views were proposed by a recogniser and not looked at since")
        )
    return found


def _views(scene: Scene) -> list[SceneIssue]:
    found = []
    copies = sum(count - 1 for count in Counter(scene.views).values())
    if copies:
        found.append(
            SceneIssue(f"{copies} views are exact copies of others: a policy cannot tell these states apart")
        )
    broken, sizes = 0, Counter[tuple[int, ...]]()
    for state in range(len(scene)):
        try:
            sizes[scene.view(state).shape[:2]] += 1
        except ImageError:
            broken += 1
    if broken:
        found.append(SceneIssue(f"{broken} views cannot be decoded: capture the scene again", fatal=True))
    odd = sum(count for size, count in sizes.items() if size != (scene.image_size,) * 2)
    if odd:
        found.append(
            SceneIssue(f"{odd} views are not {scene.image_size} x {scene.image_size} pixels; they will be scaled")
        )
    for target in scene.targets:
        if copies := len(set(target.pictures[: target.trained]) & set(target.pictures[target.trained :])):
            found.append(
                SceneIssue(
                    f"{copies} pictures of '{target.name}' that are held out are exact copies of others that are "
                    "trained with: figures for pictures never seen would be too good"
                )
            )
        for index in range(len(target.pictures)):
            try:
                target.picture(index)
            except ImageError as error:
                found.append(SceneIssue(str(error), fatal=True))
    return found
