"""What an agent looks for: the object or the view in a picture, and when it may say that it has found it."""

from __future__ import annotations

import hashlib
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import ClassVar, Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from active_perceiver.agent_config import AgentConfig, AgentError, KnownTarget, SearchKind, picture_folder
from active_perceiver.files import replacing
from active_perceiver.policies.restless import unit_vectors
from active_perceiver.recognition.recogniser import Detection, Recogniser
from active_perceiver.scenes import read_image
from active_perceiver.vision.backbone import Backbone, pooled, pooled_middle

PICTURES_FILE = "known_pictures.npz"
"""Where an agent keeps what its networks make of its targets' pictures. Without it, its first search takes longer to
begin."""

RECOGNISER_FILE = "recogniser.onnx"

UNKNOWN_SCORE = 0.99
"""Least presence probability for saying found when the picture shows none of the targets an agent was trained for."""


@dataclass(frozen=True)
class FoundCriterion:
    """When an agent says found.

    Attributes:
        score: least presence probability.
        area: least area of its own box, as a fraction of the image.
    """

    score: float
    area: float

    def met(self, score: ArrayLike, area: ArrayLike) -> NDArray[np.bool_]:
        """Whether detections are enough, for scalars or arrays of one shape."""
        return (np.asarray(score) >= self.score) & (np.asarray(area) >= self.area)

    def nearly_met(self, score: ArrayLike, area: ArrayLike) -> NDArray[np.bool_]:
        """Whether detections would be enough if half the area were: what the view before a goal's shows as well."""
        return self.met(score, 2 * np.asarray(area))


@dataclass(frozen=True, eq=False)
class KnownPictures:
    """What an agent's networks make of the K pictures of a target it was trained with.

    Attributes:
        codes: (K, C) float32, the recogniser's.
        features: (K, D) float32, what the policy is shown of the target, see `pooled_middle`.
    """

    codes: NDArray[np.float32]
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


class KnownTargets:
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

    def pictures(self, target: KnownTarget) -> KnownPictures:
        """What is known of a target's pictures; read or computed when first asked for.

        Raises:
            AgentError: if the agent's folder holds no picture of the target.
        """
        rows = self._known(target)
        return KnownPictures(rows[:, : -self._backbone.channels], rows[:, -self._backbone.channels :])

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

    def match(self, code: NDArray[np.float32], scene: str) -> Match | None:
        """The picture of a known target that the one with this code is most like; None if it is like none.

        Args:
            code: (C,) the recogniser's code of a picture.
            scene: whose targets to compare with.
        """
        ours, best = unit_vectors(code), None
        for target in self._config.targets:
            if target.scene == scene:
                likeness = unit_vectors(self.pictures(target).codes) @ ours
                picture = int(likeness.argmax())
                if best is None or likeness[picture] > best.similarity:
                    best = Match(target, picture, float(likeness[picture]))
        return best if best is not None and best.similarity >= self._config.known_similarity else None

    def criterion(self, match: Match | None) -> FoundCriterion:
        """When to say found for a picture that is most like a known one, or like none.

        A recogniser knows what it does not know less well than the rest, so for a picture that shows none of the
        known targets it has to be almost certain.
        """
        if match is None:
            return FoundCriterion(max(self._config.score_threshold, UNKNOWN_SCORE), self._config.found_area)
        return FoundCriterion(self._config.score_threshold, match.target.found_area)


def _read_rows(path: Path) -> dict[str, NDArray[np.float32]]:
    """What is in a `PICTURES_FILE`; nothing if it is missing or damaged, for everything in it can be computed."""
    try:
        with np.load(path, allow_pickle=False) as file:
            return {name: file[name] for name in file.files}
    except Exception:  # a damaged file makes numpy and zipfile raise exceptions of many kinds
        return {}


@dataclass(frozen=True)
class Sight:
    """What an agent makes of one image, apart from what to do next.

    Attributes:
        detection: where it sees the target, or None if it does not.
        found: this image says that it is in front of the target.
        nearly: this image says that it is nearly there, see `FoundCriterion.nearly_met`.
    """

    detection: Detection | None
    found: bool
    nearly: bool


