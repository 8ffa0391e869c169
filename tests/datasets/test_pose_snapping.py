"""Imprecise poses come back to the lattice they were meant to lie on; what cannot be one is refused."""

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from active_perceiver.datasets.moves import lattice_actions, one_way_moves, snapped_transitions
from active_perceiver.datasets.photos.lattice_fit import fit_headings, fit_tilts
from active_perceiver.datasets.photos.pose_snapping import LatticeConfig, snap_poses
from active_perceiver.datasets.photos.pose_table import PoseTable
from active_perceiver.scenes import EIGHT_ACTIONS, SceneError
from active_perceiver.scenes.lattice import Action, lattice_poses, lattice_transitions


def table_of(poses) -> PoseTable:
    names = tuple(f"{index}.jpg" for index in range(len(poses)))
    return PoseTable(Path("poses.csv"), names, tuple(range(2, len(poses) + 2)), np.asarray(poses, float))


def grid(columns, rows, spacing, step=90.0, tilts=(-25.0, 0.0), corner=(0.0, 0.0)):
    places = np.stack(np.meshgrid(np.arange(columns), np.arange(rows), indexing="ij"), -1).reshape(-1, 2)
    return lattice_poses(places * spacing + corner, np.arange(0, 360, step), tilts).astype(float)


def turned(poses, degrees):
    """A room in a frame that is turned: places anticlockwise seen from above, so headings by as much less."""
    points = (poses[:, 0] + 1j * poses[:, 1]) * np.exp(1j * np.radians(degrees))
    return np.column_stack([points.real, points.imag, poses[:, 2] - degrees, poses[:, 3]])


@settings(max_examples=60)
@given(
    columns=st.integers(2, 6),
    rows=st.integers(2, 5),
    spacing=st.floats(0.25, 1.2),
    step=st.sampled_from([90.0, 45.0, 30.0, 60.0]),
    tilts=st.sampled_from([(0.0,), (-25.0, 0.0), (-30.0, 0.0, 30.0)]),
    corner=st.tuples(st.floats(-20, 20), st.floats(-20, 20)),
    rotation=st.floats(-40, 40),
    error=st.floats(0, 1),
    seed=st.integers(0, 10**6),
)
def test_a_jittered_lattice_comes_back(columns, rows, spacing, step, tilts, corner, rotation, error, seed):
    rng = np.random.default_rng(seed)
    meant = grid(columns, rows, spacing, step, tilts, corner)
    meant = meant[rng.random(len(meant)) > 0.03]  # some views are missing
    reach = np.array([min(0.05, spacing / 6), min(0.05, spacing / 6), 4.0, 4.0])
    given_poses = turned(meant, rotation) + error * reach * rng.uniform(-1, 1, meant.shape)
    snapped = snap_poses(table_of(given_poses), LatticeConfig())
    assert snapped.kept.all()
    assert abs(snapped.spacing / spacing - 1) < 0.05
    assert snapped.heading_step == step
    np.testing.assert_allclose(snapped.poses[:, 2], meant[:, 2], atol=1e-3)
    np.testing.assert_allclose(snapped.poses[:, 3], meant[:, 3], atol=3)  # few views tell no more
    # The slow obvious path: the moves of the lattice that nobody disturbed.
    np.testing.assert_array_equal(
        snapped_transitions(snapped.poses, EIGHT_ACTIONS, snapped.spacing, step),
        lattice_transitions(meant, EIGHT_ACTIONS, spacing),
    )


def test_precise_poses_stay_as_they_are(scene):
    snapped = snap_poses(table_of(scene.poses), LatticeConfig())
    np.testing.assert_allclose(snapped.poses, scene.poses, atol=1e-5)
    assert snapped.moved.max() < 1e-4


def test_the_report_says_by_how_much_and_which(scene):
    poses = scene.poses.astype(float)
    poses[17, 0] += 0.06
    poses[20, 2] += 5
    snapped = snap_poses(table_of(poses), LatticeConfig())
    np.testing.assert_allclose(snapped.poses, scene.poses, atol=1e-5)
    assert snapped.moved[17, 0] == pytest.approx(0.06, abs=0.002)
    assert snapped.moved[20, 1] == pytest.approx(5, abs=0.1)
    assert any("(6.0) cm" in note and "farthest 17.jpg" in note for note in snapped.notes)


def test_missing_views_are_named():
    poses = grid(3, 3, 0.4)
    snapped = snap_poses(table_of(np.delete(poses, [3, 10], axis=0)), LatticeConfig())
    note = next(note for note in snapped.notes if "missing" in note)
    assert note.startswith("2 of 72 views are missing")
    assert f"({poses[3, 0]:.2f}, {poses[3, 1]:.2f}) heading {poses[3, 2]:g} tilt {poses[3, 3]:g}" in note


