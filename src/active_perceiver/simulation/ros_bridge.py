"""A simulated body behind a real rosbridge: a WebSocket server that publishes a camera and odometry, and is driven.

It speaks what `RosRobot` and other clients of rosbridge need, in JSON: advertise, publish, subscribe with
throttle_rate, unsubscribe, call_service of /rosapi/topic_type, and status when a type is wrong; see
https://github.com/RobotWebTools/rosbridge_suite/blob/ros1/ROSBRIDGE_PROTOCOL.md. As a real base it stops when no
velocity comes. And it can fail as real ones do: `drop`, `hush`, `freeze_camera`, `delay_odometry`, `garbage`.
"""

from __future__ import annotations

import asyncio
import contextlib
import io
import json
import threading
import time
from collections.abc import Callable
from types import TracebackType
from typing import Any

import numpy as np
from numpy.typing import NDArray
from PIL import Image
from typing_extensions import Self

from active_perceiver.robots.ros.config import RosConfig, same_type
from active_perceiver.robots.ros.connection import RosError
from active_perceiver.robots.ros.messages import Message, image_message, odometry_message, velocity_of
from active_perceiver.simulation.diff_drive import DiffDriveSim

View = Callable[[float, float, float, float], NDArray[np.uint8]]

# Seconds after which the base stops if no velocity comes, as a Kobuki does.
WATCHDOG = 0.6
# Seconds between two steps of the body and two messages of odometry.
STEP, ODOMETRY = 0.01, 0.05
# At most so many seconds pass at once for the body: on a busy machine it becomes slower instead of jumping.
JUMP = 0.05
# Degrees per second of the camera's tilt joint.
TILTING = 90.0
# The beginning of a message on a topic, and what nothing can be made of.
PUBLISH = '{{"op": "publish", "topic": "{}", "msg": '
STAMP = '"header": {{"stamp": {{"secs": 1, "nsecs": 0}}}}'
GARBAGE = (
    "no JSON at all",
    '{{"no": "op"}}',
    PUBLISH + "7}}",
    PUBLISH + "{{" + STAMP + ', "data": "%%%"}}}}',
    PUBLISH + "{{" + STAMP + ', "data": "/9j/4AAQ"}}}}',
    PUBLISH + '{{"header": {{"stamp": {{"secs": NaN, "nsecs": 0}}}}}}}}',
)


