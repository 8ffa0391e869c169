"""The labelling page's server: Python's own, for one person on the same machine."""

from __future__ import annotations

import ipaddress
import signal
import socket
import sys
from collections.abc import Callable
from functools import lru_cache
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from typing import Any
from urllib.parse import urlsplit

from active_perceiver.errors import UserError
from active_perceiver.labelling.label_store import Labelling
from active_perceiver.scenes import decode_image
from active_perceiver.scenes.images import encode_image, square_image

THUMBNAIL = 96
"""Side in pixels."""


class ServerError(UserError):
    """The server cannot be started; the message says why and what to do."""


class LabellingServer(ThreadingHTTPServer):
    """Serves the page on which one scene is labelled.

    Attributes:
        labelling: the scene.
        host: the name or address it was told to listen on.
        url: where the page is.
    """

    daemon_threads = True
    block_on_close = False

    def __init__(
        self, labelling: Labelling, handler: type[BaseHTTPRequestHandler], host: str = "127.0.0.1", port: int = 0
    ) -> None:
        """Begin to listen; `serve_forever` answers.

        Args:
            labelling: what is labelled.
            handler: answers requests, see `answers.Handler`.
            host: name or address to listen on.
            port: to listen on; 0 for any that is free.

        Raises:
            ServerError: if the port is taken or the host is not this machine.
        """
        self.labelling = labelling
        self.host = host
        self.thumbnail: Callable[[int], bytes] = lru_cache(4096)(self._thumbnail)
        if ":" in host:
            self.address_family = socket.AF_INET6
        try:
            super().__init__((host, port), handler)
        except (OSError, OverflowError) as error:
            raise ServerError(
                f"the page cannot be served on {host}, port {port} ({error}); give another --port, or 0 for any that "
                "is free"
            ) from None
        shown = f"[{host}]" if ":" in host else host
        self.url = f"http://{shown}:{self.server_address[1]}/"

    def server_bind(self) -> None:
        """Bind without asking a name server for this machine's name, which can take long."""
        self.socket.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        self.socket.bind(self.server_address)
        self.server_address = self.socket.getsockname()
        self.server_name, self.server_port = self.host, self.server_address[1]

    @property
    def is_local(self) -> bool:
        """Whether only this machine can reach it."""
        return ipaddress.ip_address(self.server_address[0]).is_loopback  # type: ignore[arg-type]

    def handle_error(self, request: Any, client_address: Any) -> None:
        """Say nothing of a browser that went away before it had its answer."""
        if not isinstance(sys.exc_info()[1], (ConnectionError, TimeoutError)):
            super().handle_error(request, client_address)

    def serve_until_interrupted(self) -> None:
        """Answer until Ctrl-C is pressed, the process is asked to end or its terminal is closed."""

        def interrupt(*_: object) -> None:
            raise KeyboardInterrupt

        signals = [getattr(signal, name) for name in ("SIGINT", "SIGTERM", "SIGHUP") if hasattr(signal, name)]
        before = {number: signal.signal(number, interrupt) for number in signals}
        try:
            self.serve_forever(poll_interval=0.2)
        except KeyboardInterrupt:
            pass
        finally:
            self.server_close()
            for number, handler in before.items():
                signal.signal(number, handler)

    def is_known_as(self, host: str) -> bool:
        """Whether a request for this host is meant for this server.

        A web site can make its own name point to any address (DNS rebinding), but it cannot own an address, nor
        `localhost`.

        Args:
            host: a `Host` header.
        """
        try:
            name = urlsplit(f"//{host}").hostname or ""
        except ValueError:
            return False
        if name in ("localhost", self.host.lower(), socket.gethostname().lower()):
            return True
        try:
            ipaddress.ip_address(name)
        except ValueError:
            return False
        return True

    def description(self) -> dict[str, Any]:
        """All that the page has to know of the scene, as plain data."""
        scene = self.labelling.scene
        return {
            "id": scene.content_hash,
            "name": scene.name,
            "file": self.labelling.path.name,
            "targets": [{"name": target.name, "pictures": len(target.pictures)} for target in scene.targets],
            "poses": scene.poses.tolist(),
            "views": [known.as_json() for known in self.labelling.views()],
            "unsaved": self.labelling.unsaved,
        }

    def _thumbnail(self, view: int) -> bytes:
        image = decode_image(self.labelling.scene.views[view], f"view {view}", THUMBNAIL)
        return encode_image(square_image(image, THUMBNAIL), "jpeg", 80)
