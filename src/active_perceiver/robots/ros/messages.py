"""What rosbridge's JSON means: images and odometry in, velocities and angles out. Nothing here needs ROS.

ROS counts x ahead, y to the left and angles counter-clockwise (REP 103); here x is to the right, z ahead, and
headings are clockwise: x = -y_ros, z = x_ros, heading = -yaw.
"""

from __future__ import annotations

import base64
import io
import math
from typing import Any

import numpy as np
from numpy.typing import NDArray
from PIL import Image

Message = dict[str, Any]


def stamp_of(message: Message) -> float | None:
    """Seconds of the robot's clock in a message's header; None if the stamp was left at zero.

    Raises:
        KeyError, TypeError, ValueError: if there is no such header.
    """
    stamp = message["header"]["stamp"]
    # ROS 1 says secs and nsecs, ROS 2 sec and nanosec.
    seconds = stamp["secs"] if "secs" in stamp else stamp["sec"]
    parts = stamp["nsecs"] if "nsecs" in stamp else stamp["nanosec"]
    time = float(seconds) + 1e-9 * float(parts)
    if not math.isfinite(time):
        raise ValueError("its stamp is no number")
    return time or None


def view_of(message: Message, crop: float) -> NDArray[np.uint8]:
    """The square from the middle of a CompressedImage.

    Args:
        message: a sensor_msgs/CompressedImage with JPEG or PNG.
        crop: side of the square as a share of the image's shorter side.

    Returns:
        (S, S, 3) uint8 RGB.

    Raises:
        Exception: whatever decoding a broken image raises.
    """
    data = message["data"]
    encoded = base64.b64decode(data, validate=True) if isinstance(data, str) else bytes(data)
    with Image.open(io.BytesIO(encoded), formats=("JPEG", "PNG")) as image:
        width, height = image.size
        side = max(1, round(crop * min(width, height)))
        left, top = (width - side) // 2, (height - side) // 2
        return np.array(image.convert("RGB").crop((left, top, left + side, top + side)))


def place_of(message: Message) -> tuple[float, float, float]:
    """x, z in metres and heading in degrees clockwise, in -180..180, of a nav_msgs/Odometry.

    Raises:
        KeyError, TypeError, ValueError: if it is none.
    """
    pose = message["pose"]["pose"]
    x, y = float(pose["position"]["x"]), float(pose["position"]["y"])
    turn = {axis: float(pose["orientation"][axis]) for axis in "xyzw"}
    if not all(math.isfinite(value) for value in (x, y, *turn.values())):
        raise ValueError("it holds what is no number")
    if not 0.5 < sum(value**2 for value in turn.values()) < 2:
        raise ValueError("its orientation is no unit quaternion")
    yaw = math.atan2(2 * (turn["w"] * turn["z"] + turn["x"] * turn["y"]), 1 - 2 * (turn["y"] ** 2 + turn["z"] ** 2))
    return -y + 0.0, x, -math.degrees(yaw) + 0.0


def velocity_message(speed: float, angular_velocity: float, stamped: bool) -> Message:
    """A geometry_msgs/Twist, or TwistStamped.

    Args:
        speed: metres per second ahead.
        angular_velocity: degrees per second clockwise.
        stamped: whether a TwistStamped.
    """
    twist = {
        "linear": {"x": speed, "y": 0.0, "z": 0.0},
        "angular": {"x": 0.0, "y": 0.0, "z": -math.radians(angular_velocity) + 0.0},
    }
    # The bridge stamps a header that comes without a stamp, by the robot's clock.
    return {"header": {"frame_id": ""}, "twist": twist} if stamped else twist


def velocity_of(message: Message) -> tuple[float, float]:
    """Speed and turning of a Twist or TwistStamped, the reverse of `velocity_message`.

    Raises:
        KeyError, TypeError, ValueError: if it is neither.
    """
    twist = message.get("twist", message)
    return float(twist["linear"]["x"]), -math.degrees(float(twist["angular"]["z"])) + 0.0


def image_message(encoded: bytes, stamp: float) -> Message:
    """A sensor_msgs/CompressedImage of a JPEG; the stamp is in seconds of the robot's clock."""
    header = {"stamp": _stamp(stamp), "frame_id": "camera"}
    return {"header": header, "format": "jpeg", "data": base64.b64encode(encoded).decode()}


def odometry_message(x: float, z: float, heading: float, stamp: float) -> Message:
    """A nav_msgs/Odometry, the reverse of `place_of`; its velocities are left out.

    Args:
        x: metres to the right of where the odometry began.
        z: metres ahead of there.
        heading: degrees clockwise.
        stamp: seconds of the robot's clock.
    """
    half = -math.radians(heading) / 2
    orientation = {"x": 0.0, "y": 0.0, "z": math.sin(half), "w": math.cos(half)}
    pose = {"position": {"x": z, "y": -x, "z": 0.0}, "orientation": orientation}
    return {
        "header": {"stamp": _stamp(stamp), "frame_id": "odom"},
        "child_frame_id": "base_footprint",
        "pose": {"pose": pose},
    }


def _stamp(seconds: float) -> Message:
    whole = math.floor(seconds)
    return {"secs": whole, "nsecs": int((seconds - whole) * 1e9)}