class SimulatedBridge:
    """Serves a body as a robot behind rosbridge, on this machine, in a thread; used as a context manager.

    Args:
        body: the robot; nobody else may drive it meanwhile.
        view: what the camera sees from x, z in metres, heading and tilt in degrees: (H, W, 3) uint8 RGB. Called in a
            thread of its own, one view at a time; slow views come less often.
        settings: topics, types, the tilt joint and the rate of the camera.
        speedup: how much faster than the clock the body's time runs; the watchdog's and the messages' does not.
        port: of the server; a free one if 0.

    Attributes:
        body: as given.
        url: of the server, once entered.
        tilt: degrees, of the camera's joint.
        velocity: the last one that came, metres per second and degrees per second clockwise.
        connections: how many clients have connected so far.

    Raises:
        RosError: when it is entered, if websockets is not installed or the port cannot be served.
    """

    def __init__(
        self, body: DiffDriveSim, view: View, settings: RosConfig, *, speedup: float = 1.0, port: int = 0
    ) -> None:
        self.body = body
        self.tilt = self._wanted_tilt = 0.0
        self.url = ""
        self.velocity = (0.0, 0.0)
        self.connections = 0
        self._view, self._settings, self._speedup, self._port = view, settings, speedup, port
        self._clients: dict[Any, _Client] = {}
        self._commanded = -np.inf
        self._closed_until = -np.inf
        self._frozen: Message | None = None
        self._camera_off = self._freeze = self._silent = False
        self._late = 0.0
        self._garbage: set[str] = set()
        self._last_image: Message | None = None
        self._loop = asyncio.new_event_loop()
        self._thread = threading.Thread(target=self._run, name="simulated bridge", daemon=True)
        self._started = threading.Event()
        self._failed: BaseException | None = None
        self._types = {one.topic: one.type for one in (settings.camera, settings.odometry, settings.velocity)}
        self._types |= {one.topic: one.type for one in (settings.tilt, settings.pan) if one is not None}

    def drop(self, seconds: float = 0.0) -> None:
        """Cut all connections, and accept none for so many seconds."""
        self._closed_until = time.monotonic() + seconds
        self._loop.call_soon_threadsafe(self._cut)

    def hush(self, silent: bool = True) -> None:
        """Send nothing any more, or again, as when a robot leaves the wireless network."""
        self._silent = silent

    def freeze_camera(self, frozen: bool = True, *, repeat: bool = True) -> None:
        """Send the newest image again and again, or with `repeat` off none; or go on."""
        self._freeze, self._camera_off = frozen and repeat, frozen and not repeat

    def delay_odometry(self, seconds: float) -> None:
        """Send odometry so much later than it was measured."""
        self._late = seconds

    def garbage(self, *topics: str) -> None:
        """Send on these topics what cannot be read; without topics, send sense again."""
        self._garbage = set(topics)

    def __enter__(self) -> Self:
        self._thread.start()
        self._started.wait()
        if self._failed is not None:
            raise self._failed
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._loop.call_soon_threadsafe(self._stopping.set)
        self._thread.join()
        self.body.drive(0.0, 0.0)

    def _run(self) -> None:
        try:
            self._loop.run_until_complete(self._serve())
        except BaseException as error:
            self._failed = error
        finally:
            self._started.set()
            self._loop.close()

    async def _serve(self) -> None:
        try:
            from websockets.asyncio.server import serve
        except ImportError as error:
            raise RosError(
                f"websockets cannot be imported ({error}); install it: pip install 'active-perceiver[ros]'"
            ) from None
        self._stopping = asyncio.Event()
        try:
            listening = await serve(
                self._talk, "127.0.0.1", self._port, compression=None, process_request=self._admit
            )
        except (OSError, OverflowError) as error:
            reason = getattr(error, "strerror", None) or error
            raise RosError(f"port {self._port} cannot be served ({reason}); give another one") from None
        async with listening as server:
            self.url = "ws://{}:{}".format(*next(iter(server.sockets)).getsockname()[:2])
            tasks = [asyncio.ensure_future(task) for task in (self._live(), self._film(), self._count())]
            self._started.set()
            await self._stopping.wait()
            for task in tasks:
                task.cancel()
            await asyncio.gather(*tasks, return_exceptions=True)
            self._cut()

    async def _live(self) -> None:
        """Let the body's time pass."""
        last = time.monotonic()
        while True:
            await asyncio.sleep(STEP)
            now = time.monotonic()
            if now - self._commanded > WATCHDOG:
                self.body.drive(0.0, 0.0)
            passed, last = min(now - last, JUMP) * self._speedup, now
            self.body.wait(passed)
            self.tilt += float(np.clip(self._wanted_tilt - self.tilt, -TILTING * passed, TILTING * passed))

    async def _film(self) -> None:
        camera = self._settings.camera
        due = time.monotonic()
        while True:
            due = max(due + 1 / camera.rate, time.monotonic())
            await asyncio.sleep(due - time.monotonic())
            pose, stamp = (self.body.x, self.body.z, self.body.heading, self.tilt), time.time()
            if self._freeze and self._last_image is not None:
                self._send(camera.topic, self._last_image)
            elif not self._camera_off:
                image = await asyncio.to_thread(self._view, *pose)
                self._last_image = image_message(_jpeg(image), stamp)
                self._send(camera.topic, self._last_image)

    async def _count(self) -> None:
        while True:
            await asyncio.sleep(ODOMETRY)
            at = self.body.odometry()
            message = odometry_message(at.x, at.z, at.heading, time.time())
            self._loop.call_later(self._late, self._send, self._settings.odometry.topic, message)

    def _send(self, topic: str, message: Message) -> None:
        from websockets.asyncio.server import broadcast

        if self._silent:
            return
        texts = [json.dumps({"op": "publish", "topic": topic, "msg": message})]
        if topic in self._garbage:
            texts = [text.format(topic) for text in GARBAGE]
        now = time.monotonic()
        wanting = [client for client in self._clients.values() if client.wants(topic, now)]
        for text in texts:
            broadcast([client.connection for client in wanting], text)

    def _admit(self, connection: Any, request: Any) -> Any:
        return connection.respond(503, "closed") if time.monotonic() < self._closed_until else None

    async def _talk(self, connection: Any) -> None:
        client = self._clients[connection] = _Client(connection)
        self.connections += 1
        try:
            async for text in connection:
                if not self._silent:
                    await self._hear(client, text)
        except Exception:  # whatever way a connection breaks, the base's watchdog stops the body
            with contextlib.suppress(Exception):
                await connection.close()
        finally:
            del self._clients[connection]

    async def _hear(self, client: _Client, text: str | bytes) -> None:
        try:
            message = json.loads(text)
            await getattr(self, f"_op_{message['op']}", self._op_unknown)(client, message)
        except (ValueError, KeyError, TypeError, AttributeError) as error:
            await client.say("error", f"{type(error).__name__} in {str(text)[:80]}: {error}")

    async def _op_unknown(self, client: _Client, message: Message) -> None:
        await client.say("error", f"unknown operation: {message['op']}")

    async def _op_set_level(self, client: _Client, message: Message) -> None:
        pass

    async def _op_advertise(self, client: _Client, message: Message) -> None:
        if await self._is_type(client, message):
            client.advertised.add(message["topic"])

    async def _op_unadvertise(self, client: _Client, message: Message) -> None:
        client.advertised.discard(message["topic"])

    async def _op_subscribe(self, client: _Client, message: Message) -> None:
        if await self._is_type(client, message):
            client.between[message["topic"]] = float(message.get("throttle_rate", 0)) / 1000

    async def _op_unsubscribe(self, client: _Client, message: Message) -> None:
        client.between.pop(message["topic"], None)

    async def _op_publish(self, client: _Client, message: Message) -> None:
        topic, settings = message["topic"], self._settings
        if topic not in client.advertised:
            await client.say("error", f"{topic} is not advertised")
        elif topic == settings.velocity.topic:
            self.velocity = velocity_of(message["msg"])
            self._commanded = time.monotonic()
            self.body.drive(*self.velocity)
        elif settings.tilt is not None and topic == settings.tilt.topic:
            self._wanted_tilt = settings.tilt.degrees(float(message["msg"]["data"]))

    async def _op_call_service(self, client: _Client, message: Message) -> None:
        known = message["service"] == "/rosapi/topic_type"
        values = {"type": self._types.get(message["args"]["topic"], "")} if known else {}
        answer = {"op": "service_response", "service": message["service"], "values": values, "result": known}
        await client.connection.send(json.dumps({**answer, "id": message.get("id")}))

    async def _is_type(self, client: _Client, message: Message) -> bool:
        topic, kind = message["topic"], message.get("type")
        right = self._types.get(topic)
        if right is None or kind is None or same_type(kind, right):
            return True
        await client.say("error", f"tried to use {topic} as {kind}, but it is {right}")
        return False

    def _cut(self) -> None:
        for connection in list(self._clients):
            connection.transport.abort()


class _Client:
    """One connection: what it wants, and may publish."""

    def __init__(self, connection: Any) -> None:
        self.connection = connection
        self.advertised: set[str] = set()
        self.between: dict[str, float] = {}
        self._sent: dict[str, float] = {}

    def wants(self, topic: str, now: float) -> bool:
        """Whether a message of this moment should be sent to it."""
        if topic not in self.between or now - self._sent.get(topic, -np.inf) < self.between[topic] - ODOMETRY / 2:
            return False
        self._sent[topic] = now
        return True

    async def say(self, level: str, text: str) -> None:
        """Send a status."""
        await self.connection.send(json.dumps({"op": "status", "level": level, "msg": text}))


def _jpeg(image: NDArray[np.uint8]) -> bytes:
    encoded = io.BytesIO()
    Image.fromarray(image).save(encoded, "JPEG", quality=90)
    return encoded.getvalue()
