"""What an agent remembers of a room it was trained in: how each state looks, where it is, where actions lead."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from active_perceiver.agent.config import AgentError
from active_perceiver.agent.exploration.path_planning import ShortestPaths
from active_perceiver.scenes import Scene
from active_perceiver.utils.files import replacing
from active_perceiver.utils.linalg import unit_vectors
from active_perceiver.utils.stored_names import VIEW_MAP, current_names


@dataclass(frozen=True, eq=False)
class ViewMap:
    """A scene without its images.

    Attributes:
        descriptors: (S, D) float32, unit vectors of the pooled features of each state's view.
        poses: (S, 4) float32: x, z in metres, heading and tilt in degrees.
        transitions: (S, A) int32, the next state; the state's own index where the move is blocked.
        fov: the camera's field of view in degrees.
    """

    descriptors: NDArray[np.float32]
    poses: NDArray[np.float32]
    transitions: NDArray[np.int32]
    fov: float

    def __post_init__(self) -> None:
        states = len(self.descriptors)
        shapes = (self.descriptors.ndim, self.poses.shape, self.transitions.ndim, len(self.transitions))
        if states == 0 or shapes != (2, (states, 4), 2, states):
            raise AgentError(
                f"a view map has descriptors {self.descriptors.shape}, poses {self.poses.shape} and transitions "
                f"{self.transitions.shape}, which do not go together"
            )
        if not (np.isfinite(self.descriptors).all() and np.isfinite(self.poses).all() and 0 < self.fov < 180):
            raise AgentError("a view map holds numbers that are not finite, or no field of view of 0..180 degrees")
        if self.transitions.min() < 0 or self.transitions.max() >= states:
            raise AgentError(f"a view map's transitions lead outside its {states} states")

    @classmethod
    def of(cls, scene: Scene, view_features: NDArray[np.floating]) -> ViewMap:
        """Remember a scene.

        Args:
            scene: with S states.
            view_features: (S, D) pooled features of its views, of any length.
        """
        descriptors = unit_vectors(np.asarray(view_features, np.float32))
        return cls(descriptors, scene.poses, scene.transitions, scene.fov)

    @cached_property
    def shortest_paths(self) -> ShortestPaths:
        """How far it is between its states, shared by all who search here."""
        return ShortestPaths(self.transitions)

    def save(self, path: Path) -> None:
        """Write it, with the descriptors as float16, whole or not at all.

        Raises:
            OutputError: if it cannot be written.
        """
        path.parent.mkdir(parents=True, exist_ok=True)
        with replacing(path, force=True) as temporary, temporary.open("wb") as file:
            np.savez_compressed(
                file, allow_pickle=False, descriptors=self.descriptors.astype(np.float16), poses=self.poses,
                transitions=self.transitions, fov=self.fov,
            )  # fmt: skip

    @classmethod
    def load(cls, path: Path) -> ViewMap:
        """Read it.

        Raises:
            AgentError: if the file is damaged.
        """
        try:
            with np.load(path, allow_pickle=False) as file:
                data = current_names(file, VIEW_MAP)
                descriptors = unit_vectors(data["descriptors"].astype(np.float32))
                return cls(descriptors, data["poses"], data["transitions"], float(data["fov"]))
        except AgentError as error:
            raise AgentError(f"{path}: {error}; train the agent again") from None
        except Exception as error:  # a damaged file makes numpy and zipfile raise exceptions of many kinds
            raise AgentError(f"{path} cannot be read ({error}); copy or train the agent again") from None


def map_file(folder: Path, branch: str) -> Path:
    """Where an agent keeps its map of a scene."""
    return folder / "maps" / f"{branch}.npz"
