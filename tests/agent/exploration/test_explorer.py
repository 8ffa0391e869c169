"""Going round a known room: what is not where it was is found, what is not there is looked for everywhere."""

import numpy as np
import pytest

from active_perceiver.agent.config import AgentError
from active_perceiver.agent.exploration import Explorer, ViewMap, map_file
from active_perceiver.recognition.recogniser import Detection

THRESHOLD = 0.5


@pytest.fixture(scope="module")
def room(scene) -> ViewMap:
    """The small scene, every view unlike all others."""
    return ViewMap.of(scene, np.random.default_rng(0).normal(size=(len(scene), 64)))


def walk(room, scene, start, detection, limit=600, transitions=None):
    """Explore from a state on; the states looked at, and whether it settled at the last one."""
    transitions = scene.transitions if transitions is None else transitions
    explorer, state, path = Explorer(room, 1.0, THRESHOLD), start, []
    for _ in range(limit):
        path.append(state)
        explorer.update(room.descriptors @ room.descriptors[state], detection(state))
        if explorer.settled():
            return path, True
        action = explorer.action()
        explorer.notify_action(action)
        state = int(transitions[state, action])
    return path, False


def sees(scene, target):
    def detection(state):
        box = scene.boxes[state, target]
        return None if np.isnan(box).any() else Detection(0.99, box)

    return detection


@pytest.mark.parametrize("target", range(3))
def test_it_comes_close_to_whatever_is_there_from_everywhere(room, scene, target):
    largest, ends = scene.areas[:, target].max(), []
    for start in range(0, len(scene), 29):
        path, settled = walk(room, scene, start, sees(scene, target))
        assert settled
        assert len(path) < 120
        ends.append(scene.areas[path[-1], target] / largest)
    assert min(ends) > 0.2
    assert np.median(ends) > 0.5


def test_what_is_not_there_is_looked_for_everywhere(room, scene):
    path, settled = walk(room, scene, 0, lambda state: None, limit=1500)
    assert not settled
    assert len(set(path)) > 0.95 * len(scene)


def test_a_box_in_one_view_only_is_not_believed(room, scene):
    def detection(state):
        return Detection(1.0, np.array([0.5, 0.5, 0.2, 0.2])) if state == 40 else None

    _, settled = walk(room, scene, 40, detection)
    assert not settled


def test_little_certainty_is_only_enough_after_a_while(room, scene):
    def unsure(state):
        seen = sees(scene, 0)(state)
        return None if seen is None else Detection(0.6, seen.box)

    start = int(np.argmax(scene.areas[:, 0]))
    sure_path, sure = walk(room, scene, start, sees(scene, 0))
    unsure_path, settled = walk(room, scene, start, unsure)
    assert sure
    assert settled
    assert len(unsure_path) > len(sure_path) + 50


def test_it_learns_what_the_map_does_not_say(room, scene):
    """Half of the moves are blocked now; it goes round and still gets there."""
    transitions = scene.transitions.copy()
    rng = np.random.default_rng(3)
    moves = [column for column, action in enumerate(scene.actions) if action.value.startswith("Move")]
    for column in moves:
        blocked = rng.random(len(scene)) < 0.3
        transitions[blocked, column] = np.flatnonzero(blocked)
    found = [
        walk(room, scene, start, sees(scene, 1), transitions=transitions)[1] for start in range(0, len(scene), 37)
    ]
    assert np.mean(found) > 0.8


def test_a_place_that_cannot_be_reached_does_not_stop_it(room, scene):
    transitions = scene.transitions
    own = np.broadcast_to(np.arange(len(scene))[:, None], transitions.shape)
    transitions = np.where((own < 60) | (transitions < 60), own, transitions).astype(np.int32)
    cut_off = ViewMap(room.descriptors, room.poses, transitions, room.fov)
    path, settled = walk(cut_off, scene, 100, lambda state: None, limit=900, transitions=transitions)
    assert not settled
    assert len(set(path)) == len(scene) - 60


def test_a_map_survives_its_file(room, tmp_path):
    path = map_file(tmp_path, "toy")
    room.save(path)
    room.save(path)  # a training that goes on writes it again
    read = ViewMap.load(path)
    np.testing.assert_allclose(read.descriptors, room.descriptors, atol=1e-3)
    np.testing.assert_array_equal(read.transitions, room.transitions)
    np.testing.assert_array_equal(read.poses, room.poses)
    assert read.fov == room.fov


@pytest.mark.parametrize("data", [b"", b"no archive", None])
def test_a_damaged_map_says_so(room, tmp_path, data):
    path = tmp_path / "toy.npz"
    room.save(path)
    path.write_bytes(path.read_bytes()[:200] if data is None else data)
    with pytest.raises(AgentError, match=r"toy\.npz"):
        ViewMap.load(path)


@pytest.mark.parametrize(
    "change",
    [
        {"poses": np.zeros((3, 4), np.float32)},
        {"descriptors": np.full((192, 64), np.nan, np.float32)},
        {"transitions": np.full((192, 8), 192, np.int32)},
        {"fov": 0.0},
    ],
)
def test_a_senseless_map_is_refused(room, change):
    fields = {"descriptors": room.descriptors, "poses": room.poses, "transitions": room.transitions, "fov": room.fov}
    with pytest.raises(AgentError):
        ViewMap(**{**fields, **change})


def drift(room, rng, state):
    """A view from near a state: like it, and like others."""
    descriptor = room.descriptors[state] + 0.5 * room.descriptors[rng.integers(len(room.descriptors))]
    return room.descriptors @ (descriptor / np.linalg.norm(descriptor))


def test_a_robot_that_says_that_it_did_not_move_is_where_it_was(room, scene):
    explorer = Explorer(room, 1.0, THRESHOLD)
    explorer.update(room.descriptors @ room.descriptors[7], None)
    action = explorer.action()
    explorer.notify_action(action)
    explorer.update(drift(room, np.random.default_rng(1), 7), None, robot_moved=False)
    assert explorer._state == 7
    assert explorer._ways.transitions[7, action] == 7
    assert room.shortest_paths.transitions[7, action] != 7  # other searches know nothing of it
    assert explorer.action() != action
