"""The connection to a robot's rosbridge: the newest image and odometry, how old they are, and what is published.

roslibpy, extra `ros`, carries it. It would connect again by itself, without end, and send then what was to be sent in
between; for a robot that is the wrong moment. So a connection that is lost stays lost here, until `open` makes a new
one.
"""

from __future__ import annotations

import contextlib
import json
import logging
import threading
import time
from collections.abc import Callable
from typing import Any, Generic, TypeVar

import numpy as np
from numpy.typing import NDArray

from active_perceiver.errors import UserError
from active_perceiver.robots.ros.config import Camera, Joint, RosConfig, Velocity, Wheels, same_type
from active_perceiver.robots.ros.messages import Message, place_of, stamp_of, velocity_message, view_of

# Share by which two clocks may drift apart unnoticed; with more, messages seem to get older and older.
DRIFT = 0.001
# Seconds to wait for rosapi, which not every bridge has.
ROSAPI = 1.0
# Seconds to wait for the other side to close.
GOODBYE = 1.0

Value = TypeVar("Value")


class RosError(UserError, RuntimeError):
    """What came from the robot cannot be worked with; the robot was stopped. The message says why and what to do."""


class ConnectionLost(RosError):
    """The robot cannot be reached any more; its base has to stop by itself, see docs/robot.md, 1."""


class Stream(Generic[Value]):
    """What comes on a topic: the newest message that could be read.

    Args:
        topic: its settings.
        read: makes a value of a message; whatever it raises counts as a message that cannot be read.
        stamps: whether the headers tell how old messages are.

    Attributes:
        newest: the value of the newest message; None before the first.
        taken: seconds of our monotonic clock when that was measured, as far as is known.
        repeated: how many messages came since then with a stamp that was not newer.
        broken: how many came since then that could not be read, and `why` the last one could not.
    """

    def __init__(self, topic: Camera | Wheels, read: Callable[[Message], Value], stamps: bool) -> None:
        self.topic = topic
        self.newest: Value | None = None
        self.taken = -np.inf
        self.repeated = self.broken = 0
        self.why = ""
        self._read, self._stamps = read, stamps
        self._received = 0.0
        self._stamp: float | None = None
        self._least = np.inf

    def receive(self, message: Message) -> None:
        """Take a message."""
        now = time.monotonic()
        try:
            stamp = stamp_of(message)
            value = self._read(message)
        except Exception as error:  # garbage makes decoders raise anything
            self.broken, self.why = self.broken + 1, _reason(error)
            return
        if stamp is not None and self._stamp is not None and stamp <= self._stamp:
            self.repeated += 1
            return
        taken = now
        if stamp is not None and self._stamps:
            # The clocks need not agree: the message that was under way for the shortest time is taken as new.
            self._least = min(self._least + DRIFT * (now - self._received), now - stamp)
            taken = stamp + self._least
        self._stamp, self._received = stamp, now
        self.repeated = self.broken = 0
        self.newest, self.taken = value, taken

    def age(self) -> float:
        """Seconds since the newest message was measured."""
        return time.monotonic() - self.taken

    def trouble(self) -> str:
        """What came instead of newer messages, as the end of a sentence."""
        if self.broken:
            return f"{self.broken} messages came on {self.topic.topic} that cannot be read ({self.why})"
        if self.repeated:
            return f"the same message comes on {self.topic.topic} again and again, its stamp stands still"
        return f"nothing new comes on {self.topic.topic}"


