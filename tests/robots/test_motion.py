"""Moves and turns closed over odometry, on a simulated body."""

import math

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from active_perceiver.robots.base import Limits, MotionError, Odometry
from active_perceiver.robots.motion import MotionController
from active_perceiver.robots.pose2d import Pose2D
from active_perceiver.scenes import TURTLEBOT_ACTIONS, Action
from active_perceiver.scenes.lattice import MOVE_DIRECTION, TURN
from active_perceiver.simulation.diff_drive import NO_NOISE, DiffDriveError, DiffDriveSim, OdometryNoise
from helpers.bridge import anywhere

MOVES_AND_TURNS = [action for action in Action if action in MOVE_DIRECTION or action in TURN]


class SimulatedBase:
    """A body as a base; notes the largest velocities."""

    def __init__(self, body: DiffDriveSim, *, late: float = 0.0):
        self.body = body
        self.late = late
        self.fastest = self.sharpest = 0.0

    def drive(self, speed, angular_velocity):
        self.fastest, self.sharpest = max(self.fastest, abs(speed)), max(self.sharpest, abs(angular_velocity))
        self.body.drive(speed, angular_velocity)

    def odometry(self):
        at = self.body.odometry()
        return Odometry(at.x, at.z, at.heading, at.time - self.late)

    def now(self):
        return self.body.time

    def wait(self, seconds):
        self.body.wait(seconds)


def base_in(free=anywhere, odometry_noise=NO_NOISE, seed=0, **kwargs):
    return SimulatedBase(DiffDriveSim(0.0, 0.0, 0.0, free, odometry_noise, seed), **kwargs)


def angle(degrees):
    return (degrees + 180) % 360 - 180


@settings(max_examples=10, deadline=None)
@given(st.lists(st.sampled_from(MOVES_AND_TURNS), min_size=1, max_size=8), st.sampled_from([0.25, 0.35, 0.75]))
def test_without_slip_actions_lead_where_the_lattice_says(actions, step):
    base = base_in()
    driver = MotionController(base, Limits(), step)
    x = z = heading = 0.0
    for action in actions:
        assert driver.execute(action)
        if action in TURN:
            heading += 90 * TURN[action]
        else:
            way = math.radians(heading + MOVE_DIRECTION[action])
            x, z = x + step * math.sin(way), z + step * math.cos(way)
    # What one action leaves undone does not add up.
    assert math.hypot(base.body.x - x, base.body.z - z) < 0.03
    assert abs(angle(base.body.heading - heading)) < 3
    base.body.wait(0.5)
    assert not base.body.moving
    assert base.fastest <= Limits().speed
    assert base.sharpest <= Limits().angular_velocity


def test_slip_adds_up_as_odometry_does_not_see_it():
    away = []
    for seed in range(8):
        base = base_in(odometry_noise=OdometryNoise(), seed=seed)
        driver = MotionController(base, Limits(), 0.5)
        for _ in range(4):
            assert driver.execute(Action.MOVE_AHEAD)
        at = base.odometry()
        assert math.hypot(at.x, at.z - 2) < 0.03
        away.append(math.hypot(base.body.x, base.body.z - 2))
    assert 0.02 < sum(away) / len(away) < 0.3


def test_a_blocked_way_is_driven_back():
    base = base_in(lambda x, z: z < 0.3)
    driver = MotionController(base, Limits(), 0.75)
    assert not driver.execute(Action.MOVE_AHEAD)
    assert base.body.collisions == 1
    assert math.hypot(base.body.x, base.body.z) < 0.03
    assert driver.execute(Action.MOVE_BACK)
    assert base.body.z == pytest.approx(-0.75, abs=0.03)


def test_a_blocked_way_to_the_side_ends_with_the_heading_it_began_with():
    base = base_in(lambda x, z: x < 0.2)
    driver = MotionController(base, Limits(), 0.5)
    assert not driver.execute(Action.MOVE_RIGHT)
    assert abs(angle(base.body.heading)) < 3
    assert math.hypot(base.body.x, base.body.z) < 0.05


