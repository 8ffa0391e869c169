"""Messages of ROS in JSON, there and back, and what is none."""

import base64
import io
import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from PIL import Image

from active_perceiver.robots.ros.config import Wheels
from active_perceiver.robots.ros.connection import Stream
from active_perceiver.robots.ros.messages import (
    image_message,
    odometry_message,
    place_of,
    stamp_of,
    velocity_message,
    velocity_of,
    view_of,
)

METRES = st.floats(-50, 50)


def encoded(image, form="JPEG"):
    out = io.BytesIO()
    Image.fromarray(image).save(out, form, quality=95)
    return out.getvalue()


@given(METRES, METRES, st.floats(-720, 720))
def test_odometry_there_and_back(x, z, heading):
    there = place_of(odometry_message(x, z, heading, 5.0))
    assert there[:2] == pytest.approx((x, z))
    assert abs((there[2] - heading + 180) % 360 - 180) < 1e-6


def test_the_axes_of_ros():
    # One metre ahead, two to the left, and turned to the left.
    message = odometry_message(0, 0, 0, 0)
    message["pose"]["pose"]["position"] = {"x": 1.0, "y": 2.0, "z": 0.0}
    half = math.radians(90) / 2
    message["pose"]["pose"]["orientation"] = {"x": 0.0, "y": 0.0, "z": math.sin(half), "w": math.cos(half)}
    assert place_of(message) == pytest.approx((-2, 1, -90))
    twist = velocity_message(0.2, 90.0, stamped=False)
    assert twist["linear"]["x"] == 0.2
    assert twist["angular"]["z"] == pytest.approx(-math.pi / 2)


@given(st.floats(-1, 1), st.floats(-180, 180), st.booleans())
def test_velocities_there_and_back(speed, angular_velocity, stamped):
    assert velocity_of(velocity_message(speed, angular_velocity, stamped)) == pytest.approx((speed, angular_velocity))


def test_the_view_is_the_square_in_the_middle():
    image = np.zeros((20, 40, 3), np.uint8)
    image[:, 10:30] = (200, 60, 20)
    view = view_of(image_message(encoded(image, "PNG"), 1.5), 1.0)
    assert view.shape == (20, 20, 3)
    assert (view == (200, 60, 20)).all()
    assert view_of(image_message(encoded(image), 1.5), 0.5).shape == (10, 10, 3)
    listed = {**image_message(b"", 0.0), "data": list(encoded(image, "PNG"))}
    np.testing.assert_array_equal(view_of(listed, 1.0), view)
    grey = view_of(image_message(encoded(image[..., 0]), 1.5), 1.0)
    assert grey.shape == (20, 20, 3)


@pytest.mark.parametrize(
    "data",
    ["%%%", "", 7, None, "aGVsbG8=", base64.b64encode(encoded(np.zeros((64, 64, 3), np.uint8))[:300]).decode()],
)
def test_images_that_are_none_raise(data):
    with pytest.raises(Exception):  # noqa: B017, PT011 - whatever decoding raises; `Stream` counts it
        view_of({"data": data}, 1.0)


def test_stamps_of_ros_1_and_2():
    assert stamp_of({"header": {"stamp": {"secs": 3, "nsecs": 500_000_000}}}) == 3.5
    assert stamp_of({"header": {"stamp": {"sec": 3, "nanosec": 500_000_000}}}) == 3.5
    assert stamp_of({"header": {"stamp": {"secs": 0, "nsecs": 0}}}) is None


def streamed(stamps=True):
    return Stream(Wheels("/odom"), place_of, stamps)


def test_a_stream_counts_what_is_broken_or_repeated_until_something_new_comes():
    stream = streamed()
    good = odometry_message(1, 2, 3, 100.0)
    broken = odometry_message(1, 2, 3, 101.0)
    broken["pose"]["pose"]["position"]["x"] = math.nan
    for message in (broken, {}, {"header": {"stamp": {"secs": "now", "nsecs": 0}}}, 7, None):
        stream.receive(message)
    assert stream.newest is None
    assert stream.broken == 5
    assert "5 messages came on /odom that cannot be read" in stream.trouble()
    stream.receive(good)
    assert stream.newest == pytest.approx((1, 2, 3))
    assert stream.broken == 0
    stream.receive(good)
    stream.receive(odometry_message(9, 9, 9, 99.0))
    assert stream.repeated == 2
    assert stream.newest == pytest.approx((1, 2, 3))
    assert "stamp stands still" in stream.trouble()


def test_the_age_of_a_message_comes_from_its_stamp_whatever_the_robots_clock_says():
    stream = streamed()
    for number in range(5):
        stream.receive(odometry_message(number, 0, 0, 5000.0 + number))
    # They all came at once: the first, measured four seconds before the last, was under way for the longest time.
    assert stream.age() < 1
    stream.receive(odometry_message(5, 0, 0, 5004.5))
    assert stream.newest[0] == 5
    late = streamed()
    late.receive(odometry_message(0, 0, 0, 5000.0))
    late.receive(odometry_message(0, 0, 0, 5000.1))
    assert late.age() < 1


def test_a_message_that_was_held_up_is_old(monkeypatch):
    now = [100.0]
    monkeypatch.setattr("active_perceiver.robots.ros.connection.time.monotonic", lambda: now[0])
    for stamps, age in ((True, 3.0), (False, 0.0)):
        stream = streamed(stamps)
        stream.receive(odometry_message(0, 0, 0, 5000.0))
        now[0] += 3.1
        # Measured a tenth of a second after the first, but three seconds under way.
        stream.receive(odometry_message(0, 0, 0, 5000.1))
        assert stream.age() == pytest.approx(age, abs=0.01)


def test_messages_without_stamps_are_as_old_as_their_arrival():
    stream = streamed()
    for x in (1, 2):
        stream.receive(odometry_message(x, 0, 0, 0.0))
    assert stream.newest[0] == 2
    assert stream.age() < 1