class Link:
    """A connection to rosbridge.

    Args:
        url: such as ws://192.168.0.5:9090.
        settings: topics and patience.

    Attributes:
        url: as given.
        lost: why there is no connection; None while there is one.
        camera: images, (S, S, 3) uint8 RGB.
        wheels: x, z in metres, heading in degrees clockwise.
        heard: seconds of our monotonic clock when the last message of any kind came.

    Raises:
        RosError: if roslibpy is not installed, or the address is none.
    """

    def __init__(self, url: str, settings: RosConfig) -> None:
        if not url.startswith(("ws://", "wss://")):
            raise RosError(f"'{url}' is no address of a rosbridge; give ws://HOST:PORT, the port is mostly 9090")
        try:
            import roslibpy
        except ImportError as error:
            raise RosError(
                f"roslibpy cannot be imported ({error}); install it: pip install 'active-perceiver[ros]'"
            ) from None
        # Both write tracebacks where nobody asked for a log.
        for name in ("roslibpy", "twisted"):
            logging.getLogger(name).addHandler(logging.NullHandler())
        self.url, self.settings = url, settings
        self.lost: str | None = "it was never made"
        self._ros = roslibpy
        self._client: Any = None
        self._said = ""
        self._begin()

    def _begin(self) -> None:
        crop, stamps = self.settings.camera.crop, self.settings.stamps
        self.camera: Stream[NDArray[np.uint8]] = Stream(
            self.settings.camera, lambda message: view_of(message, crop), stamps
        )
        self.wheels: Stream[tuple[float, float, float]] = Stream(self.settings.odometry, place_of, stamps)
        self.heard = time.monotonic()
        self._publish: dict[str, Any] = {}
        self._said = ""

    def open(self) -> None:
        """Connect, stop the base, subscribe, and wait for the first image and odometry.

        Raises:
            ConnectionLost: if the bridge cannot be reached.
            RosError: if no image or odometry comes, or a topic is of another type.
        """
        self.close()
        self._begin()
        timeout = self.settings.connection.timeout
        deadline = time.monotonic() + timeout
        ready, closed = threading.Event(), threading.Event()
        client = self._client = self._ros.Ros(self.url, transport="twisted")
        client.factory.maxRetries = 0
        client.on("close", lambda _: closed.set())
        client.factory.on_ready(lambda connection: self._listen(connection, ready))
        client.factory.manager.run()
        while not ready.wait(0.01):
            # An attempt that has failed says so nowhere but in its state.
            connector = client.factory.connector
            refused = closed.is_set() or (connector is not None and connector.state == "disconnected")
            if refused or time.monotonic() > deadline:
                self.close()
                how = "it refused" if refused else f"it did not answer within {timeout:g} s"
                raise ConnectionLost(
                    f"no rosbridge could be reached at {self.url} ({how}); check the address and that "
                    "rosbridge_server runs on the robot"
                )
        self.lost = None
        client.on("close", lambda _: self._lose(client, "it was closed"))
        if closed.is_set():
            self._lose(client, "it was closed")
        self._check_types()
        self._subscribe()
        while self.camera.newest is None or self.wheels.newest is None:
            # A base that was driving when the connection was lost must not have to wait for its camera to be stopped.
            # Sent more than once: the first may come before the base listens to a new publisher.
            self.drive(0.0, 0.0)
            if self.lost is not None or time.monotonic() > deadline:
                error = self._nothing_came(timeout)
                self.close()
                raise error
            time.sleep(0.02)

    def close(self) -> None:
        """Give the connection up; what was published before is sent. Safe at any time."""
        client, self._client = self._client, None
        was_open = self.lost is None
        self.lost = self.lost or "it was given up"
        if client is None:
            return
        if was_open:
            gone = threading.Event()
            client.on("close", lambda _: gone.set())
            with contextlib.suppress(TimeoutError):
                client.close(timeout=GOODBYE)
            gone.wait(GOODBYE)
        connector = client.factory.connector
        if connector is not None and connector.state != "disconnected":
            client.call_later(0, connector.disconnect)

    def drive(self, speed: float, angular_velocity: float) -> None:
        """Publish a velocity; see `ros_messages.velocity_message`. Without a connection nothing happens."""
        velocity = self.settings.velocity
        self._send(velocity, velocity_message(speed, angular_velocity, velocity.stamped))

    def aim(self, joint: Joint, degrees: float) -> None:
        """Publish a joint's angle. Without a connection nothing happens."""
        self._send(joint, {"data": joint.value(degrees)})

    def _send(self, topic: Velocity | Joint, message: Message) -> None:
        publisher = self._publish.get(topic.topic)
        if self.lost is None and publisher is not None:
            publisher.publish(self._ros.Message(message))

    def _lose(self, client: Any, why: str) -> None:
        if client is self._client and self.lost is None:
            self.lost = why

    def _listen(self, connection: Any, ready: threading.Event) -> None:
        """Count what roslibpy cannot read, which it only logs, and keep what the bridge says of its troubles."""
        read = connection.on_message

        def on_message(payload: bytes) -> None:
            self.heard = time.monotonic()
            try:
                read(payload)
            except Exception:
                self._not_read(payload)

        connection.on_message = on_message
        ready.set()

    def _not_read(self, payload: bytes) -> None:
        try:
            message = json.loads(payload)
            status = message["op"] == "status"
        except (ValueError, KeyError, TypeError):
            for stream in (self.camera, self.wheels):
                stream.broken, stream.why = stream.broken + 1, "not JSON of the rosbridge protocol"
            return
        if status:
            self._said = str(message.get("msg", ""))[:200]

    def _topics(self) -> tuple[Camera | Velocity | Wheels | Joint, ...]:
        settings = self.settings
        joints = tuple(joint for joint in (settings.tilt, settings.pan) if joint is not None)
        return (settings.camera, settings.odometry, settings.velocity, *joints)

    def _check_types(self) -> None:
        """Ask rosapi for the types: a velocity of another type moves nothing, and nobody says so."""
        service = self._ros.Service(self._client, "/rosapi/topic_type", "rosapi/TopicType")
        for topic in self._topics():
            answered = threading.Event()
            answer: Message = {}

            def take(values: Any, answer: Message = answer, answered: threading.Event = answered) -> None:
                answer.update(values if isinstance(values, dict) else getattr(values, "data", {}))
                answered.set()

            service.call(self._ros.ServiceRequest({"topic": topic.topic}), take, take)
            if not answered.wait(ROSAPI):
                return
            kind = answer.get("type")
            if isinstance(kind, str) and kind and not same_type(kind, topic.type):
                self.close()
                raise RosError(
                    f"{topic.topic} is of type {kind} on the robot, but the settings say {topic.type}; correct "
                    "'type' or 'topic' there"
                )

    def _subscribe(self) -> None:
        between = round(1000 / self.settings.camera.rate)
        for stream, throttle in ((self.camera, between), (self.wheels, 0)):
            # Of what waits only the newest is wanted.
            topic = self._ros.Topic(
                self._client, stream.topic.topic, stream.topic.type, throttle_rate=throttle, queue_length=1,
                reconnect_on_close=False,
            )  # fmt: skip
            topic.subscribe(stream.receive)
        for one in self._topics()[2:]:
            # A joint's angle is published once; latched, it reaches a controller that subscribes a moment later.
            latch = isinstance(one, Joint)
            self._publish[one.topic] = self._ros.Topic(
                self._client, one.topic, one.type, latch=latch, queue_size=1, reconnect_on_close=False
            )
            self._publish[one.topic].advertise()

    def _nothing_came(self, timeout: float) -> RosError:
        if self.lost is not None:
            return ConnectionLost(f"the connection to {self.url} was lost at once ({self.lost}); start again")
        missing = self.camera if self.camera.newest is None else self.wheels
        what = "image" if missing is self.camera else "odometry"
        said = f"; the bridge says: {self._said}" if self._said else ""
        return RosError(
            f"no {what} came within {timeout:g} s: {missing.trouble()}{said}; check 'topic' and 'type' "
            f"({missing.topic.type}) in the settings, and on the robot that something publishes it"
        )


def _reason(error: Exception) -> str:
    if isinstance(error, KeyError):
        return f"it has no {error}"
    return (str(error).strip().splitlines() or [type(error).__name__])[0][:100]
