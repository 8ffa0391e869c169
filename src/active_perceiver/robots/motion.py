"""Metric moves and turns of a base with two driven wheels, closed over its odometry: how actions become motion.

Nothing here knows whether the base is real: `simulation` and `ros` give it one each. A move is a straight
drive to a point that is planned in the frame of the odometry, so what one action leaves undone the next one corrects;
what the odometry itself gets wrong adds up, as on every robot without a map.
"""

from __future__ import annotations

import math

from active_perceiver.robots.base import Base, Limits, MotionError, Odometry
from active_perceiver.robots.pose2d import Pose2D, ahead, counted_from, moved_towards
from active_perceiver.scenes import Action
from active_perceiver.scenes.angles import signed_angle
from active_perceiver.scenes.lattice import MOVE_DIRECTION, TURN

# So many times what is left to drive, or to turn, is the speed per second: the base slows down towards the end.
EAGERNESS = 2.0
# Metres per second squared by which it slows down at most: no motor is asked for more, so a fast base stops in time.
BRAKING = 0.5
# It steers back by so many degrees for each centimetre beside its line, at most so many.
STEERING, MOST_STEERING = 2.0, 15.0
# A point this much to the side of the way, seen from the robot, is driven to after turning towards it.
ASIDE = 45.0
# Metres by which it backs away from what it ran into and stays at.
BACKING = 0.03
# So many metres beside a point that was travelled to is still there.
NEAR = 0.1
# A part of a long way is this share of the limit 'distance': the base is never quite where it is planned to be.
PART = 0.9


