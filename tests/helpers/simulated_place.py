"""A simulated robot in a small room of boxes, which is rendered in a blink."""

from functools import cache

from active_perceiver.capture.rendered.config import CaptureConfig
from active_perceiver.scenes import EIGHT_ACTIONS
from active_perceiver.simulation.diff_drive import NO_NOISE
from active_perceiver.simulation.room import LiveRoom
from active_perceiver.simulation.simulated_robot import SimulatedRobot
from box_room import box_room
from indoor_rooms.renderer.lighting import bake

SETTINGS = CaptureConfig(
    actions=EIGHT_ACTIONS, spacing=0.5, image_size=32, samples=1, tilts=(-30.0, 0.0, 30.0), bake_rays=4, bounces=1
)
# In the middle of a free stretch, looking along z.
START = (2.3, 1.5, 0.0, 0.0)


@cache
def small_room() -> LiveRoom:
    """The room of boxes with its light."""
    return LiveRoom("test_1", bake(box_room(), SETTINGS.bake_rays, SETTINGS.bounces, 0), SETTINGS, 0)


def simulated(start=START, odometry_noise=NO_NOISE, **options) -> SimulatedRobot:
    """A robot in it."""
    return SimulatedRobot(small_room(), start, odometry_noise=odometry_noise, **options)
