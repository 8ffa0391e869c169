"""What a search remembers of its looks: whether it has seen the present view before."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from active_perceiver.agent.exploration import ViewMap
from active_perceiver.utils.linalg import unit_vectors

ALIKE = 0.999
"""Cosine similarity of pooled features from which on two views count as the same; about one view in a hundred of the
bundled kitchen has another one that is so like it."""

_FIRST_ROWS = 16


@dataclass(frozen=True, eq=False)
class ViewFeatures:
    """What an agent knows a view by.

    Attributes:
        features: (D,) float32, the backbone's pooled ones, as the policy is shown them.
        descriptor: (D,) float32, the same as a unit vector.
        likeness: (S,) cosine similarity to the view of each state of the room that the agent remembers; None if it
            remembers none.
    """

    features: NDArray[np.float32]
    descriptor: NDArray[np.float32]
    likeness: NDArray[np.float32] | None = None

    @classmethod
    def of(cls, features: NDArray[np.float32], room: ViewMap | None = None) -> ViewFeatures:
        """Describe one view by its (D,) features."""
        descriptor = unit_vectors(features)
        return cls(features, descriptor, None if room is None else room.descriptors @ descriptor)

    @classmethod
    def of_scene(cls, features: NDArray[np.float32], room: ViewMap | None = None) -> tuple[ViewFeatures, ...]:
        """Describe many views at once by their (N, D) features."""
        descriptors = unit_vectors(features)
        if room is None:
            return tuple(map(cls, features, descriptors))
        return tuple(map(cls, features, descriptors, descriptors @ room.descriptors.T))

    @cached_property
    def state(self) -> int:
        """The state of the room that it is most like; -1 without a room."""
        return -1 if self.likeness is None else int(self.likeness.argmax())


@dataclass(frozen=True)
class Visit:
    """What the memory says of a look.

    Attributes:
        earlier: how often the search has looked at the same view before.
        view_changed: whether the look before was at another view; False at the first look.
    """

    earlier: int
    view_changed: bool


class VisitMemory:
    """The looks of one search.

    Two looks are at the same view if their descriptors are `ALIKE`, or if both are most like the same state of the
    room: a robot that is a little off the lattice never sees quite the same again. Of the last look the robot itself
    knows better, if it says whether it has moved since.

    Looks with the very same descriptor are kept once. A look costs one product of a vector with all that are kept:
    among five hundred, a fiftieth of what the backbone takes.
    """

    def __init__(self) -> None:
        self._descriptors = np.empty((0, 0), np.float32)
        self._states = np.empty(0, np.int64)
        self._looks = np.empty(0, np.int64)
        self._rows: dict[bytes, int] = {}
        self._last = -1

    def visit(self, view: ViewFeatures, robot_moved: bool | None = None) -> Visit:
        """Note a look.

        Args:
            view: what is seen.
            robot_moved: whether the robot has moved since the last look; None to tell by the views.
        """
        if self._last < 0:
            self._note(view)
            return Visit(0, view_changed=False)
        kept = len(self._rows)
        same = self._descriptors[:kept] @ view.descriptor > ALIKE
        if view.state >= 0:
            same |= self._states[:kept] == view.state
        earlier, alike = int(self._looks[:kept] @ same), bool(same[self._last])
        unchanged = alike if robot_moved is None else not robot_moved
        self._note(view)
        return Visit(earlier - alike + unchanged, view_changed=not unchanged)

    def _note(self, view: ViewFeatures) -> None:
        self._last = self._rows.setdefault(view.descriptor.tobytes(), len(self._rows))
        if self._last == len(self._looks):
            self._grow(len(view.descriptor))
        self._descriptors[self._last], self._states[self._last] = view.descriptor, view.state
        self._looks[self._last] += 1

    def _grow(self, channels: int) -> None:
        """Make room for as many rows again, that are all zero."""
        rows = max(_FIRST_ROWS, len(self._looks))
        empty = np.zeros((rows, channels), np.float32)
        self._descriptors = np.concatenate([self._descriptors, empty]) if len(self._looks) else empty
        self._states, self._looks = (
            np.concatenate([numbers, np.zeros(rows, np.int64)]) for numbers in (self._states, self._looks)
        )
