"""A simulated robot in a small room of boxes, which is rendered in a blink."""

from functools import cache

from active_perceiver.robots.body import NO_SLIP
from active_perceiver.robots.simulated import SimulatedRobot
from active_perceiver.rooms.capturing.capture_settings import CaptureSettings
from active_perceiver.rooms.engine.lighting import bake
from active_perceiver.rooms.live_room import LiveRoom
from active_perceiver.scenes import EIGHT_ACTIONS
from box_room import box_room

SETTINGS = CaptureSettings(
    actions=EIGHT_ACTIONS, spacing=0.5, image_size=32, samples=1, tilts=(-30.0, 0.0, 30.0), bake_rays=4, bounces=1
)
# In the middle of a free stretch, looking along z.
START = (2.3, 1.5, 0.0, 0.0)


@cache
def small_room() -> LiveRoom:
    """The room of boxes with its light."""
    return LiveRoom("test_1", bake(box_room(), SETTINGS.bake_rays, SETTINGS.bounces, 0), SETTINGS, 0)


def simulated(start=START, slip=NO_SLIP, **options) -> SimulatedRobot:
    """A robot in it."""
    return SimulatedRobot(small_room(), start, slip=slip, **options)
