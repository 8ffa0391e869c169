"""Looking for a target that is not where it was: over the room, and then as near to it as one gets.

A policy leads to where a target was when it was trained. If the target has been moved since, an agent that knew no
more would stay there. It remembers the room (see `ViewMap`), so it can go round it: always on to where it is likely
to see much that is new for few actions. Boxes that the recogniser draws on the way are rays; where they meet, the
target is. Then it goes to where the target should look largest, until no place promises more than the best one it
has seen. This is not in the paper, whose targets stay where they are.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from active_perceiver.agent.exploration.localization import BayesFilter
from active_perceiver.agent.exploration.triangulation import Estimate, Sighting, estimates, expected_areas
from active_perceiver.agent.exploration.view_map import ViewMap
from active_perceiver.recognition.recogniser import Detection
from active_perceiver.scenes.lattice import UNREACHABLE

HEAD_START = 5
"""Actions added to the way when what is new at its end is weighed against its length."""
WORTH_A_LOOK = 0.8
"""A place is worth going to if the box there should be so much of the largest one so far: where exactly the target is
shows only when it was seen from near by."""
SURE = 0.97
"""How sure it has to be at first that what it sees is the target."""
PATIENCE = 120
"""Actions after which it takes what it has seen, were it only just enough to be seen at all."""


class Explorer:
    """Keeps track of one search in a known room.

    Call `update` for every view, and `notify_action` for every action that is carried out, whoever chose it. When the
    search is lost, `action` says where to go, and `settled` when to stop.

    Args:
        room: where it searches.
        enough: area from which on a box is large enough, as a fraction of the image.
        threshold: presence probability from which on the target counts as seen.
    """

    def __init__(self, room: ViewMap, enough: float, threshold: float) -> None:
        states = len(room.descriptors)
        self._room = room
        self._enough = enough
        self._threshold = threshold
        self._ways = room.shortest_paths
        self._places = np.unique(room.poses[:, :2].round(2), axis=0, return_inverse=True)[1].ravel()
        self._known = np.zeros(states)  # how alike each state's view is to the most similar one that was looked at
        self._looked = np.zeros(states, bool)
        self._sightings: dict[int, Sighting] = {}
        self._estimates: list[Estimate] | None = []
        self._bayes_filter = BayesFilter(states)
        self._state = -1
        self._action: int | None = None
        self._goal: int | None = None
        self._explored = 0

    def update(
        self, likeness: NDArray[np.floating], detection: Detection | None, robot_moved: bool | None = None
    ) -> None:
        """Take in a view.

        Args:
            likeness: (S,) cosine similarity of the view's pooled features to those of each state of the room.
            detection: where the target is seen, None if it is not.
            robot_moved: whether the last action moved the robot, if it says so; else the view tells.
        """
        state = self._bayes_filter.update(likeness, self._ways.transitions, self._action, robot_moved)
        if self._action is not None and state == self._state and not robot_moved:
            self._ways = self._ways.without(state, self._action)  # blocked, whatever the map says
        self._state, self._action = state, None
        self._known = np.maximum(self._known, likeness)
        self._looked[state] = True
        if detection is not None and state not in self._sightings:
            self._sightings[state] = Sighting(state, detection.box, detection.score)
            self._estimates = None

    def notify_action(self, action: int) -> None:
        """Note the action that is carried out next."""
        self._action = action

    def follows(self) -> bool:
        """Whether it knows where to go because of what it has seen."""
        return self._place_to_look_at_it() is not None

    def settled(self) -> bool:
        """Whether the agent is at the best place it knows to look at the target, and no other promises more."""
        return self._place_to_look_at_it() == self._state

    def action(self) -> int:
        """Where to go on, as the index of an action."""
        self._explored += 1
        goal = self._place_to_look_at_it()
        if goal is None:
            goal = self._something_new()
        steps, leads = self._ways.to(goal), self._ways.transitions[self._state]
        if steps[self._state] == UNREACHABLE:
            self._looked[goal], self._known[goal] = True, 1.0
            return int((leads != self._state).argmax())
        return int((steps[leads] == steps[self._state] - 1).argmax())

    def _place_to_look_at_it(self) -> int | None:
        """Where to go because of what was seen; None if that is not convincing, or not yet."""
        poses, fov = self._room.poses, self._room.fov
        if self._estimates is None:
            found = estimates(list(self._sightings.values()), poses, fov)
            self._estimates = sorted(found, key=lambda one: -one.confidence)
        sure = self._threshold + (SURE - self._threshold) * max(0.0, 1.0 - self._explored / PATIENCE)
        for one in self._estimates:
            if one.confidence < sure:
                return None
            best = one.best
            if best.area < self._enough:
                promised = np.where(self._looked, 0.0, expected_areas(one, poses, fov))
                if promised.max() > WORTH_A_LOOK * best.area:
                    return int(promised.argmax())
            if len({self._places[sighting.state] for sighting in one.sightings}) > 1:
                return best.state
        return None

    def _something_new(self) -> int:
        """The state whose view promises most that is new, for the way there; the same until it was looked at."""
        if self._goal is not None and not self._looked[self._goal]:
            return self._goal
        steps = self._ways.away(self._state)
        promised = np.where(steps == UNREACHABLE, 0.0, (1.0 - self._known) / (steps + HEAD_START))
        self._goal = int((promised - self._looked).argmax())
        return self._goal
