"""What both environments look their observations up in: features, or pictures where there are no features."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from gymnasium import spaces
from numpy.typing import NDArray

from active_perceiver.scenes import Scene, open_scene
from active_perceiver.scenes.images import square_image
from active_perceiver.search.location import GRID, location_mask
from active_perceiver.search.observations import Observations
from active_perceiver.search.task import SearchError, SearchTask

RESET_OPTIONS = ("start", "target", "picture")


class PixelViews:
    """A scene's views at a small size, decoded when first looked at.

    Args:
        scene: whose views.
        size: side in pixels.
    """

    def __init__(self, scene: Scene, size: int) -> None:
        self._scene = scene
        self._images = np.zeros((len(scene), size, size, 3), np.uint8)
        self._decoded = np.zeros(len(scene), bool)

    def __getitem__(self, states: Any) -> NDArray[np.uint8]:
        """Images of one state (size, size, 3) or of several (n, size, size, 3), uint8."""
        for state in np.unique(states):
            if not self._decoded[state]:
                self._images[state] = square_image(self._scene.view(int(state)), self._images.shape[1])
                self._decoded[state] = True
        return self._images[states]


@dataclass(frozen=True, eq=False)
class EnvTables:
    """A search task and what is seen in it.

    Attributes:
        task: the search.
        scene: for rendering; None if only tables were given.
        views: indexed by state.
        targets: (T, K, ...) indexed by target and picture.
        masks: (S, T, K, 25) float32 indexed by state, target and picture.
        space: of one observation.
    """

    task: SearchTask
    scene: Scene | None
    views: NDArray[np.float32] | PixelViews
    targets: NDArray[Any]
    masks: NDArray[np.float32]
    space: spaces.Dict

    @property
    def pictures(self) -> int:
        """Number of pictures per target."""
        return self.targets.shape[1]

    def look(self, states: Any, targets: Any, pictures: Any) -> dict[str, NDArray[Any]]:
        """The observations of some searches: indices of one shape in, arrays that begin with that shape out."""
        seen = {
            "view": self.views[states],
            "target": self.targets[targets, pictures],
            "mask": self.masks[states, targets, pictures],
        }
        # Indexing with arrays has copied already; a single index only points into the tables, which must not change.
        return seen if np.ndim(states) else {name: array.copy() for name, array in seen.items()}

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
    scene: Scene | str | Path | None = None,
    targets: Sequence[str] | None = None,
    task: SearchTask | None = None,
    observations: Observations | None = None,
    image_size: int = 84,
) -> EnvTables:
    """Put together what an environment needs, from what it was given.

    Args:
        scene: a scene, the name of a bundled one or a file; needed for pictures and for rendering.
        targets: names, if no task is given; None for all of the scene's.
        task: the search; None for that of the scene.
        observations: features and masks; None for pictures and ground-truth masks.
        image_size: side of the pictures in pixels.

    Raises:
        SearchError: if something is missing or does not fit.
        SceneError: if there is no such scene or target.
    """
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
    if observations is not None:
        observations.check_fits(task)
        space: dict[str, spaces.Space[Any]] = {
            "view": _feature_space(observations.view_features),
            "target": _feature_space(observations.target_features),
        }
        views: NDArray[np.float32] | PixelViews = observations.view_features
        pictures: NDArray[Any] = observations.target_features
        masks = observations.masks
    elif scene is not None:
        pixels = spaces.Box(0, 255, (image_size, image_size, 3), np.uint8)
        space = {"view": pixels, "target": pixels}
        views = PixelViews(scene, image_size)
        pictures, masks = _pictures_and_masks(scene, task, image_size)
    else:
        raise SearchError("without observations an environment shows pictures, for which it needs the scene")
    space["mask"] = spaces.Box(0, 1, (GRID * GRID,), np.float32)
    return EnvTables(task, scene, views, pictures, masks, spaces.Dict(space))


def _feature_space(features: NDArray[np.float32]) -> spaces.Box:
    return spaces.Box(features.min(), features.max(), features.shape[-1:], np.float32)


def _pictures_and_masks(scene: Scene, task: SearchTask, size: int) -> tuple[NDArray[np.uint8], NDArray[np.float32]]:
    searched = [scene.target_index(name) for name in task.targets]
    fewest = min(scene.targets[index].trained for index in searched)
    targets = np.stack(
        [
            np.stack([square_image(scene.targets[index].picture(number), size) for number in range(fewest)])
            for index in searched
        ]
    )
    masks = location_mask(scene.boxes[:, searched])[:, :, None]
    return targets, np.broadcast_to(masks, (*masks.shape[:2], fewest, GRID * GRID))
