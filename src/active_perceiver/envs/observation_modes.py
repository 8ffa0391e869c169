"""What an environment shows: the view as an image, as features, or nothing but the target's box.

A mode is a small class with a Gymnasium space, the number of pictures per target, and `look`, which turns the indices
of some searches' states, targets and pictures into their observations.
"""

from __future__ import annotations

from typing import Any, Protocol, get_args

import numpy as np
from gymnasium import spaces
from numpy.typing import NDArray

from active_perceiver.envs.config import EnvConfig, ObservationMode
from active_perceiver.envs.observations import Observations
from active_perceiver.envs.task import SearchTask
from active_perceiver.errors import SearchError
from active_perceiver.scenes import Scene
from active_perceiver.scenes.images import square_image
from active_perceiver.utils.progress import progress_bar
from active_perceiver.vision.backbone import IMAGE_SIZE, load_backbone
from active_perceiver.vision.cache import scene_features
from active_perceiver.vision.location import GRID

MODES: tuple[str, ...] = get_args(ObservationMode)
PIXELS = 84
"""Side of the images that are shown if nobody says otherwise: what the networks of Atari players take."""


class ObservationTables(Protocol):
    """One mode, for one task.

    Attributes:
        space: of one observation.
        pictures: number of pictures per target.
    """

    space: spaces.Dict
    pictures: int

    def look(self, states: Any, targets: Any, pictures: Any) -> dict[str, NDArray[Any]]:
        """The observations of some searches: indices of one shape in, arrays that begin with that shape out."""
        ...


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


class ImageMode:
    """`view` and `target`: what the robot sees, and the picture of what it searches for, (size, size, 3) uint8."""

    def __init__(self, scene: Scene, task: SearchTask, size: int) -> None:
        if size < 1:
            raise SearchError(f"image_size must be at least 1 pixel, got {size}")
        searched = [scene.targets[scene.target_index(name)] for name in task.targets]
        self.pictures = _trained_pictures(scene, task)
        self._views = PixelViews(scene, size)
        self._targets = np.stack(
            [[square_image(target.picture(number), size) for number in range(self.pictures)] for target in searched]
        )
        pixels = spaces.Box(0, 255, (size, size, 3), np.uint8)
        self.space = spaces.Dict({"view": pixels, "target": pixels})

    def look(self, states: Any, targets: Any, pictures: Any) -> dict[str, NDArray[Any]]:
        """See `ObservationTables`."""
        return {"view": self._views[states], "target": self._targets[targets, pictures]}


class FeatureMode:
    """`view` and `target`: backbone features, (D,) float32; `mask`: the 5 x 5 location mask, (25,) float32."""

    def __init__(self, observations: Observations) -> None:
        self.pictures = observations.pictures
        self._observations = observations
        self.space = spaces.Dict(
            {
                "view": _feature_space(observations.view_features),
                "target": _feature_space(observations.target_features),
                "mask": spaces.Box(0, 1, (GRID * GRID,), np.float32),
            }
        )

    def look(self, states: Any, targets: Any, pictures: Any) -> dict[str, NDArray[Any]]:
        """See `ObservationTables`."""
        return {
            "view": self._observations.view_features[states],
            "target": self._observations.target_features[targets, pictures],
            "mask": self._observations.masks[states, targets, pictures],
        }


class BoxMode:
    """`box`: the target's ground-truth box, (5,) float32; `target`: its number.

    A box is 1, centre x, centre y, width, height as fractions of the image, and five zeros where the target is not
    visible. There is no image and no pose: an agent that wants to know where it is must remember what it did.
    """

    pictures = 1

    def __init__(self, scene: Scene, task: SearchTask) -> None:
        boxes = scene.boxes[:, [scene.target_index(name) for name in task.targets]]
        visible = ~np.isnan(boxes[..., :1])
        # A box may stick out of the image by rounding.
        self._boxes = np.concatenate([visible, np.clip(np.nan_to_num(boxes), 0, 1)], axis=-1, dtype=np.float32)
        self.space = spaces.Dict(
            {"box": spaces.Box(0, 1, (5,), np.float32), "target": spaces.Discrete(len(task.targets))}
        )

    def look(self, states: Any, targets: Any, pictures: Any) -> dict[str, NDArray[Any]]:
        """See `ObservationTables`."""
        return {"box": self._boxes[states, targets], "target": np.array(targets, np.int64)}


def shown_in(
    config: EnvConfig, scene: Scene | None, task: SearchTask, observations: Observations | None = None
) -> ObservationTables:
    """The mode that is asked for.

    Args:
        config: its name, the size of images and the backbone.
        scene: needed unless there are observations.
        task: the search.
        observations: features and masks to show; None to compute them from the scene.

    Raises:
        SearchError: if something is missing or does not go together.
        BackboneError: if features are to be computed and there is no such backbone.
    """
    mode = config.observation or ("image" if observations is None else "features")
    if mode not in MODES:
        raise SearchError(f"there is no observation mode '{mode}'; choose one of {', '.join(MODES)}")
    if observations is not None:
        if mode != "features":
            raise SearchError(f"the observations given are features; leave them out to be shown '{mode}'")
        observations.check_fits(task)
        return FeatureMode(observations)
    if scene is None:
        raise SearchError(f"without observations the mode '{mode}' needs the scene; give it along with the task")
    if mode == "features":
        return FeatureMode(computed_observations(scene, task, config.image_size or IMAGE_SIZE, config.backbone))
    return BoxMode(scene, task) if mode == "boxes" else ImageMode(scene, task, config.image_size or PIXELS)


def computed_observations(
    scene: Scene, task: SearchTask, image_size: int = IMAGE_SIZE, backbone: str = "efficientnet_lite0"
) -> Observations:
    """Pooled features of a scene's views and target pictures, and masks of its ground-truth boxes.

    The first time takes a minute or so a scene; the features are kept in the cache.

    Raises:
        BackboneError: if there is no such backbone.
    """
    searched = [scene.target_index(name) for name in task.targets]
    with progress_bar(f"features of {scene.name}") as report:
        features = scene_features(scene, load_backbone(backbone, image_size=image_size), report)
    pictures = features.target_features[searched][:, : _trained_pictures(scene, task)]
    return Observations.from_boxes(features.view_features, pictures, scene.boxes[:, searched])


def _trained_pictures(scene: Scene, task: SearchTask) -> int:
    """As many as every target has to train with."""
    return min(scene.targets[scene.target_index(name)].trained for name in task.targets)


def _feature_space(features: NDArray[np.float32]) -> spaces.Box:
    return spaces.Box(features.min(), features.max(), features.shape[-1:], np.float32)