def sight_of(score: float, box: NDArray[np.floating], threshold: float, criterion: FoundCriterion) -> Sight:
    """What an agent that searches for an object makes of what its recogniser says of an image.

    Args:
        score: presence probability.
        box: (4,) where the object would be.
        threshold: presence probability from which on it counts as seen.
        criterion: when it says found.
    """
    if score < threshold:
        return Sight(None, found=False, nearly=False)
    seen = Detection(score, box)
    met, nearly = (bool(check(seen.score, seen.area)) for check in (criterion.met, criterion.nearly_met))
    return Sight(seen, found=met, nearly=nearly)


class Seeker(Protocol):
    """What is different between agents that search for different things.

    Attributes:
        files: what it needs of an agent's folder, besides the policy.
    """

    files: ClassVar[tuple[str, ...]]

    def __init__(self, folder: Path, config: AgentConfig, backbone: Backbone, threads: int | None) -> None:
        """Load what it needs; what runs, runs on so many CPU threads, None for one per core."""

    def begin(self, maps: NDArray[np.float32], branch: str) -> NDArray[np.float32]:
        """Begin a search in a scene with a picture's (1, C, h, w) maps; (1, D) target features for the policy."""

    def look(self, maps: NDArray[np.float32]) -> Sight:
        """Look at an image with these (1, C, h, w) maps."""


class ObjectSeeker:
    """Looks for the object in a picture: its recogniser draws a box, and a box that is large enough means found.

    A picture of a known target, however it was taken, is taken for the picture of that target which it is most like:
    with the ones they were trained with, recogniser and policy work best.

    Attributes:
        recogniser: draws the boxes.
        known: the targets the agent was trained for.
        criterion: when it says found in the current search.
    """

    files: ClassVar[tuple[str, ...]] = (RECOGNISER_FILE,)
    criterion: FoundCriterion

    def __init__(self, folder: Path, config: AgentConfig, backbone: Backbone, threads: int | None) -> None:
        self.recogniser = Recogniser(folder / RECOGNISER_FILE, threads)
        self.known = KnownTargets(folder, config, backbone, self.recogniser)
        self._score_threshold = config.score_threshold

    def begin(self, maps: NDArray[np.float32], branch: str) -> NDArray[np.float32]:
        """See `Seeker.begin`."""
        self._code = self.recogniser.encode_target(maps)
        match = self.known.match(self._code[0], branch)
        self.criterion = self.known.criterion(match)
        if match is None:
            return pooled_middle(maps)
        known = self.known.pictures(match.target)
        self._code = known.codes[[match.picture]]
        return known.features[[match.picture]]

    def look(self, maps: NDArray[np.float32]) -> Sight:
        """See `Seeker.look`."""
        scores, boxes = self.recogniser.detect(maps, self._code)
        return sight_of(float(scores[0]), boxes[0], self._score_threshold, self.criterion)


class ViewSeeker:
    """Looks for the place from where a picture was taken: a view that is as good as the picture means found."""

    files: ClassVar[tuple[str, ...]] = ()

    def __init__(self, folder: Path, config: AgentConfig, backbone: Backbone, threads: int | None) -> None:
        self._found_similarity = config.found_similarity

    def begin(self, maps: NDArray[np.float32], branch: str) -> NDArray[np.float32]:
        """See `Seeker.begin`."""
        target = pooled(maps)  # as views are, for the picture is one
        self._target = unit_vectors(target[0])
        return target

    def look(self, maps: NDArray[np.float32]) -> Sight:
        """See `Seeker.look`; nothing is ever detected."""
        similarity = float(unit_vectors(pooled(maps)[0]) @ self._target)
        return Sight(None, found=similarity >= self._found_similarity, nearly=False)


SEEKERS: dict[SearchKind, type[Seeker]] = {"object": ObjectSeeker, "view": ViewSeeker}
