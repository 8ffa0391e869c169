"""What the labelling page's server answers.

The page and its files; `/api/scene`, all that is known of the scene; `/view/N`, `/thumbnail/N` and `/picture/T/K`,
images; and, posted as JSON, `/api/change` and `/api/save`. Other web sites that are open in the same browser must
neither read nor write here: requests are answered only under a name that no stranger can make point to this machine,
posts only from the page itself, and no request without limit.
"""

from __future__ import annotations

import json
from collections.abc import Callable
from http import HTTPStatus
from http.server import BaseHTTPRequestHandler
from pathlib import Path
from typing import TYPE_CHECKING, Any
from urllib.parse import urlsplit

from active_perceiver.errors import UserError
from active_perceiver.labelling.label_store import ChangedMeanwhileError
from active_perceiver.labelling.view_labels import LabelError, ViewLabels
from active_perceiver.scenes import ImageError, decode_image
from active_perceiver.scenes.images import encode_image, image_suffix
from active_perceiver.utils.json_reader import parse_json

if TYPE_CHECKING:
    from active_perceiver.labelling.server import LabellingServer

PAGE = Path(__file__).parent / "page"
CONTENT_TYPES = {
    "html": "text/html; charset=utf-8",
    "js": "text/javascript; charset=utf-8",
    "css": "text/css; charset=utf-8",
    "webp": "image/webp",
    "jpg": "image/jpeg",
    "png": "image/png",
}
PAGE_FILES = {
    "/": "index.html",
    **{f"/{path.name}": path.name for path in PAGE.iterdir() if path.suffix[1:] in CONTENT_TYPES},
}
LARGEST_POST = 256 * 1024
"""Bytes; a change of a view with boxes of a thousand targets is smaller."""
HEADERS = {
    "Content-Security-Policy": "default-src 'none'; script-src 'self'; style-src 'self'; connect-src 'self'; "
    "img-src 'self' data:; base-uri 'none'; form-action 'none'; frame-ancestors 'none'",
    "Cross-Origin-Resource-Policy": "same-origin",
    "Referrer-Policy": "no-referrer",
    "X-Content-Type-Options": "nosniff",
}
POSTED_FIELDS = {"/api/change": {"scene", "view", "before", "after"}, "/api/save": {"scene"}}


class _Refusal(Exception):
    """A request that is answered with an error."""

    def __init__(self, status: HTTPStatus, message: str, **more: Any) -> None:
        super().__init__(message)
        self.status = status
        self.body = {"error": message, **more}


