"""Which views a search has seen before, against all of them looked up one by one."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from active_perceiver.agent.exploration import ViewMap
from active_perceiver.agent.visit_memory import ALIKE, ViewFeatures, Visit, VisitMemory


def places(channels: int = 8) -> list[np.ndarray]:
    """Features of six views: unlike each other, but the last one, that is nearly the first."""
    features = list(np.eye(channels, dtype=np.float32)[:5] * 3)
    return [*features, features[0] + 0.02 * features[1]]


@pytest.fixture(scope="module")
def room(scene) -> ViewMap:
    return ViewMap.of(scene, np.random.default_rng(0).normal(size=(len(scene), 8)))


def slow_visits(views, moves):
    """Every look compared to every earlier one."""
    for number, (view, moved) in enumerate(zip(views, moves, strict=True)):
        same = [float(earlier.descriptor @ view.descriptor) > ALIKE for earlier in views[:number]]
        if view.state >= 0:
            same = [one or earlier.state == view.state for one, earlier in zip(same, views, strict=False)]
        if same and moved is not None:
            same[-1] = not moved
        yield Visit(sum(same), view_changed=bool(same) and not same[-1])


@given(
    looks=st.lists(st.tuples(st.integers(0, 5), st.sampled_from([None, True, False])), max_size=60),
    with_room=st.booleans(),
)
def test_it_counts_as_a_list_of_all_looks_does(room, looks, with_room):
    known = ViewFeatures.of_scene(np.array(places()), room if with_room else None)
    views, moves = [known[place] for place, _ in looks], [moved for _, moved in looks]
    memory = VisitMemory()
    assert [memory.visit(*look) for look in zip(views, moves, strict=True)] == list(slow_visits(views, moves))


def test_many_different_views_are_all_remembered():
    memory = VisitMemory()
    views = ViewFeatures.of_scene(np.eye(100, dtype=np.float32))
    for expected in range(2):
        assert [memory.visit(view).earlier for view in views] == [expected] * 100


def test_one_view_is_described_as_among_many(room):
    features = np.array(places())
    for one, many in zip(features, ViewFeatures.of_scene(features, room), strict=True):
        alone = ViewFeatures.of(one, room)
        np.testing.assert_allclose(alone.descriptor, many.descriptor)
        np.testing.assert_allclose(alone.likeness, many.likeness, atol=1e-6)
        assert alone.state == many.state
    assert ViewFeatures.of(features[0]).state == -1
