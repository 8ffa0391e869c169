"""What a policy gets to see in each state of a search: features and location masks, as tables."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from active_perceiver.envs.task import SearchTask
from active_perceiver.errors import SearchError
from active_perceiver.vision.location import GRID, location_mask


@dataclass(frozen=True, eq=False)
class Observations:
    """Everything a policy can be shown in one search task, K pictures per target.

    Attributes:
        view_features: (S, D) float32, backbone features of each state's view.
        target_features: (T, K, D) float32, backbone features of each target's pictures.
        masks: (S, T, K, 25) float32, 0 or 1: where target t is seen in view s when asked for with picture k.
    """

    view_features: NDArray[np.float32]
    target_features: NDArray[np.float32]
    masks: NDArray[np.float32]

    def __post_init__(self) -> None:
        if self.view_features.ndim != 2 or self.target_features.ndim != 3:
            raise SearchError(
                "features need the shapes (states, D) and (targets, pictures, D), got "
                f"{self.view_features.shape} and {self.target_features.shape}"
            )
        states, width = self.view_features.shape
        targets, pictures, target_width = self.target_features.shape
        if width != target_width:
            raise SearchError(f"views have {width} features and targets {target_width}; use one backbone for both")
        if pictures == 0:
            raise SearchError("a target needs at least one picture")
        expected = (states, targets, pictures, GRID * GRID)
        if self.masks.shape != expected:
            raise SearchError(f"masks have shape {self.masks.shape}, expected {expected}")
        for label in ("view_features", "target_features", "masks"):
            array = getattr(self, label)
            if array.dtype != np.float32:
                raise SearchError(f"{label} are {array.dtype}, expected float32")
            if not np.isfinite(array).all():
                raise SearchError(f"{label} hold numbers that are not finite; compute them again")
        if not np.isin(self.masks, (0.0, 1.0)).all():
            raise SearchError("masks must be 0 or 1 everywhere")

    @classmethod
    def from_boxes(
        cls,
        view_features: NDArray[np.float32],
        target_features: NDArray[np.float32],
        boxes: NDArray[np.floating],
    ) -> Observations:
        """Observations of a recogniser that makes no mistake.

        Args:
            view_features: (S, D).
            target_features: (T, K, D).
            boxes: (S, T, 4) ground truth, NaN where not visible; see `Scene.boxes`.
        """
        masks = location_mask(boxes)
        repeated = np.repeat(masks[:, :, None], target_features.shape[1], axis=2)
        return cls(view_features.astype(np.float32), target_features.astype(np.float32), repeated)

    @classmethod
    def from_detections(
        cls,
        view_features: NDArray[np.float32],
        target_features: NDArray[np.float32],
        scores: NDArray[np.floating],
        boxes: NDArray[np.floating],
        threshold: float = 0.5,
    ) -> Observations:
        """Observations of a recogniser as it is.

        Args:
            view_features: (S, D).
            target_features: (T, K, D).
            scores: (S, T, K) probability that the target is in the view.
            boxes: (S, T, K, 4) where it would be; ignored where the score is below the threshold.
            threshold: least score that counts as seen, 0..1.

        Raises:
            SearchError: if shapes do not agree.
        """
        if boxes.shape != (*scores.shape, 4):
            raise SearchError(f"boxes have shape {boxes.shape}, expected {(*scores.shape, 4)} to go with the scores")
        masks = location_mask(np.where((scores >= threshold)[..., None], boxes, np.nan))
        return cls(view_features.astype(np.float32), target_features.astype(np.float32), masks)

    @property
    def pictures(self) -> int:
        """Number of pictures per target, K."""
        return self.target_features.shape[1]

    def check_fits(self, task: SearchTask) -> None:
        """Make sure that these are observations of this task.

        Raises:
            SearchError: if the numbers of states or targets differ.
        """
        if self.masks.shape[:2] != task.goals.shape:
            raise SearchError(
                f"observations of {self.masks.shape[0]} states and {self.masks.shape[1]} targets do not fit the "
                f"search in '{task.scene}' with {len(task)} states and {len(task.targets)} targets"
            )
