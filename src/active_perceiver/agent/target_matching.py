"""The targets an agent was trained for, told by a picture: which of them it shows, and how near to get to it."""

from __future__ import annotations

import hashlib
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from active_perceiver.agent.config import AgentConfig, AgentError, KnownTarget, picture_folder
from active_perceiver.agent.found_criterion import OPEN_SET_SCORE, FoundCriterion
from active_perceiver.recognition.recogniser import Recogniser
from active_perceiver.scenes import read_image
from active_perceiver.utils.files import replacing
from active_perceiver.utils.linalg import unit_vectors
from active_perceiver.vision.backbone import Backbone, pooled_middle

PICTURES_FILE = "known_pictures.npz"
"""Where an agent keeps what its networks make of its targets' pictures. Without it, its first search takes longer to
begin."""

RECOGNISER_FILE = "recogniser.onnx"


@dataclass(frozen=True, eq=False)
class GalleryPictures:
    """What an agent's networks make of the K pictures of a target it was trained with.

    Attributes:
        embeddings: (K, C) float32, the recogniser's.
        features: (K, D) float32, what the policy is shown of the target, see `pooled_middle`.
    """

    embeddings: NDArray[np.float32]
    features: NDArray[np.float32]


@dataclass(frozen=True)
class Match:
    """The known picture that a picture is most like.

    Attributes:
        target: which it shows.
        picture: its number among those of the target.
        similarity: cosine similarity of the recogniser's codes, -1..1.
    """

    target: KnownTarget
    picture: int
    similarity: float


class TargetGallery:
    """The targets an agent was trained for, told apart by their pictures: how close it has to get to each.

    Pictures are compared by the recogniser's codes of them, which were learned to tell objects apart. Computing the
    codes of all pictures takes as long as dozens of actions, so an agent is saved with them: `PICTURES_FILE` holds an
    array for each target, named by a fingerprint of all that it was computed from, with a picture's code and features
    in each row. What is not there under the name that it should have, is computed.
    """

    def __init__(self, folder: Path, config: AgentConfig, backbone: Backbone, recogniser: Recogniser) -> None:
        self._folder = folder
        self._config = config
        self._backbone = backbone
        self._recogniser = recogniser
        self._stored: dict[str, NDArray[np.float32]] | None = None
        self._rows: dict[KnownTarget, NDArray[np.float32]] = {}

    def pictures(self, target: KnownTarget) -> GalleryPictures:
        """What is known of a target's pictures; read or computed when first asked for.

        Raises:
            AgentError: if the agent's folder holds no picture of the target.
        """
        rows = self._known(target)
        return GalleryPictures(rows[:, : -self._backbone.channels], rows[:, -self._backbone.channels :])

    def _known(self, target: KnownTarget) -> NDArray[np.float32]:
        if target not in self._rows:
            if self._stored is None:
                self._stored = _read_rows(self._folder / PICTURES_FILE)
            files = self._pictures(target)
            stored = self._stored.get(self._fingerprint(files))
            self._rows[target] = self._compute(files) if stored is None else stored
        return self._rows[target]

    def save_pictures(self) -> None:
        """Write `PICTURES_FILE`, atomically, for all targets.

        Raises:
            AgentError: if the agent's folder holds no picture of a target.
        """
        rows = {self._fingerprint(self._pictures(target)): self._known(target) for target in self._config.targets}
        with replacing(self._folder / PICTURES_FILE) as temporary:
            np.savez(temporary, allow_pickle=False, **rows)

    def _pictures(self, target: KnownTarget) -> list[Path]:
        pictures = picture_folder(self._folder, target.scene, target.name)
        files = sorted(pictures.glob("*"))
        if not files:
            raise AgentError(f"{pictures} holds no pictures; copy the whole agent")
        return files

    def _compute(self, files: list[Path]) -> NDArray[np.float32]:
        maps = self._backbone.maps([read_image(file) for file in files])
        return np.concatenate([self._recogniser.encode_target(maps), pooled_middle(maps)], axis=1)

    def _fingerprint(self, files: list[Path]) -> str:
        """Names backbone, recogniser and pictures: codes with the same fingerprint are the same."""
        digest = self._networks.copy()
        for file in files:
            digest.update(hashlib.sha256(file.read_bytes()).digest())
        return digest.hexdigest()[:16]

    @cached_property
    def _networks(self) -> hashlib._Hash:
        recogniser = (self._folder / RECOGNISER_FILE).read_bytes()
        return hashlib.sha256(self._backbone.fingerprint.encode() + recogniser)

    def match(self, embedding: NDArray[np.float32], scene: str) -> Match | None:
        """The picture of a known target that the one with this code is most like; None if it is like none.

        Args:
            embedding: (C,) the recogniser's code of a picture.
            scene: whose targets to compare with.
        """
        ours, best = unit_vectors(embedding), None
        for target in self._config.targets:
            if target.scene == scene:
                likeness = unit_vectors(self.pictures(target).embeddings) @ ours
                picture = int(likeness.argmax())
                if best is None or likeness[picture] > best.similarity:
                    best = Match(target, picture, float(likeness[picture]))
        return best if best is not None and best.similarity >= self._config.match_threshold else None

    def criterion(self, match: Match | None) -> FoundCriterion:
        """When to say found for a picture that is most like a known one, or like none.

        A recogniser knows what it does not know less well than the rest, so for a picture that shows none of the
        known targets it has to be almost certain.
        """
        if match is None:
            return FoundCriterion(max(self._config.score_threshold, OPEN_SET_SCORE), self._config.stop_area_threshold)
        return FoundCriterion(self._config.score_threshold, match.target.stop_area_threshold)


def _read_rows(path: Path) -> dict[str, NDArray[np.float32]]:
    """What is in a `PICTURES_FILE`; nothing if it is missing or damaged, for everything in it can be computed."""
    try:
        with np.load(path, allow_pickle=False) as file:
            return {name: file[name] for name in file.files}
    except Exception:  # a damaged file makes numpy and zipfile raise exceptions of many kinds
        return {}
