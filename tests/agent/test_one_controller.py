"""The live search and the tables of evaluation take the same way: state for state, action for action, same ending.

The scene is a lattice with walls; networks are stood in for by functions that give a single image the very numbers
that the tables hold, so that nothing but what is decided can differ.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path

import numpy as np
import pytest

from active_perceiver.agent.config import AgentConfig
from active_perceiver.agent.exploration import Explorer, ViewMap
from active_perceiver.agent.found_criterion import FoundCriterion
from active_perceiver.agent.goals import ObjectGoal, observe_goal
from active_perceiver.agent.perceiver import ActivePerceiver
from active_perceiver.agent.visit_memory import ViewFeatures
from active_perceiver.evaluation import stop_evaluation
from active_perceiver.live import SearchConfig, search
from active_perceiver.robots import RecordedRobot
from active_perceiver.scenes import Scene
from active_perceiver.vision.location import location_mask

STARTS = 200
LIMIT = 40
CHANNELS = 24
CRITERION = FoundCriterion(score=0.7, area=0.04)
SEEN = 0.5


@dataclass(frozen=True, eq=False)
class Place:
    """A scene with walls in it, and all that networks might make of it.

    Attributes:
        scene: with more blocked moves than its room map knows of.
        room: as the agent remembers it.
        features: (S, D) of the views; some are alike.
        scores: (S,) of the target.
        boxes: (S, 4) of the target.
        weights: (D + 25, A) of the policy.
    """

    scene: Scene
    room: ViewMap
    features: np.ndarray
    scores: np.ndarray
    boxes: np.ndarray
    weights: np.ndarray

    @cached_property
    def goal_observations(self):
        """What is seen of the target in each state."""
        return [observe_goal(float(s), b, SEEN, CRITERION) for s, b in zip(self.scores, self.boxes, strict=True)]

    def probabilities(self, view, target, mask, branch):
        """A policy that is sure of itself, and so often leads in circles; each row by itself, to the last bit."""
        shown = np.concatenate([view, mask], axis=1)
        logits = 2 * (shown[:, :, None] * self.weights).sum(axis=1)
        raw = np.exp(logits - logits.max(axis=1, keepdims=True))
        return (raw / raw.sum(axis=1, keepdims=True)).astype(np.float32)


@pytest.fixture(scope="module")
def place(scene: Scene) -> Place:
    rng = np.random.default_rng(3)
    states, actions = scene.transitions.shape
    walls = rng.random(scene.transitions.shape) < 0.2
    transitions = np.where(walls, np.arange(states, dtype=np.int32)[:, None], scene.transitions)
    features = rng.normal(size=(states, CHANNELS)).astype(np.float32)
    alike = rng.choice(states, (10, 2), replace=False)
    features[alike[:, 0]] = features[alike[:, 1]] + 0.01 * features[alike[:, 0]]
    visible = scene.areas[:, 0] > 0
    return Place(
        scene=replace(scene, transitions=transitions),
        room=ViewMap.of(scene, features),
        features=features,
        scores=np.where(rng.random(states) < 0.9, visible, ~visible) * rng.uniform(0.5, 1.0, states),
        boxes=np.where(visible[:, None], np.nan_to_num(scene.boxes[:, 0]), rng.uniform(0.2, 0.4, (states, 4))),
        weights=rng.normal(size=(CHANNELS + 25, actions)),
    )


class NumberedRobot(RecordedRobot):
    """Its camera shows the number of the state, and it notes what it did."""

    def __init__(self, scene: Scene, start: int) -> None:
        super().__init__(scene, start)
        self.states, self.done = [start], []

    def look(self):
        return np.array([[[self.state // 256, self.state % 256, 0]]], np.uint8)

    def execute(self, action):
        moved = super().execute(action)
        self.states.append(self.state)
        self.done.append(self.actions.index(action))
        return moved


class StandIn:
    """Backbone, recogniser, goal detector and policy of a place, in which the maps of an image are its features."""

    image_size = 1

    def __init__(self, place: Place) -> None:
        self.place = place

    def maps(self, images):
        states = [256 * int(image[0, 0, 0]) + int(image[0, 0, 1]) for image in images]
        return self.place.features[states][:, :, None, None]

    def detect(self, maps, embedding):
        (state,) = np.flatnonzero((self.place.features == maps[0, :, 0, 0]).all(axis=1))
        return self.place.scores[[state]], self.place.boxes[[state]]

    def begin(self, maps, branch):
        embedding = np.zeros((1, 1), np.float32)
        return ObjectGoal(self, embedding, maps[:, :, 0, 0], SEEN, CRITERION)

    def probabilities(self, *shown):
        return self.place.probabilities(*shown)


class StandInAgent(ActivePerceiver):
    """An agent with a stand-in for all that it would load."""

    def __init__(self, place: Place, *, confirm: bool, explore: bool) -> None:
        self.folder = Path("nowhere")
        self.config = AgentConfig(
            backbone="stand-in",
            image_size=1,
            recogniser="matching",
            score_threshold=SEEN,
            branches={place.scene.name: [action.value for action in place.scene.actions]},
            targets=[],
            stop_area_threshold=CRITERION.area,
            match_threshold=1.0,
        )
        self.confirm = confirm
        self.explore = explore
        self.backbone = self.goal_detector = self.policy = StandIn(place)
        self._place = place
        self._search = None

    def room(self, branch):
        return self._place.room if self.explore else None


def search_tables(place: Place, *, confirm: bool, explore: bool) -> stop_evaluation.SearchTables:
    masks = location_mask(np.where((place.scores >= SEEN)[:, None], place.boxes, np.nan))
    return stop_evaluation.SearchTables(
        scene=place.scene.name,
        target="ball0",
        probabilities=place.probabilities(place.features, None, masks, "")[:, None],
        goal_observations=lambda state, picture: place.goal_observations[state],
        views=ViewFeatures.of_scene(place.features, place.room if explore else None),
        right=np.ones((len(place.scene), 1), bool),
        transitions=place.scene.transitions,
        steps=np.ones(len(place.scene), np.int64),
        confirm=confirm,
        explorer=(lambda picture: Explorer(place.room, CRITERION.area, SEEN)) if explore else None,
    )


@pytest.mark.parametrize("confirm", [False, True])
@pytest.mark.parametrize("explore", [False, True])
def test_live_and_in_tables_a_search_is_the_same(place, monkeypatch, confirm, explore):
    monkeypatch.setattr(stop_evaluation, "LIMIT", LIMIT)
    agent = StandInAgent(place, confirm=confirm, explore=explore)
    tables = search_tables(place, confirm=confirm, explore=explore)
    starts = np.random.default_rng(0).integers(len(place.scene), size=STARTS)
    found, blocked, lengths = 0, 0, []
    for seed, start in enumerate(starts.tolist()):
        robot = NumberedRobot(place.scene, start)
        record = search(agent, robot, robot.look(), SearchConfig(max_steps=LIMIT, seed=seed))
        ours = stop_evaluation.search_once(tables, start, 0, seed)
        assert ours == stop_evaluation.TableSearch(tuple(robot.states), tuple(robot.done), record.found)
        found += record.found
        blocked += sum(step_record.robot_moved is False for step_record in record.step_records)
        lengths.append(record.actions)
    # The searches are of all kinds: found and given up, short and long, with bumps.
    assert found > 20
    assert blocked > 100
    assert max(lengths) > 30


def test_one_agent_serves_many_searches(place):
    """Searches that take turns go as each would alone."""
    agent = StandInAgent(place, confirm=False, explore=True)
    starts, looks = (5, 90, 140), 25

    def run(searches):
        robots = [NumberedRobot(place.scene, start) for start in starts]
        moved: list[bool | None] = [None] * len(starts)
        for index in [*range(len(starts))] * looks if searches is None else searches:
            step = begun[index].act(robots[index].look(), moved[index])
            moved[index] = robots[index].execute(step.action)
        return [robot.states for robot in robots]

    picture = NumberedRobot(place.scene, 0).look()
    begun = [agent.search(picture, seed=seed) for seed in range(len(starts))]
    in_turns = run(None)
    begun = [agent.search(picture, seed=seed) for seed in range(len(starts))]
    assert run(np.repeat(range(len(starts)), looks)) == in_turns
