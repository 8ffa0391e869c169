"""What both environments consist of: a task, what is shown of it, and checks of what a reset is asked for."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from gymnasium import spaces
from numpy.typing import NDArray
from PIL import Image, ImageDraw

from active_perceiver.envs.config import EnvConfig
from active_perceiver.envs.observation_modes import ObservationTables, shown_in
from active_perceiver.envs.observations import Observations
from active_perceiver.envs.task import SearchTask
from active_perceiver.errors import SearchError
from active_perceiver.scenes import Scene, open_scene

RESET_OPTIONS = ("start", "target", "picture")
BOX_COLOUR = (255, 77, 46)


@dataclass(frozen=True, eq=False)
class EnvTables:
    """A search task and what is seen in it.

    Attributes:
        task: the search.
        scene: for rendering; None if only tables were given.
        shown: the observation mode.
    """

    task: SearchTask
    scene: Scene | None
    shown: ObservationTables

    @property
    def space(self) -> spaces.Dict:
        """The space of one observation."""
        return self.shown.space

    @property
    def pictures(self) -> int:
        """Number of pictures per target."""
        return self.shown.pictures

    def look(self, states: Any, targets: Any, pictures: Any) -> dict[str, Any]:
        """The observations of some searches: indices of one shape in, arrays that begin with that shape out."""
        seen = self.shown.look(states, targets, pictures)
        if np.ndim(states):
            return seen
        # Indexing with arrays has copied already; a single index only points into the tables, which must not change.
        # A number is no array: Gymnasium's discrete spaces hold numbers.
        return {name: array.copy() if np.ndim(array) else np.int64(array) for name, array in seen.items()}

    def render(self, state: int, target: int) -> NDArray[np.uint8]:
        """The view with the target's box drawn on it, (H, W, 3) uint8 RGB.

        Raises:
            SearchError: if the scene is not known.
        """
        if self.scene is None:
            raise SearchError("rendering needs the scene; give it to the environment along with the task")
        view, name = self.scene.view(state), self.task.targets[target]
        if name not in self.scene.target_names:
            return view  # one that is searched by a view has no box
        box = self.scene.boxes[state, self.scene.target_index(name)]
        if np.isnan(box).any():
            return view
        canvas = Image.fromarray(view)
        scale = np.array(canvas.size)
        low, high = (box[:2] - box[2:] / 2) * scale, (box[:2] + box[2:] / 2) * scale - 1
        corners = (*np.round(low).astype(int).tolist(), *np.round(np.maximum(low, high)).astype(int).tolist())
        ImageDraw.Draw(canvas).rectangle(corners, outline=BOX_COLOUR, width=max(1, canvas.width // 150))
        return np.asarray(canvas)

    def check_options(self, options: Mapping[str, Any] | None) -> dict[str, Any]:
        """The options of a reset, with a target's name replaced by its index.

        Raises:
            SearchError: if an option is unknown, or there is no such target, picture or start.
        """
        chosen = dict(options or {})
        if unknown := sorted(set(chosen) - set(RESET_OPTIONS)):
            raise SearchError(f"unknown reset options {unknown}; known are {list(RESET_OPTIONS)}")
        if isinstance(chosen.get("target"), str):
            chosen["target"] = self.task.target_index(chosen["target"])
        for label, count in zip(RESET_OPTIONS, (len(self.task), len(self.task.targets), self.pictures), strict=True):
            if label in chosen and not ((np.asarray(chosen[label]) >= 0) & (np.asarray(chosen[label]) < count)).all():
                raise SearchError(f"reset option '{label}' must be in 0..{count - 1}, got {chosen[label]}")
        return chosen

    def check_starts(self, states: Any, targets: Any) -> None:
        """Make sure that searches can start there.

        Raises:
            SearchError: if a start is a goal already or cannot reach one.
        """
        if (np.asarray(self.task.steps[states, targets]) <= 0).any():
            raise SearchError(
                "a search cannot start at a goal, nor where no goal can be reached; see SearchTask.starts"
            )


def env_tables(
    scene: Scene | str | Path | None,
    targets: Sequence[str] | None,
    task: SearchTask | None,
    observations: Observations | None,
    config: EnvConfig,
) -> EnvTables:
    """Put together what an environment needs, from what it was given.

    Args:
        scene: a scene, the name of a bundled one or a file; may be left out if task and observations are given.
        targets: names, if no task is given; None for all of the scene's.
        task: the search; None for that of the scene.
        observations: features and masks; None to make them from the scene.
        config: says what is shown.

    Raises:
        SearchError: if something is missing or does not fit.
        SceneError: if there is no such scene or target.
    """
    if isinstance(targets, str):
        raise SearchError(f"targets are a list of names, got the text '{targets}'; write [{targets!r}]")
    if isinstance(scene, (str, Path)):
        scene = open_scene(scene)
    if task is None:
        if scene is None:
            raise SearchError("an environment needs a scene, or a task and observations")
        task = SearchTask.from_scene(scene, targets)
    elif targets is not None and tuple(targets) != task.targets:
        raise SearchError(f"the task has the targets {task.targets}, not {tuple(targets)}; give only one of the two")
    if scene is not None and (len(scene), scene.name) != (len(task), task.scene):
        raise SearchError(f"the task is for scene '{task.scene}' with {len(task)} states, not for '{scene.name}'")
    return EnvTables(task, scene, shown_in(config, scene, task, observations))
