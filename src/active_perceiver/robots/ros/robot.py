"""A robot with a camera on two driven wheels, reached over rosbridge: what a TurtleBot is to the search.

It stops when a motion ends, whatever ends it: a limit, old odometry, an image that is too old, a lost connection, an
exception, Ctrl-C, the end of the program. Behind that stands the base itself, which stops when no velocity comes.
"""

from __future__ import annotations

import atexit
import logging
import math
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager

import numpy as np
from numpy.typing import NDArray

from active_perceiver.robots.base import Odometry
from active_perceiver.robots.motion import MotionController
from active_perceiver.robots.robot import StopOnExit, check_action
from active_perceiver.robots.ros.config import RosConfig
from active_perceiver.robots.ros.connection import ConnectionLost, Link, RosError
from active_perceiver.scenes import Action
from active_perceiver.scenes.angles import signed_angle
from active_perceiver.scenes.lattice import LOOK, nearest_tilt

# So often zero velocity is published to stop, with a pause in seconds: one message may get lost.
STOPS, BETWEEN_STOPS = 3, 0.03
# Odometry goes on where it was if it is at most so much further than the base can have come before it stopped itself.
STOPPED_AFTER, METRES_OFF, DEGREES_OFF = 1.0, 0.1, 5.0
# What to do when nothing can be sent any more.
STILL_MOVES = "stop it if it still moves (docs/robot.md, 1), and check the robot and the network"

LOG = logging.getLogger(__name__)


class RosBase:
    """The driven wheels behind a link, as `motion.MotionController` wants them."""

    def __init__(self, link: Link, settings: RosConfig) -> None:
        self._link, self._settings = link, settings

    def drive(self, speed: float, angular_velocity: float) -> None:
        """Set the velocities, within the limits; zero is always accepted.

        Raises:
            ConnectionLost: if there is no connection.
            RosError: if a velocity is no number, which no limit holds.
        """
        if not math.isfinite(speed + angular_velocity):
            self._link.drive(0.0, 0.0)
            raise RosError(f"{speed:g} m/s with {angular_velocity:g} degrees/s is no velocity; the robot was stopped")
        if speed or angular_velocity:
            self.check()
        limits = self._settings.limits
        fast, sharp = (
            min(most, max(-most, value))
            for most, value in ((limits.speed, speed), (limits.angular_velocity, angular_velocity))
        )
        self._link.drive(fast, sharp)

    def odometry(self) -> Odometry:
        """The newest odometry.

        Raises:
            ConnectionLost: if there is no connection, or nothing at all comes any more.
            RosError: if what comes cannot be read.
        """
        self.check()
        wheels = self._link.wheels
        age, most = wheels.age(), self._settings.limits.odometry_age
        if age > most and (wheels.broken or wheels.repeated):
            raise RosError(f"there is no odometry since {age:.1f} s: {wheels.trouble()}; check the base's driver")
        if age > most:
            self.check_heard(most)
        assert wheels.newest is not None  # a link that is open has seen some
        return Odometry(*wheels.newest, wheels.taken)

    def now(self) -> float:
        """Seconds of our monotonic clock."""
        return time.monotonic()

    def wait(self, seconds: float) -> None:
        """Let the base move on for a moment.

        Raises:
            ConnectionLost: if there is no connection.
            RosError: if the newest image is too old to move on.
        """
        time.sleep(seconds)
        self.check()
        camera, max_image_age = self._link.camera, self._settings.camera.max_image_age
        if (age := camera.age()) > max_image_age:
            self.check_heard(max_image_age)
            raise RosError(
                f"the newest image is {age:.1f} s old, more than 'max_image_age', {max_image_age:g} s: "
                f"{camera.trouble()}; the robot "
                "was stopped: check its camera and the network"
            )

    def check(self) -> None:
        """Raise ConnectionLost if there is no connection."""
        if self._link.lost is not None:
            raise ConnectionLost(f"the connection to {self._link.url} was lost: {self._link.lost}")

    def check_heard(self, seconds: float) -> None:
        """Raise ConnectionLost if one topic is silent for so long because nothing comes at all."""
        # Not all topics fall silent in one moment, and whoever is asked first should know.
        silent = time.monotonic() - self._link.heard
        if silent > seconds / 2:
            raise ConnectionLost(f"nothing was heard from {self._link.url} for {silent:.1f} s")


