"""Which pairs of a view and a target picture a recogniser learns from, and which it is judged by."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from active_perceiver.recognition.recogniser import RecogniserError
from active_perceiver.scenes.box_labels import labelled_views
from active_perceiver.scenes.scene import Scene

PRESENT, ABSENT, IGNORE_INDEX = 1, 0, -1


@dataclass(frozen=True, eq=False)
class Annotations:
    """Everything that is known about the views and targets of some scenes, one after the other.

    Attributes:
        boxes: (V, T, 4) float32 true boxes; zeros where the target is not visible.
        states: (V, T) int8: PRESENT, ABSENT, or IGNORE_INDEX, that is too small to tell, of another scene, or in a
            view that nobody has labelled.
        names: (T,) "scene/target".
        pictures: (T,) number of pictures of each target.
        held_out: (T,) how many of them, the last ones, are never trained with.
        places: (V,) int64, the same for views taken at the same place of the same scene.
        smallest_area: what is visible but covers less of the image is too small to tell.
    """

    boxes: NDArray[np.float32]
    states: NDArray[np.int8]
    names: NDArray[np.str_]
    pictures: NDArray[np.int64]
    held_out: NDArray[np.int64]
    places: NDArray[np.int64]
    smallest_area: float

    @classmethod
    def of(cls, scenes: Sequence[Scene], smallest_area: float) -> Annotations:
        """Collect them; visible objects that cover less than `smallest_area` of the image are not judged."""
        views = np.cumsum([0] + [len(scene) for scene in scenes])
        targets = np.cumsum([0] + [len(scene.targets) for scene in scenes])
        boxes = np.zeros((views[-1], targets[-1], 4), np.float32)
        states = np.full((views[-1], targets[-1]), IGNORE_INDEX, np.int8)
        places = np.empty(views[-1], np.int64)
        before = 0
        for number, scene in enumerate(scenes):
            rows, columns = slice(views[number], views[number + 1]), slice(targets[number], targets[number + 1])
            boxes[rows, columns] = np.nan_to_num(scene.boxes)
            visible = ~np.isnan(scene.boxes[..., 0])
            states[rows, columns] = np.where(
                visible, np.where(scene.areas >= smallest_area, PRESENT, IGNORE_INDEX), ABSENT
            )
            states[rows][~labelled_views(scene)] = IGNORE_INDEX
            places[rows] = before + scene.positions
            before += int(scene.positions.max(initial=-1)) + 1
        names = [f"{scene.name}/{target.name}" for scene in scenes for target in scene.targets]
        pictures = [(len(target.pictures), target.held_out) for scene in scenes for target in scene.targets]
        count, held_out = np.array(pictures, np.int64).reshape(-1, 2).T
        return cls(boxes, states, np.array(names, np.str_), count, held_out, places, smallest_area)


@dataclass(frozen=True, eq=False)
class Split:
    """What is kept out of training.

    Attributes:
        views: (V,) bool, held out; all views of a place are on one side.
        targets: (T,) bool, held out altogether.
        seen_pictures: (T,) int64: pictures 0 .. n - 1 are trained with, the rest are held out.
    """

    views: NDArray[np.bool_]
    targets: NDArray[np.bool_]
    seen_pictures: NDArray[np.int64]

    @classmethod
    def of(cls, data: Annotations, places: float, targets: Sequence[str], rng: np.random.Generator) -> Split:
        """Hold out a fraction of the places, drawn at random; for the rest see `holding_out`.

        Places where nothing can be judged do not count. Where there are two others or more, one at least is held out
        and one kept.
        """
        known = np.unique(data.places[(data.states != IGNORE_INDEX).any(axis=1)])
        count = max(min(max(round(places * len(known)), int(places > 0)), len(known) - 1), 0)
        return cls.holding_out(data, np.isin(data.places, rng.permutation(known)[:count]), targets)

    @classmethod
    def holding_out(cls, data: Annotations, views: NDArray[np.bool_], targets: Sequence[str]) -> Split:
        """Hold out given views, (V,) bool, the pictures that the scenes say, and some targets by name.

        Raises:
            RecogniserError: if there is no target of one of the names, some views of a place are held out and others
                not, or all views are.
        """
        if np.intersect1d(data.places[views], data.places[~views]).size:
            raise RecogniserError("of some places only a part of the views is held out; hold out all of them or none")
        if views.all():
            raise RecogniserError("all views are held out; leave some places to train on")
        short_names = [name.split("/")[-1] for name in data.names]
        if unknown := [name for name in targets if name not in short_names]:
            raise RecogniserError(f"there are no targets {unknown} to hold out; there are {sorted(set(short_names))}")
        return cls(
            views=views,
            targets=np.isin(short_names, targets),
            seen_pictures=data.pictures - data.held_out,
        )


@dataclass(frozen=True, eq=False)
class Batch:
    """N views, each asked for M targets.

    Attributes:
        views: (N,) int64.
        targets: (N, M) int64.
        pictures: (N, M) int64, which picture each target is asked for with.
        states: (N, M) int8.
        boxes: (N, M, 4) float32.
    """

    views: NDArray[np.int64]
    targets: NDArray[np.int64]
    pictures: NDArray[np.int64]
    states: NDArray[np.int8]
    boxes: NDArray[np.float32]


class PairSampler:
    """Draws batches that are balanced over targets and over presence.

    A view is drawn for one target, in which it is present with probability `present`; the other targets asked for in
    the same view are mostly absent while something else is there: the hard cases of "no".

    Args:
        data: what is known.
        split: what is held out.
        present: how often the target that a view is drawn for is in it, 0..1.
        rng: draws.
        further: (T,) number of further pictures of each target, which come after the most pictures that any has.
        own_pictures: how often a target is asked for with one of its own pictures if it has further ones, 0..1.

    Raises:
        RecogniserError: if no target is visible in any training view.
    """

    def __init__(
        self,
        data: Annotations,
        split: Split,
        present: float,
        rng: np.random.Generator,
        further: NDArray[np.int64] | None = None,
        own_pictures: float = 1.0,
    ) -> None:
        self._data, self._split, self._present, self._rng = data, split, present, rng
        self._further = np.zeros(len(data.names), np.int64) if further is None else further
        self._own_pictures = own_pictures
        self._learned = ~split.targets
        states = np.where(split.views[:, None] | split.targets, IGNORE_INDEX, data.states)
        self._with = [np.flatnonzero(column == PRESENT) for column in states.T]
        self._without = [np.flatnonzero(column == ABSENT) for column in states.T]
        self._leads = np.flatnonzero([len(views) > 0 for views in self._with])
        if len(self._leads) == 0:
            raise RecogniserError(
                "no target is large enough in any view to learn from; is it annotated, and is `smallest_area` right?"
            )

    def draw(self, views: int, targets: int) -> Batch:
        """A batch of `views` views with `targets` targets each, or as many as there are."""
        rng = self._rng
        leads = rng.choice(self._leads, views)
        rows = np.array([self._view_for(lead, rng.random() < self._present) for lead in leads])
        order = rng.random((views, len(self._learned)))
        order[~self._learned[None] | (self._data.states[rows] == IGNORE_INDEX)] += 1.0  # as a last resort
        order[np.arange(views), leads] = -1.0
        asked = np.argsort(order, axis=1)[:, :targets]
        states = np.where(self._learned[asked], self._data.states[rows[:, None], asked], IGNORE_INDEX)
        boxes = self._data.boxes[rows[:, None], asked]
        return Batch(rows, asked, self._pictures_of(asked), states.astype(np.int8), boxes)

    def _pictures_of(self, targets: NDArray[np.int64]) -> NDArray[np.int64]:
        """A picture of each target, its own or a further one."""
        further = self._further[targets]
        own = (further == 0) | (self._rng.random(targets.shape) < self._own_pictures)
        count = np.where(own, self._split.seen_pictures[targets], further)
        return np.where(own, 0, self._data.pictures.max()) + (self._rng.random(targets.shape) * count).astype(
            np.int64
        )

    def _view_for(self, target: int, present: bool) -> int:
        views = self._with[target] if present or not len(self._without[target]) else self._without[target]
        return int(self._rng.choice(views))