@pytest.mark.parametrize(("action", "free"), [
    (Action.MOVE_AHEAD, lambda x, z: z < 0.3),
    (Action.MOVE_BACK, lambda x, z: z > -0.3),
    (Action.MOVE_RIGHT, lambda x, z: x < 0.3),
])  # fmt: skip
def test_where_most_of_the_way_is_free_it_stays_at_its_end(action, free):
    base = base_in(free)
    driver = MotionController(base, Limits(), 0.5)
    assert driver.execute(action)
    assert math.hypot(base.body.x, base.body.z) == pytest.approx(0.27, abs=0.03)
    assert abs(angle(base.body.heading)) < 3
    # What it plans next begins there.
    there = base.body.x, base.body.z
    assert not driver.execute(action)
    assert math.hypot(base.body.x - there[0], base.body.z - there[1]) < 0.03


def test_wedged_beside_its_way_it_still_turns_back_to_where_it_looked():
    shut = []  # once it has moved a little to the side, it cannot move at all

    def free(x, z):
        if x > 0.1:
            shut.append(True)
        return not shut

    base = base_in(free)
    assert not MotionController(base, Limits(), 0.5).execute(Action.MOVE_RIGHT)
    assert abs(angle(base.body.heading)) < 3


def test_it_goes_to_a_point_anywhere_around():
    base = base_in()
    driver = MotionController(base, Limits(distance=3), 0.5)
    for x, z, heading in ((1.0, 1.0, 90.0), (-0.5, 0.5, 200.0), (0.0, 0.0, 0.0), (0.005, 0.0, 10.0)):
        assert driver.go_to(Pose2D(x, z, heading))
        assert math.hypot(base.body.x - x, base.body.z - z) < 0.03
        assert abs(angle(base.body.heading - heading)) < 3


def test_late_odometry_stops_the_base():
    base = base_in(late=0.6)
    with pytest.raises(MotionError, match=r"odometry is 0\.60 s old"):
        MotionController(base, Limits(), 0.5).execute(Action.MOVE_AHEAD)
    assert not base.body.moving


def test_a_motion_that_takes_too_long_is_given_up_and_stopped():
    base = base_in()
    with pytest.raises(MotionError, match="longer than the limit 'seconds'"):
        MotionController(base, Limits(seconds=1.0), 0.75).execute(Action.MOVE_AHEAD)
    base.body.wait(1)
    assert not base.body.moving


def test_a_motion_that_is_too_long_is_not_begun():
    base = base_in()
    driver = MotionController(base, Limits(distance=1), 0.5)
    with pytest.raises(MotionError, match="longer than the limit 'distance'"):
        driver.go_to(Pose2D(0.0, 2.0, 0.0))
    assert (base.body.x, base.body.z) == (0, 0)


@pytest.mark.parametrize("point", [(math.nan, 0.0, 0.0), (0.0, math.inf, 0.0), (0.0, 0.5, math.nan)])
def test_what_is_no_point_is_not_driven_to(point):
    base = base_in()
    driver = MotionController(base, Limits(), 0.5)
    for go in (lambda: driver.go_to(Pose2D(*point)), lambda: driver.travel_to(*point)):
        with pytest.raises(MotionError, match="is no point to drive to"):
            go()
    assert base.body.time == 0


def test_an_exception_while_driving_stops_the_base():
    base = base_in()

    def interrupted(seconds):
        base.body.wait(seconds)
        if base.body.time > 0.5:
            raise KeyboardInterrupt

    base.wait = interrupted
    with pytest.raises(KeyboardInterrupt):
        MotionController(base, Limits(), 0.75).execute(Action.MOVE_AHEAD)
    base.body.wait(1)
    assert not base.body.moving