class RosRobot(StopOnExit):
    """A robot behind rosbridge; to be used as a context manager.

    A connection that is lost is made again as the settings say, and the action that was interrupted is carried out
    anew from where the odometry says that the robot is. If the odometry does not go on where it was, because the
    base was started anew or carried away, the robot goes on from where it stands, and the action counts as one that
    did not move it.

    Args:
        url: of the bridge, such as ws://192.168.0.5:9090.
        settings: what the robot is like, see `ros_settings_file.load_config`.

    Raises:
        RosError: if it cannot be reached, or sends no images or odometry.
    """

    def __init__(self, url: str, settings: RosConfig) -> None:
        self.settings = settings
        self._link = Link(url, settings)
        self._base = RosBase(self._link, settings)
        self._driver = MotionController(self._base, settings.limits, settings.step, settings.turn)
        self._tilt = nearest_tilt(settings.tilts, 0.0)
        self._still = -math.inf
        atexit.register(self.stop)
        try:
            self._link.open()
            self._aim()
        except BaseException:
            self.close()
            raise

    @property
    def actions(self) -> tuple[Action, ...]:
        """Those of the settings."""
        return self.settings.policy_actions

    def look(self) -> NDArray[np.uint8]:
        """The newest square view that was taken after the last motion ended, (S, S, 3) uint8 RGB.

        Raises:
            RosError: if none comes in time, or the connection is lost and cannot be made again.
        """
        try:
            return self._look()
        except ConnectionLost as lost:
            self.reconnect(lost)
            with _for_the_last_time():
                return self._look()
        except BaseException:
            self.stop()
            raise

    def execute(self, action: Action) -> bool:
        """Carry out one action.

        Returns:
            Whether the robot moved; not if its way is blocked, it cannot look further up or down, or its odometry
            began anew.

        Raises:
            MotionError: if the motion exceeds a limit.
            RosError: if the robot has no such action, images are too old, or the connection is lost for good.
        """
        check_action(action, self.actions, RosError)
        moved = self._insist(lambda: self._carry_out(action))
        if moved is None:
            LOG.warning("the odometry began anew; the robot goes on from where it stands")
            self._driver.plan = None
            return False
        return moved

    @property
    def tilts(self) -> tuple[float, ...]:
        """Degrees: those of the settings."""
        return self.settings.tilts

    def go_to(self, x: float, z: float, heading: float, tilt: float) -> bool:
        """Drive to a point as seen from where it began; see `NavigatingRobot.go_to`.

        Raises:
            MotionError: if a motion exceeds a limit.
            RosError: if images are too old, the connection is lost for good, or the odometry began anew, so that
                nobody knows where the robot is.
        """
        arrived = self._insist(lambda: self._moved(lambda: self._travel_to(x, z, heading, tilt)))
        if arrived is None:
            self._driver.plan = None  # whatever it does next, it does not drive to where it was planned to be
            raise RosError(
                "the odometry began anew, so the robot does not know where it is: put it back to where it began, and "
                "begin again from there"
            )
        return arrived

    def pose(self) -> tuple[float, float, float, float] | None:
        """x, z, heading by the odometry, from where that began, and the tilt; None before the first odometry."""
        if self._link.wheels.newest is None:
            return None
        x, z, heading = self._link.wheels.newest
        return x, z, heading % 360, self.settings.tilts[self._tilt]

    def stop(self) -> None:
        """Publish zero velocity, more than once. Without a connection the base has to stop by itself."""
        for _ in range(STOPS):
            self._link.drive(0.0, 0.0)
            if self._link.lost is not None:
                return
            time.sleep(BETWEEN_STOPS)

    def reconnect(self, cause: ConnectionLost | None = None) -> None:
        """Make the connection anew, in as many attempts as the settings say.

        Args:
            cause: why; named if it does not succeed.

        Raises:
            ConnectionLost: if it does not succeed.
        """
        patience = self.settings.connection
        last: RosError | None = cause
        for attempt in range(1, patience.attempts + 1):
            LOG.warning("%s; connecting anew, attempt %d of %d", last or "asked to", attempt, patience.attempts)
            try:
                self._link.open()
            except RosError as error:
                last = error
                if attempt < patience.attempts:
                    time.sleep(patience.pause)
                continue
            self.stop()
            self._aim()
            return
        tried = f", and {patience.attempts} attempts to connect anew failed ({last})" if patience.attempts else ""
        raise ConnectionLost(f"{cause or 'no connection'}{tried}; {STILL_MOVES}") from cause

    def close(self) -> None:
        """Stop the robot and give up the connection."""
        self.stop()
        self._link.close()
        atexit.unregister(self.stop)

    def _insist(self, motion: Callable[[], bool]) -> bool | None:
        """Carry out a motion, again if the connection was lost; None if the odometry did not go on where it was."""
        before = self._link.wheels.newest
        try:
            return motion()
        except ConnectionLost as lost:
            before = self._link.wheels.newest or before
            self.reconnect(lost)
            with _for_the_last_time():
                return motion() if before is not None and self._goes_on(before) else None

    def _carry_out(self, action: Action) -> bool:
        if action in LOOK:
            return self._moved(lambda: self._tilt_by(LOOK[action]))
        return self._moved(lambda: self._driver.execute(action))

    def _moved(self, motion: Callable[[], bool]) -> bool:
        """Carry out a motion; stop if it fails, and let a picture settle after it."""
        try:
            return motion()
        except BaseException:
            self.stop()
            raise
        finally:
            self._still = max(self._still, time.monotonic() + self.settings.settle)

    def _travel_to(self, x: float, z: float, heading: float, tilt: float) -> bool:
        if not self._driver.travel_to(x, z, heading):
            return False
        wanted = nearest_tilt(self.tilts, tilt)
        return wanted == self._tilt or self._tilt_by(wanted - self._tilt)

    def _tilt_by(self, steps: int) -> bool:
        self._base.check()
        wanted = self._tilt + steps
        if not 0 <= wanted < len(self.settings.tilts):
            return False
        self._tilt = wanted
        self._aim()
        return True

    def _aim(self) -> None:
        """Publish the angles of the camera's joints; what is seen before they are there does not count."""
        settings = self.settings
        for joint, degrees in ((settings.tilt, settings.tilts[self._tilt]), (settings.pan, 0.0)):
            if joint is not None:
                self._link.aim(joint, degrees)
                self._still = max(self._still, time.monotonic() + joint.seconds + settings.settle)

    def _look(self) -> NDArray[np.uint8]:
        camera, max_image_age = self._link.camera, self.settings.camera.max_image_age
        deadline = max(time.monotonic(), self._still) + max_image_age
        while True:
            self._base.check()
            if camera.taken >= self._still and camera.age() <= max_image_age:
                assert camera.newest is not None
                return camera.newest
            if time.monotonic() > deadline:
                self._base.check_heard(max_image_age)
                raise RosError(
                    f"there is no image newer than {camera.age():.1f} s ('max_image_age' is {max_image_age:g} s): "
                    f"{camera.trouble()}; the robot was stopped: check its camera and the network"
                )
            time.sleep(0.01)

    def _goes_on(self, before: tuple[float, float, float]) -> bool:
        """Whether the odometry after a new connection is where it can be if it was there before."""
        after, limits = self._link.wheels.newest, self.settings.limits
        assert after is not None
        turned = abs(signed_angle(after[2] - before[2]))
        return (
            math.hypot(after[0] - before[0], after[1] - before[1]) <= limits.speed * STOPPED_AFTER + METRES_OFF
            and turned <= limits.angular_velocity * STOPPED_AFTER + DEGREES_OFF
        )


@contextmanager
def _for_the_last_time() -> Iterator[None]:
    """A connection that is lost in the block is not made again; say what to do."""
    try:
        yield
    except ConnectionLost as lost:
        raise ConnectionLost(f"{lost}, once more in the same action; {STILL_MOVES}") from lost