def test_of_two_photographs_of_one_pose_the_nearer_is_kept():
    poses = grid(3, 3, 0.4)
    far = poses[[5]] + [0.05, 0.0, 3.0, 0.0]
    snapped = snap_poses(table_of(np.vstack([far, poses])), LatticeConfig())
    assert snapped.kept.tolist() == [False] + [True] * len(poses)
    assert any("left out" in note and "0.jpg" in note for note in snapped.notes)


def test_many_on_one_pose_are_refused():
    poses = grid(3, 3, 0.4)
    with pytest.raises(SceneError, match=r"photographs fall on the pose of another, as .*\.jpg on that of .*\.jpg"):
        snap_poses(table_of(np.vstack([poses, poses + 0.001])), LatticeConfig())


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ([0.18, 0, 0, 0], r"line 9: 7\.jpg is 1\d cm from the nearest place .* --spacing"),
        ([0, 0, 40, 0], r"line 9: 7\.jpg is \d\d degrees from the nearest heading .* --heading-step"),
    ],
)
def test_a_pose_far_from_the_lattice_is_named(change, message):
    poses = grid(4, 4, 0.4)
    poses[7] += change
    with pytest.raises(SceneError, match=message):
        snap_poses(table_of(poses), LatticeConfig())


def test_places_without_any_grid_are_refused():
    rng = np.random.default_rng(1)
    poses = np.column_stack([rng.uniform(0, 5, (60, 2)), np.tile([0, 90, 180, 270], 15), np.zeros(60)])
    with pytest.raises(SceneError, match=r"--spacing|photographs fall on the pose"):
        snap_poses(table_of(poses), LatticeConfig())


def test_headings_without_any_step_are_refused():
    rng = np.random.default_rng(1)
    poses = np.column_stack([np.zeros((200, 2)), rng.uniform(0, 360, 200), np.zeros(200)])
    with pytest.raises(SceneError, match="no even step; give --heading-step"):
        snap_poses(table_of(poses), LatticeConfig())


def test_tilts_that_run_into_each_other_are_refused_unless_given():
    poses = grid(3, 3, 0.4, tilts=(0.0,))
    poses[:, 3] = np.linspace(-30, 30, len(poses))
    with pytest.raises(SceneError, match="give --tilts"):
        snap_poses(table_of(poses), LatticeConfig())
    levels = snap_poses(table_of(poses), LatticeConfig(tilts=(30.0, -30.0, 0.0, 15.0, -15.0))).poses[:, 3]
    assert set(levels.tolist()) == {-30.0, -15.0, 0.0, 15.0, 30.0}


def test_what_is_given_is_taken():
    poses = grid(3, 3, 0.4)
    snapped = snap_poses(table_of(poses), LatticeConfig(spacing=0.2, heading_step=22.5))
    assert (snapped.spacing, snapped.heading_step) == (0.2, 22.5)
    np.testing.assert_allclose(snapped.poses, poses, atol=1e-5)


@pytest.mark.parametrize("bad", [{"spacing": 0.0}, {"spacing": float("nan")}, {"heading_step": 50.0}, {"tilts": ()}])
def test_wrong_settings_are_refused(bad):
    with pytest.raises(SceneError):
        LatticeConfig(**bad)


def test_one_place_has_no_moves():
    poses = grid(1, 1, 0.4)
    poses[:, :2] += np.random.default_rng(0).uniform(-0.04, 0.04, (len(poses), 2))
    snapped = snap_poses(table_of(poses), LatticeConfig())
    assert np.unique(snapped.poses[:, :2], axis=0).shape == (1, 2)
    actions = lattice_actions(snapped.poses, sideways=True)
    assert actions == (Action.ROTATE_LEFT, Action.ROTATE_RIGHT, Action.LOOK_UP, Action.LOOK_DOWN)


def test_actions_are_those_of_the_lattice():
    level = lattice_actions(grid(2, 2, 0.4, tilts=(0.0,)), sideways=False)
    assert level == (Action.MOVE_AHEAD, Action.MOVE_BACK, Action.ROTATE_LEFT, Action.ROTATE_RIGHT)
    assert lattice_actions(grid(2, 2, 0.4), sideways=True) == EIGHT_ACTIONS