class Laggard(SimulatedBase):
    """A base whose odometry is what it was some time ago."""

    def __init__(self, body, lag):
        super().__init__(body)
        self.lag, self.seen = lag, [body.odometry()]

    def odometry(self):
        return next(at for at in reversed(self.seen) if at.time <= self.body.time - self.lag or at is self.seen[0])

    def wait(self, seconds):
        for _ in range(5):
            super().wait(seconds / 5)
            self.seen.append(self.body.odometry())


@pytest.mark.parametrize("speed", [0.25, 0.5, 1.0, 1.5])
def test_a_fast_base_stops_in_time_although_its_odometry_is_late(speed):
    base = Laggard(DiffDriveSim(0.0, 0.0, 0.0, anywhere, NO_NOISE, 0), 0.15)
    assert MotionController(base, Limits(speed=speed, distance=3.0), 2.0).execute(Action.MOVE_AHEAD)
    base.body.wait(1.0)
    assert base.body.z == pytest.approx(2.0, abs=0.05)


def test_a_base_does_not_look():
    with pytest.raises(MotionError, match="cannot do LookUp"):
        MotionController(base_in(), Limits(), 0.5).execute(TURTLEBOT_ACTIONS[4])


@pytest.mark.parametrize(
    "wrong",
    [{"speed": 0}, {"speed": 2}, {"seconds": float("nan")}, {"distance": -1}, {"odometry_age": 11}, {"period": 0.6}],
)
def test_limits_that_make_no_sense_are_refused(wrong):
    with pytest.raises(MotionError, match=next(iter(wrong))):
        Limits(**wrong)


def test_a_step_beyond_the_limit_is_refused():
    with pytest.raises(MotionError, match=r"'distance' is 0\.5"):
        MotionController(base_in(), Limits(distance=0.5), 0.75)


def test_a_body_inside_something_is_refused():
    with pytest.raises(DiffDriveError, match="start elsewhere"):
        DiffDriveSim(0, 0, 0, lambda x, z: False)


@pytest.mark.parametrize("wrong", [{"veer": -1}, {"jerk": float("nan")}, {"distance": 30}])
def test_slip_that_makes_no_sense_is_refused(wrong):
    with pytest.raises(DiffDriveError, match=next(iter(wrong))):
        OdometryNoise(**wrong)


def travelled(x, z, heading, limits=None, free=anywhere, start=90.0):
    """A driver that travelled from a start whose odometry is not 0, and its body, seen from there."""
    base = base_in(free)
    driver = MotionController(base, limits or Limits(), 0.5)
    assert driver.go_to(Pose2D(0.0, 0.0, start))
    driver.start = driver.plan
    return driver.travel_to(x, z, heading), base.body


def test_it_travels_to_points_as_seen_from_its_start_in_parts():
    there, body = travelled(0.6, 2.4, 180.0, Limits(distance=0.5))
    assert there
    # It looked along x when it started: ahead is x, and to its right is -z.
    assert (body.x, body.z) == pytest.approx((2.4, -0.6), abs=0.03)
    assert abs(angle(body.heading - 270)) < 2
    assert not body._wanted[0]


@pytest.mark.parametrize(("wall", "there"), [(0.3, False), (1.6, False), (2.95, True)])
def test_a_journey_that_is_blocked_ends_where_it_began(wall, there):
    arrived, body = travelled(0.0, 3.0, 0.0, Limits(distance=1.0), free=lambda x, z: x < wall)
    assert arrived == there
    assert body.x == pytest.approx(3.0 if there else 0.0, abs=0.12)
    assert body.z == pytest.approx(0, abs=0.05)
    assert abs(angle(body.heading - 90)) < 3


def test_it_looks_where_it_should_even_where_it_cannot_back_away():
    # It may go so far and no further, and when it has, not back either.
    came = []

    def free(x, z):
        came.append(z)
        return z < 0.46 and (max(came) < 0.455 or z >= 0.44)

    base = base_in(free)
    driver = MotionController(base, Limits(), 0.5)
    assert driver.travel_to(0.0, 0.5, 90.0)
    assert base.body.collisions >= 2
    assert abs(angle(base.body.heading - 90)) < 2
