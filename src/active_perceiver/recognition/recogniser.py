"""The recogniser at run time: does a view show the target, and where. No torch."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from active_perceiver.errors import UserError
from active_perceiver.vision.cache import SceneFeatures
from active_perceiver.vision.sessions import ModelFileError, open_session

if TYPE_CHECKING:
    # It draws with a library that a robot needs not have.
    from active_perceiver.utils.progress import ProgressCallback

# Pairs of a view and a target that go through the network together: enough to keep the cores busy, little memory.
PAIRS = 64


class RecogniserError(UserError, ValueError):
    """A recogniser that cannot be loaded or was given arrays that do not fit it."""


@dataclass(frozen=True, eq=False)
class Detection:
    """A target seen in a view.

    Attributes:
        score: the probability that the target is there, 0..1.
        box: (4,) float32: centre x, centre y, width, height as fractions of the image.
    """

    score: float
    box: NDArray[np.float32]

    def __post_init__(self) -> None:
        if not 0.0 <= self.score <= 1.0:
            raise RecogniserError(f"a score is a probability between 0 and 1, got {self.score}")
        box = np.array(self.box, np.float32)
        if box.shape != (4,) or not np.isfinite(box).all() or (box[2:] < 0).any():
            raise RecogniserError(
                f"a box is four finite numbers, centre x, centre y, width and height (not negative), got {self.box}"
            )
        box.flags.writeable = False
        object.__setattr__(self, "box", box)

    @property
    def area(self) -> float:
        """Area of the box as a fraction of the image."""
        return float(self.box[2] * self.box[3])


class Recogniser:
    """Finds the object of a target picture in views.

    Args:
        model: a `recogniser.onnx` as `export_recogniser` writes it: its path, or its bytes.
        threads: CPU threads of one inference; None for one per core.

    Attributes:
        kind: one of `RECOGNISERS`, for example "matching".
        backbone: fingerprint of the backbone it was trained on, see `Backbone.fingerprint`; empty if not known.
        threshold: presence probability from which on a detection counts, chosen when it was trained.
        map_shape: (C, h, w) of the feature maps it takes.

    Raises:
        RecogniserError: if the file is missing or is not a recogniser.
    """

    def __init__(self, model: Path | str | bytes, threads: int | None = None) -> None:
        try:
            self._session = open_session(model if isinstance(model, bytes) else Path(model), threads, "recogniser")
        except ModelFileError as error:
            raise RecogniserError(str(error)) from None
        metadata = self._session.get_modelmeta().custom_metadata_map
        self.kind = metadata["recogniser"]
        self.backbone = metadata["backbone"]
        self.threshold = float(metadata["threshold"])
        shapes = {value.name: value.shape for value in self._session.get_inputs()}
        self.map_shape: tuple[int, int, int] = tuple(shapes["view_maps"][1:])
        self._embedding_length: int = shapes["codes"][1]

    def encode_target(self, target_maps: NDArray[np.floating]) -> NDArray[np.float32]:
        """What to look for, from a target picture; needed once a search.

        Args:
            target_maps: (N, C, h, w) feature maps of target pictures.

        Returns:
            (N, D) float32 codes.

        Raises:
            RecogniserError: if the maps have the wrong shape or are not finite.
        """
        target_maps = self._checked(target_maps)
        if not len(target_maps):
            return np.empty((0, self._embedding_length), np.float32)
        # The graph holds both ways through it, and ONNX Runtime runs all of it: one blank view and code go along.
        blank_view, blank_embedding = np.zeros((1, *self.map_shape)), np.zeros((1, self._embedding_length))
        embeddings = self._run(["target_codes"], blank_view, blank_embedding, target_maps)[0]
        if not np.isfinite(embeddings).all():
            raise RecogniserError("the feature maps of the target picture hold numbers that are not finite")
        return embeddings

    def detect(
        self, view_maps: NDArray[np.floating], embedding: NDArray[np.float32]
    ) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
        """Look for one target in views.

        Args:
            view_maps: (N, C, h, w) feature maps.
            embedding: (D,) or (1, D) float32, from `encode_target`.

        Returns:
            (N,) float32 presence probabilities and (N, 4) float32 boxes (centre x, centre y, width, height as
            fractions of the image); a box means something where the probability is high.

        Raises:
            RecogniserError: if an array has the wrong shape or is not finite.
        """
        scores, boxes = self.detect_many(view_maps, np.reshape(embedding, (1, -1)))
        return scores[:, 0], boxes[:, 0]

    def detect_many(
        self, view_maps: NDArray[np.floating], embeddings: NDArray[np.float32]
    ) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
        """Look for M targets in N views; what depends on the view alone is computed once.

        Args:
            view_maps: (N, C, h, w) feature maps.
            embeddings: (M, D) float32, from `encode_target`.

        Returns:
            (N, M) float32 presence probabilities and (N, M, 4) float32 boxes, see `detect`.

        Raises:
            RecogniserError: if an array has the wrong shape or is not finite.
        """
        if embeddings.ndim != 2 or embeddings.shape[1] != self._embedding_length:
            raise RecogniserError(
                f"target embeddings have shape {embeddings.shape}, expected (N, {self._embedding_length}); make them "
                "anew with this recogniser's encode_target"
            )
        view_maps = self._checked(view_maps)
        if not len(view_maps) or not len(embeddings):
            nothing = np.empty((len(view_maps), len(embeddings), 4), np.float32)
            return nothing[..., 0], nothing
        no_target = np.empty((0, *self.map_shape))
        logits, boxes = self._run(["logits", "boxes"], view_maps, embeddings, no_target)
        if not np.isfinite(logits).all():
            raise RecogniserError("the feature maps of the view, or the target's code, are not finite numbers")
        return (0.5 + 0.5 * np.tanh(0.5 * logits)).astype(np.float32), boxes

    def _checked(self, maps: NDArray[np.floating]) -> NDArray[np.floating]:
        if maps.ndim != 4 or maps.shape[1:] != self.map_shape:
            raise RecogniserError(
                f"feature maps have shape {maps.shape}, not (N, *{self.map_shape}): use the backbone "
                "and the image size that it was trained with"
            )
        return maps

    def _run(
        self,
        outputs: list[str],
        view_maps: NDArray[np.floating],
        embeddings: NDArray[np.floating],
        target_maps: NDArray[np.floating],
    ) -> list[NDArray[np.float32]]:
        inputs = {"view_maps": view_maps, "codes": embeddings, "target_maps": target_maps}
        contiguous = {name: np.ascontiguousarray(array, np.float32) for name, array in inputs.items()}
        return self._session.run(outputs, contiguous)


def detect_table(
    recogniser: Recogniser,
    features: SceneFeatures,
    targets: NDArray[np.integer] | None = None,
    progress: ProgressCallback | None = None,
) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
    """Look for targets of a scene in all its views, asked for with each of their pictures.

    Args:
        recogniser: of any kind.
        features: of a scene with S views.
        targets: indices of the T targets to look for; None for all of the scene's.
        progress: called with the number of views done and of all.

    Returns:
        (S, T, K) float32 presence probabilities and (S, T, K, 4) float32 boxes, see `Recogniser.detect`.

    Raises:
        RecogniserError: if the recogniser was trained on maps of another shape.
    """
    target_maps = features.target_maps if targets is None else features.target_maps[targets]
    count, pictures = target_maps.shape[:2]
    views = len(features.view_maps)
    embeddings = [recogniser.encode_target(maps) for maps in target_maps]
    flat = np.concatenate(embeddings) if embeddings else np.empty((0, 1), np.float32)
    scores = np.empty((views, len(flat)), np.float32)
    boxes = np.empty((views, len(flat), 4), np.float32)
    chunk = max(1, PAIRS // max(1, len(flat)))
    for start in range(0, views if len(flat) else 0, chunk):
        rows = slice(start, start + chunk)
        scores[rows], boxes[rows] = recogniser.detect_many(features.view_maps[rows], flat)
        if progress is not None:
            progress(min(start + chunk, views), views)
    return scores.reshape(views, count, pictures), boxes.reshape(views, count, pictures, 4)