class MotionController:
    """Carries out moves and turns on a base.

    Args:
        base: what drives.
        limits: of every motion.
        step: metres moved by one action.
        turn: degrees turned by one action.

    Attributes:
        plan: where the base should be; where it was when the first action began, until then None.
        start: where that was; `travel_to` counts from there.
    """

    def __init__(self, base: Base, limits: Limits, step: float, turn: float = 90.0) -> None:
        if not 0 < step <= limits.distance:
            raise MotionError(
                f"one action moves {step:g} m, but the limit 'distance' is {limits.distance:g} m; raise it, or take "
                "a smaller step"
            )
        self.limits = limits
        self.plan: Pose2D | None = None
        self.start: Pose2D | None = None
        self._base = base
        self._step = step
        self._turn = turn

    def execute(self, action: Action) -> bool:
        """Move one step or turn one turn; see `go_to` for what becomes of a way that is blocked.

        Returns:
            Whether the base moved.

        Raises:
            MotionError: if the action is not one of the base, or the motion exceeds a limit.
        """
        here = self._planned()
        if action in TURN:
            return self.go_to(Pose2D(here.x, here.z, here.heading + TURN[action] * self._turn))
        if action not in MOVE_DIRECTION:
            raise MotionError(f"a base cannot do {action.value}; its actions are moves and turns")
        return self.go_to(ahead(here, self._step, MOVE_DIRECTION[action]))

    def go_to(self, goal: Pose2D) -> bool:
        """Drive straight to a point of the odometry's frame, turning first if it lies aside, and turn to a heading.

        If the way is blocked, it stays, a little back, where that is nearer to the goal than to where it came from,
        and plans on from there: a robot that has drifted towards a wall has less than a step left. Else it goes back
        to where it was planned to be, as far as it can, and turns to the heading that it had.

        Returns:
            Whether it got there, or nearer to there.

        Raises:
            MotionError: if the motion exceeds a limit, or the point is none.
        """
        _check_numbers(goal.x, goal.z, goal.heading)
        before = self._planned()
        try:
            if self._reach(goal):
                self.plan = goal
                return True
            at = self._base.odometry()
            if math.hypot(goal.x - at.x, goal.z - at.z) < math.hypot(before.x - at.x, before.z - at.z):
                self.plan = moved_towards(at, before, BACKING, goal.heading)
                self._stay_at(self.plan)
                return True
            self._stay_at(before)
            return False
        finally:
            self._base.drive(0.0, 0.0)

    def travel_to(self, x: float, z: float, heading: float) -> bool:
        """Drive straight to a point as seen from the start, in parts where it is far; on a blocked way drive back.

        Args:
            x: metres to the right of the start, as the base looked there.
            z: metres ahead of the start.
            heading: degrees clockwise from the start's.

        Returns:
            Whether it got there, to within `NEAR` metres. If not it is where it was, as nearly as it can be.

        Raises:
            MotionError: if a motion exceeds a limit, or the point is none.
        """
        _check_numbers(x, z, heading)
        before = self._planned()
        assert self.start is not None  # set together with the plan
        if self._travel(counted_from(self.start, x, z, heading)):
            return True
        self._travel(before)
        return False

    def _travel(self, goal: Pose2D) -> bool:
        here = self._planned()
        way = math.degrees(math.atan2(goal.x - here.x, goal.z - here.z))
        parts = math.ceil(math.hypot(goal.x - here.x, goal.z - here.z) / (PART * self.limits.distance))
        for part in range(1, parts):
            share = part / parts
            x, z = here.x + share * (goal.x - here.x), here.z + share * (goal.z - here.z)
            if not self._arrive(Pose2D(x, z, driving(here.heading, way))):
                return False
        return self._arrive(goal)

    def _arrive(self, goal: Pose2D) -> bool:
        """`go_to`, but what is only nearer to there does not count, and it has to look where it should."""
        if not self.go_to(goal):
            return False
        at = self._fresh_odometry()
        if math.hypot(goal.x - at.x, goal.z - at.z) > NEAR:
            return False
        try:
            return self._face(goal.heading)
        finally:
            self._base.drive(0.0, 0.0)

    def _planned(self) -> Pose2D:
        if self.plan is None:
            at = self._fresh_odometry()
            self.plan = self.start = Pose2D(at.x, at.z, at.heading)
        return self.plan

    def _stay_at(self, place: Pose2D) -> None:
        """Get to a place as nearly as it can be, and look where one should look there in any case."""
        if not self._reach(place):
            self._face(place.heading)

    def _reach(self, goal: Pose2D) -> bool:
        at = self._fresh_odometry()
        distance = math.hypot(goal.x - at.x, goal.z - at.z)
        if distance > self.limits.distance:
            raise MotionError(
                f"a motion of {distance:.2f} m is longer than the limit 'distance', {self.limits.distance:g} m; the "
                "robot was not moved"
            )
        if distance > 2 * self.limits.position_tolerance:
            towards = math.degrees(math.atan2(goal.x - at.x, goal.z - at.z))
            backwards = _lies_behind(at.heading, towards)
            aside = not backwards and abs(signed_angle(towards - at.heading)) > ASIDE
            if aside and distance > 5 * self.limits.position_tolerance and not self._face(towards):
                return False
            if not self._drive_to(goal, backwards):
                return False
        return self._face(goal.heading)

    def _face(self, heading: float) -> bool:
        """Turn on the spot; False if the base does not turn."""
        watch = _Watch(self._base, self.limits)
        while abs(left := signed_angle(heading - self._fresh_odometry().heading)) > self.limits.heading_tolerance:
            if watch.stalled(abs(left), self.limits.heading_tolerance):
                self._settle()
                return False
            rate = min(self.limits.angular_velocity, max(EAGERNESS * abs(left), 4 * self.limits.heading_tolerance))
            self._command(0.0, math.copysign(rate, left))
        self._settle()
        return True

    def _drive_to(self, goal: Pose2D, backwards: bool) -> bool:
        """Drive along a straight line to a point; False if the base does not come nearer."""
        start = self._fresh_odometry()
        line = math.atan2(goal.x - start.x, goal.z - start.z)
        sense = -1.0 if backwards else 1.0
        face = math.degrees(line) + (180.0 if backwards else 0.0)
        watch = _Watch(self._base, self.limits)
        while True:
            at = self._fresh_odometry()
            east, north = goal.x - at.x, goal.z - at.z
            left = east * math.sin(line) + north * math.cos(line)
            beside = east * math.cos(line) - north * math.sin(line)  # positive: the line lies to the right of the way
            if left <= self.limits.position_tolerance:
                self._settle()
                return True
            if watch.stalled(left, self.limits.position_tolerance):
                self._settle()
                return False
            correction = max(-MOST_STEERING, min(MOST_STEERING, 100 * STEERING * beside))
            angular_velocity = EAGERNESS * signed_angle(face + correction - at.heading)
            angular_velocity = max(-self.limits.angular_velocity, min(self.limits.angular_velocity, angular_velocity))
            speed = max(min(EAGERNESS * left, math.sqrt(2 * BRAKING * left)), 2 * self.limits.position_tolerance)
            speed = min(self.limits.speed, speed)
            self._command(sense * speed, angular_velocity)

    def _command(self, speed: float, angular_velocity: float) -> None:
        self._base.drive(speed, angular_velocity)
        self._base.wait(self.limits.period)

    def _settle(self) -> None:
        """Stand still, so that the next picture is sharp."""
        self._command(0.0, 0.0)

    def _fresh_odometry(self) -> Odometry:
        at = self._base.odometry()
        age = self._base.now() - at.time
        if age > self.limits.odometry_age:
            self._base.drive(0.0, 0.0)
            raise MotionError(
                f"the odometry is {age:.2f} s old, more than the limit 'odometry_age', "
                f"{self.limits.odometry_age:g} s; the robot was stopped: check its base and the network"
            )
        return at


class _Watch:
    """Time and progress of one motion."""

    def __init__(self, base: Base, limits: Limits) -> None:
        self._base, self._limits = base, limits
        self._started = self._progress = base.now()
        self._least = math.inf

    def stalled(self, left: float, little: float) -> bool:
        """Whether what is left to do has not become less by a little for too long.

        Raises:
            MotionError: if the motion has taken longer than it may.
        """
        now = self._base.now()
        if now - self._started > self._limits.seconds:
            self._base.drive(0.0, 0.0)
            raise MotionError(
                f"a motion took longer than the limit 'seconds', {self._limits.seconds:g} s; the robot was stopped: "
                "see what holds it, or raise the limit"
            )
        if left < self._least - little:
            self._least, self._progress = left, now
        return now - self._progress > self._limits.stall


def _check_numbers(*point: float) -> None:
    if not all(math.isfinite(value) for value in point):
        raise MotionError(f"{point} is no point to drive to: x, z and heading are numbers; the robot was not moved")


def driving(heading: float, way: float) -> float:
    """The heading at which a base that has one drives along a way, in degrees: backwards if that lies behind."""
    return way + 180.0 if _lies_behind(heading, way) else way


def _lies_behind(heading: float, way: float) -> bool:
    return abs(signed_angle(way - heading)) > 180 - ASIDE
