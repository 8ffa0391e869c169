"""The simulated TurtleBot: where it is, what it sees, what its slip does; rooms by name, with things nudged."""

import numpy as np
import pytest

from active_perceiver.capture.rendered.capture_scene import HEADINGS
from active_perceiver.errors import UserError
from active_perceiver.robots.base import Limits, MotionError
from active_perceiver.scenes import Action
from active_perceiver.scenes.lattice import lattice_poses
from active_perceiver.simulation.diff_drive import DiffDriveError, OdometryNoise
from active_perceiver.simulation.room import NAME, open_room
from active_perceiver.simulation.simulated_robot import SimulatedRobot, lattice_start, random_start
from box_room import BOX, DEPTH, TABLE, WIDTH, box_room
from helpers.simulated_place import SETTINGS, START, simulated, small_room
from indoor_rooms.free_space import clearance, free_positions
from indoor_rooms.layouts import LayoutError, make_room
from indoor_rooms.perturb import PerturbError, perturbed


def test_it_sees_what_the_room_shows_from_where_it_truly_is():
    robot = simulated(odometry_noise=OdometryNoise(), seed=3)
    robot.execute(Action.ROTATE_RIGHT)
    robot.execute(Action.LOOK_UP)
    x, z, heading, tilt = robot.pose()
    assert (x, z, heading) == (robot.body.x, robot.body.z, robot.body.heading)
    assert tilt == 30
    image, boxes = small_room().look((x, z, heading, tilt), ["box"])
    np.testing.assert_array_equal(robot.look(), image)
    assert np.isfinite(boxes).all()  # the box is to the east


def test_a_start_between_the_lattices_tilts_keeps_what_it_is_off():
    robot = simulated((2.3, 1.5, 5.0, -26.0))
    assert robot.pose() == (2.3, 1.5, 5.0, -26.0)
    assert not robot.execute(Action.LOOK_DOWN)
    robot.execute(Action.LOOK_UP)
    assert robot.pose()[3] == 4.0


def test_it_never_touches_what_stands_there():
    rng = np.random.default_rng(0)
    robot = simulated(odometry_noise=OdometryNoise(), seed=1)
    blocked = 0
    for _ in range(60):
        blocked += not robot.execute(robot.actions[rng.integers(6)])
        place = np.array([[robot.body.x, robot.body.z]])
        radius = SETTINGS.robot_radius
        assert clearance(place, place, [TABLE])[0] >= radius
        assert radius <= robot.body.x <= WIDTH - radius
        assert radius <= robot.body.z <= DEPTH - radius
    assert blocked > 3
    assert robot.body.collisions >= blocked - 1


def test_the_same_seed_gives_the_same_way():
    def way(seed):
        robot = simulated(odometry_noise=OdometryNoise(), seed=seed)
        for action in (Action.MOVE_AHEAD, Action.ROTATE_LEFT, Action.MOVE_LEFT):
            robot.execute(action)
        return robot.pose()

    assert way(4) == way(4)
    assert way(4) != way(5)


def test_limits_hold():
    robot = simulated(limits=Limits(seconds=0.5))
    with pytest.raises(MotionError, match="'seconds'"):
        robot.execute(Action.ROTATE_LEFT)
    robot.body.wait(1)
    assert not robot.body.moving


def test_a_start_in_the_furniture_is_refused():
    with pytest.raises(DiffDriveError, match="start elsewhere"):
        simulated((1.3, 0.7, 0, 0))


def test_random_starts_are_near_the_lattice():
    room, places = small_room(), small_room().places()
    headings, tilts = set(), set()
    for seed in range(60):
        x, z, heading, tilt = random_start(room, np.random.default_rng(seed), 10, 8)
        assert np.abs(places - (x, z)).max(axis=1).min() <= 0.1
        assert abs((heading + 45) % 90 - 45) <= 8
        assert room.free(x, z)
        headings.add(round(heading / 90) % 4)
        tilts.add(tilt)
    assert headings == {0, 1, 2, 3}
    assert tilts == set(SETTINGS.tilts)


