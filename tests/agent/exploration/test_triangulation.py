"""Where targets are that were seen from several poses: against points that are projected by a camera matrix."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from active_perceiver.agent.exploration.triangulation import Sighting, estimate, estimates, expected_areas, rays

FOV = 75.0


def projected(pose, point):
    """u, v in 0..1 and distance of a point (x, z, height above the camera), by rotation matrices; None behind."""
    heading, tilt = np.radians(pose[2]), np.radians(pose[3])
    world = np.array([point[0] - pose[0], point[2], point[1] - pose[1]])  # east, up, north
    about_up = np.array([[np.cos(heading), 0, -np.sin(heading)], [0, 1, 0], [np.sin(heading), 0, np.cos(heading)]])
    about_right = np.array([[1, 0, 0], [0, np.cos(tilt), -np.sin(tilt)], [0, np.sin(tilt), np.cos(tilt)]])
    right, up, ahead = about_right @ about_up @ world
    if ahead <= 0:
        return None
    half = np.tan(np.radians(FOV / 2))
    return 0.5 + right / ahead / half / 2, 0.5 - up / ahead / half / 2, np.hypot(world[0], world[2])


def poses_of(places=5, tilts=(-30.0, 0.0, 30.0)):
    grid = np.array([(x, z) for x in range(places) for z in range(places)], float) * 0.5
    return np.array(
        [(x, z, heading, tilt) for x, z in grid for heading in (0, 90, 180, 270) for tilt in tilts], np.float32
    )


def seen_by(poses, point, size=0.02, margin=0.45):
    sightings = []
    for state, pose in enumerate(poses):
        where = projected(pose, point)
        if where is not None and abs(where[0] - 0.5) < margin and abs(where[1] - 0.5) < margin:
            side = np.sqrt(size) / where[2]
            sightings.append(Sighting(state, np.array([where[0], where[1], side, side]), 0.9))
    return sightings


@given(
    st.floats(-1, 3), st.floats(-1, 3), st.floats(-0.8, 0.8), st.floats(0, 359), st.sampled_from([-30.0, 0.0, 30.0])
)
def test_a_ray_goes_through_the_point_it_was_projected_from(x, z, height, heading, tilt):
    pose = np.array([1.0, 1.0, heading, tilt])
    where = projected(pose, (x, z, height))
    if where is None or where[2] < 0.1:
        return
    bearing, elevation = rays(pose[None], np.array([[where[0], where[1], 0.1, 0.1]]), FOV)[0]
    expected = np.degrees(np.arctan2(x - 1.0, z - 1.0))
    assert abs((bearing - expected + 180) % 360 - 180) < 1e-3
    assert elevation == pytest.approx(np.degrees(np.arctan2(height, where[2])), abs=1e-3)


@pytest.mark.parametrize("point", [(2.9, 1.0, 0.2), (-0.7, 2.2, -0.4), (1.1, -0.8, 0.0)])
def test_a_point_seen_from_three_places_is_found_again(point):
    poses = poses_of()
    all_of_it = seen_by(poses, point)
    rng = np.random.default_rng(1)
    few = [all_of_it[i] for i in rng.choice(len(all_of_it), 6, replace=False)]
    found = estimate(few, poses, FOV)
    assert np.hypot(found.point[0] - point[0], found.point[1] - point[1]) < 0.3
    assert found.point[2] == pytest.approx(point[2], abs=0.2)
    assert found.size == pytest.approx(0.02, rel=0.35)
    assert len(found.sightings) == 6


def test_a_wrong_box_is_outvoted_and_left_over():
    poses, point = poses_of(), (2.9, 1.0, 0.2)
    right = seen_by(poses, point)[:6]
    wrong = Sighting(int(np.flatnonzero(poses[:, 2] == 270)[0]), np.array([0.3, 0.5, 0.4, 0.4]), 1.0)
    both = estimates([*right, wrong], poses, FOV)
    assert [len(one.sightings) for one in both] == [6, 1]
    assert both[1].sightings == (wrong,)
    assert both[0].best in right
    assert both[1].confidence == 1.0


def test_where_it_should_look_how_large_is_what_a_camera_says():
    poses, point = poses_of(), (2.9, 1.0, 0.2)
    found = estimate(seen_by(poses, point), poses, FOV)
    areas = expected_areas(found, poses, FOV)
    for pose, area in zip(poses, areas, strict=True):
        where = projected(pose, found.point)
        inside = where is not None and max(abs(where[0] - 0.5), abs(where[1] - 0.5)) < 0.45
        if area > 0:
            assert inside
            assert area == pytest.approx(min(found.size / where[2] ** 2, 1.0), rel=1e-3)
        else:
            assert not inside or where[2] <= 0.3


def test_one_sighting_is_taken_to_be_as_far_away_as_things_usually_are():
    poses = poses_of()
    state = int(np.flatnonzero((poses[:, 2] == 90) & (poses[:, 3] == 0))[0])
    found = estimate([Sighting(state, np.array([0.5, 0.5, 0.1, 0.1]), 0.8)], poses, FOV)
    assert found.point[0] - poses[state, 0] == pytest.approx(1.5, abs=0.2)
    assert found.point[1] == pytest.approx(poses[state, 1], abs=0.2)