class Handler(BaseHTTPRequestHandler):
    """Answers one connection."""

    server: LabellingServer
    protocol_version = "HTTP/1.1"
    server_version = "ActivePerceiver"
    sys_version = ""
    timeout = 60.0

    def do_GET(self) -> None:
        """Called by the base class."""
        self._answer(self._get)

    def do_POST(self) -> None:
        """Called by the base class."""
        self._answer(self._post)

    def log_message(self, format: str, *args: object) -> None:
        """Say nothing: what matters is on the page."""

    def _answer(self, method: Callable[[str], tuple[str, bytes]]) -> None:
        status = HTTPStatus.OK
        try:
            if not self.server.is_known_as(self.headers.get("Host", "")):
                raise _Refusal(HTTPStatus.FORBIDDEN, f"this server is at {self.server.url}; open the page there")
            kind, body = method(urlsplit(self.path).path)
        except _Refusal as refusal:
            status, (kind, body) = refusal.status, _json(refusal.body)
            self.close_connection = True  # what was posted may not have been read
        except UserError as error:
            status, (kind, body) = HTTPStatus.INTERNAL_SERVER_ERROR, _json({"error": str(error)})
        self.send_response(status)
        for name, value in {"Content-Type": kind, "Content-Length": str(len(body)), **HEADERS}.items():
            self.send_header(name, value)
        # Images of a scene never change, but another scene may be served at the same place later.
        self.send_header("Cache-Control", "max-age=86400" if "?" in self.path and status == 200 else "no-store")
        if self.close_connection:
            self.send_header("Connection", "close")
        self.end_headers()
        self.wfile.write(body)

    def _get(self, path: str) -> tuple[str, bytes]:
        if path in PAGE_FILES:
            name = PAGE_FILES[path]
            return CONTENT_TYPES[name.rpartition(".")[2]], (PAGE / name).read_bytes()
        if path == "/api/scene":
            return _json(self.server.description())
        scene = self.server.labelling.scene
        match path.strip("/").split("/"):
            case ["view", view]:
                return _image(scene.views[_number(view, len(scene))])
            case ["thumbnail", view]:
                return _image(self.server.thumbnail(_number(view, len(scene))))
            case ["picture", target, picture]:
                pictures = scene.targets[_number(target, len(scene.targets))].pictures
                return _image(pictures[_number(picture, len(pictures))])
        raise _Refusal(HTTPStatus.NOT_FOUND, f"there is nothing at {path}")

    def _post(self, path: str) -> tuple[str, bytes]:
        labelling = self.server.labelling
        posted = self._posted(path)
        if posted["scene"] != labelling.scene.content_hash:
            raise _Refusal(HTTPStatus.GONE, f"{labelling.path.name} is labelled here now; load the page again")
        if path == "/api/save":
            return _json({"saved": labelling.save(), "unsaved": labelling.unsaved})
        if type(posted["view"]) is not int:
            raise _Refusal(HTTPStatus.BAD_REQUEST, "a view is given by its number")
        try:
            before, after = (
                ViewLabels.from_json(posted[name], labelling.scene.target_names) for name in ("before", "after")
            )
            _number(str(posted["view"]), len(labelling.scene))
        except LabelError as error:
            raise _Refusal(HTTPStatus.BAD_REQUEST, str(error)) from None
        try:
            labelling.change(posted["view"], before, after)
        except ChangedMeanwhileError as error:
            raise _Refusal(HTTPStatus.CONFLICT, str(error), current=error.current.as_json()) from None
        return _json({"unsaved": labelling.unsaved})

    def _posted(self, path: str) -> dict[str, Any]:
        """What was posted, if it is from the page itself and in order."""
        if path not in POSTED_FIELDS:
            raise _Refusal(HTTPStatus.NOT_FOUND, f"nothing can be posted to {path}")
        if self.headers.get("Origin") != f"http://{self.headers.get('Host')}":
            raise _Refusal(HTTPStatus.FORBIDDEN, "only the labelling page itself may post here")
        if self.headers.get_content_type() != "application/json":
            raise _Refusal(HTTPStatus.UNSUPPORTED_MEDIA_TYPE, "what is posted here is application/json")
        length = self.headers.get("Content-Length", "")
        if not (length.isascii() and length.isdigit()) or "Transfer-Encoding" in self.headers:
            raise _Refusal(HTTPStatus.LENGTH_REQUIRED, "say how long it is, in Content-Length")
        if len(length) > 9 or int(length) > LARGEST_POST:
            raise _Refusal(HTTPStatus.REQUEST_ENTITY_TOO_LARGE, f"{LARGEST_POST} bytes are the most at once")
        try:
            posted = parse_json(self.rfile.read(int(length)))
        except ValueError:
            raise _Refusal(HTTPStatus.BAD_REQUEST, "what was posted is not JSON") from None
        if not isinstance(posted, dict) or posted.keys() != POSTED_FIELDS[path]:
            fields = ", ".join(sorted(POSTED_FIELDS[path]))
            raise _Refusal(HTTPStatus.BAD_REQUEST, f"what is posted to {path} are {fields}")
        return posted


def _json(value: dict[str, Any]) -> tuple[str, bytes]:
    return "application/json", json.dumps(value).encode()


def _image(data: bytes) -> tuple[str, bytes]:
    try:
        return CONTENT_TYPES[image_suffix(data)], data
    except ImageError:  # of another kind, which browsers may not know
        return CONTENT_TYPES["png"], encode_image(decode_image(data), "png")


def _number(text: str, count: int) -> int:
    if not (text.isascii() and text.isdigit() and len(text) < 10 and int(text) < count):
        raise _Refusal(HTTPStatus.NOT_FOUND, f"there is no number {text}; there are {count}")
    return int(text)