@pytest.mark.parametrize("place", [(0.1, 1.5), (2.0, 2.9), (1.3, 0.7), (1.3, 1.15)])
def test_walls_and_furniture_are_not_free(place):
    assert not small_room().free(*place)


def test_free_agrees_with_the_clearance_of_everything():
    rng = np.random.default_rng(2)
    for x, z in rng.uniform(0, (WIDTH, DEPTH), (200, 2)):
        place, radius = np.array([[x, z]]), SETTINGS.robot_radius
        wall = min(x, z, WIDTH - x, DEPTH - z)
        assert small_room().free(x, z) == (clearance(place, place, [TABLE])[0] >= radius and wall >= radius)


def test_the_tilt_nearest_to_the_start_is_its_own():
    assert SimulatedRobot(small_room(), (*START[:3], 14.0)).pose()[3] == 14.0


@pytest.mark.parametrize(
    ("name", "parts"),
    [
        ("kitchen_1", ("kitchen_1", None, None)),
        ("living_room_12_hour_low_sun", ("living_room_12", "low_sun", None)),
        ("conference_room_moved_2", ("conference_room", None, "2")),
        ("kitchen_1_hour_night_moved_9", ("kitchen_1", "night", "9")),
    ],
)
def test_rooms_are_named_as_their_scenes(name, parts):
    found = NAME.fullmatch(name)
    assert found.group("scene", "hour", "moved") == parts


@pytest.mark.parametrize("name", ["", "kitchen", "cellar_1", "kitchen_1_hour_", "kitchen_1 ", "../kitchen_1"])
def test_a_name_that_is_no_room_is_refused(name):
    with pytest.raises(LayoutError, match="kitchen_1_hour_dusk"):
        open_room(name)


def test_an_hour_that_there_is_not_is_refused():
    with pytest.raises(LayoutError, match="no hour of the day 'tea'"):
        open_room("kitchen_1_hour_tea")


def test_things_are_nudged_a_little_and_level():
    room = box_room()
    moved = perturbed(room, 0.05, seed=1)
    shift = {
        part.object_name: moved.parts[number].mesh.vertices - part.mesh.vertices
        for number, part in enumerate(room.parts)
    }
    assert np.ptp(shift["box"], axis=0) == pytest.approx(0)
    x, y, up = shift["box"][0]
    assert 0.025 <= np.hypot(x, y) <= 0.05
    assert up == 0
    assert not any(np.any(shift[name]) for name in shift if name != "box")
    assert BOX[0][0] + x > 0


def test_the_same_seed_nudges_alike_and_another_does_not():
    def corner(seed):
        return perturbed(box_room(), 0.05, seed).parts[-2].mesh.vertices[0].tolist()

    assert corner(1) == corner(1)
    assert corner(1) != corner(2)


def test_most_things_of_a_real_room_are_nudged_and_run_into_nothing_new():
    room = make_room("kitchen", 1)
    moved = perturbed(room, 0.05, seed=0)
    changed = {
        part.object_name
        for part, before in zip(moved.parts, room.parts, strict=True)
        if (part.mesh.vertices != before.mesh.vertices).any()
    }
    assert changed <= set(room.targets)
    assert len(changed) > 0.6 * len(room.targets)


@pytest.mark.parametrize("most", [0, -1, 0.6, float("nan")])
def test_a_nudge_that_is_none_is_refused(most):
    with pytest.raises(PerturbError, match="can be nudged"):
        perturbed(box_room(), most, 0)


def test_a_start_on_the_lattice_is_a_state_of_the_scenes_of_the_room():
    positions = free_positions(box_room(), SETTINGS.spacing, SETTINGS.robot_radius)
    poses = lattice_poses(positions, HEADINGS, SETTINGS.tilts)  # as `capture` numbers them
    for state in (0, 17, len(poses) - 1):
        assert lattice_start(small_room(), state) == pytest.approx(poses[state], abs=1e-5)
    with pytest.raises(UserError, match=f"states 0 to {len(poses) - 1}; there is no state {len(poses)}"):
        lattice_start(small_room(), len(poses))