def test_no_rotation_leads_over_a_heading_that_nobody_photographed():
    poses = grid(2, 2, 0.4, tilts=(0.0,))
    corner = poses[poses[:, 2] <= 90]
    turns = snapped_transitions(corner, (Action.ROTATE_LEFT, Action.ROTATE_RIGHT), 0.4, 90.0)
    for state, (left, right) in enumerate(turns.tolist()):
        if corner[state, 2] == 0:
            assert left == state
            assert corner[right, 2] == 90
        else:
            assert right == state
            assert corner[left, 2] == 0


def test_one_way_moves_by_hand():
    actions = (Action.MOVE_AHEAD, Action.MOVE_BACK, Action.LOOK_UP)
    transitions = np.array([[1, 0, 2], [1, 0, 1], [0, 2, 2]])
    # Look up has no counterpart among the actions; ahead from 2 leads to 0, from where back leads nowhere.
    assert one_way_moves(actions, transitions) == [(2, Action.MOVE_AHEAD, 0)]


@pytest.mark.parametrize("step", [360.0, 180.0, 120.0, 90.0, 72.0, 60.0, 45.0, 36.0, 30.0, 24.0, 20.0, 15.0])
def test_steps_of_headings_are_found(step):
    headings = np.repeat(np.arange(0, 360, step), 6) + 7.0
    found = fit_headings(headings)
    assert found == pytest.approx((step, 7.0))


def test_tilts_are_levels():
    assert fit_tilts(np.array([0.0, 5.0, 0.0, 5.0]))[1].tolist() == [0.0, 5.0]
    noisy = np.concatenate([np.linspace(-29, -21, 9), np.linspace(-3.7, 3.3, 9)])
    numbers, levels = fit_tilts(noisy)
    assert levels.tolist() == [-25.0, 0.0]
    assert numbers.tolist() == [0] * 9 + [1] * 9


@given(
    lowest=st.integers(-80, -20),
    steps=st.lists(st.integers(8, 40), max_size=3),
    errors=st.lists(st.integers(0, 8), min_size=4, max_size=4),
    extra=st.integers(0, 60),
    seed=st.integers(0, 10**6),
)
def test_tilts_read_off_to_the_degree_are_the_levels_that_were_meant(lowest, steps, errors, extra, seed):
    """Two degrees are left between what was written down of one level and what was of the next one."""
    rng = np.random.default_rng(seed)
    meant, reach = [lowest], errors[: len(steps) + 1]
    for step, error, following in zip(steps, reach, reach[1:], strict=False):
        meant.append(meant[-1] + max(step, error + following + 2))
    # All that can be written down, each at least twice, and some of it more often.
    level = np.concatenate([np.full(2 * (2 * error + 1), number) for number, error in enumerate(reach)])
    off = np.concatenate([np.tile(np.arange(-error, error + 1), 2) for error in reach])
    chosen = np.concatenate([rng.permutation(len(level)), rng.integers(len(level), size=extra)])
    numbers, levels = fit_tilts(np.array(meant, float)[level[chosen]] + off[chosen])
    np.testing.assert_array_equal(numbers, level[chosen])
    assert np.abs(levels - meant).max() <= 2 + 8 / 3


@pytest.mark.parametrize("tilts", [(-25.0, 0.0), (-20.0, -10.0, 0.0), (0.0,), (-30.0, 0.0, 30.0)])
def test_poses_written_down_in_whole_degrees_need_no_tilts(tilts):
    rng = np.random.default_rng(3)
    meant = grid(4, 4, 0.75, tilts=tilts)
    written = meant + np.column_stack([np.zeros((len(meant), 2)), rng.integers(-2, 3, (len(meant), 2))])
    snapped = snap_poses(table_of(written), LatticeConfig())
    np.testing.assert_allclose(snapped.poses, meant, atol=1e-3)
    given_tilts = snap_poses(table_of(written), LatticeConfig(tilts=tilts))
    np.testing.assert_array_equal(snapped.poses, given_tilts.poses)


@given(st.integers(0, 10**6))
def test_tilts_all_over_the_place_are_no_levels(seed):
    assert fit_tilts(np.random.default_rng(seed).uniform(-30, 30, 300)) is None


@given(st.lists(st.floats(-90, 90), min_size=1, max_size=40))
def test_any_tilts_are_levels_in_order_or_none(tilts):
    fitted = fit_tilts(np.array(tilts))
    if fitted is None:
        return
    numbers, levels = fitted
    assert (np.diff(levels) > 0).all()
    assert set(numbers.tolist()) == set(range(len(levels)))
    assert np.abs(np.array(tilts) - levels[numbers]).max() <= 18.5
    order = np.argsort(tilts, kind="stable")
    assert (np.diff(numbers[order]) >= 0).all()
