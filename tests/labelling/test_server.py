"""The labelling page's server, asked over HTTP as a browser, a broken browser or a hostile web site would."""

import http.client
import io
import json
import socket
import threading

import pytest
from PIL import Image

from active_perceiver.labelling.answers import LARGEST_POST, Handler
from active_perceiver.labelling.label_store import Labelling
from active_perceiver.labelling.server import LabellingServer, ServerError
from active_perceiver.labelling.view_labels import ViewLabels, labels_of
from active_perceiver.scenes import load_scene
from active_perceiver.scenes.scene import LABELLED, UNLABELLED

NOTHING = ViewLabels(UNLABELLED, {})
DRAWN = ViewLabels(LABELLED, {"ball1": (0.5, 0.5, 0.25, 0.125)})


def request(server, method, path, body=None, headers=None):
    """Status, headers and content of an answer."""
    connection = http.client.HTTPConnection("127.0.0.1", server.port, timeout=60)
    connection.request(method, path, body, headers or {})
    answer = connection.getresponse()
    content = answer.read()
    connection.close()
    return answer.status, answer.headers, content


def post(server, path, value, **headers):
    """As the page posts: status and parsed answer."""
    given = {"Content-Type": "application/json", "Origin": f"http://127.0.0.1:{server.port}", **headers}
    body = value if isinstance(value, bytes) else json.dumps(value).encode()
    status, _, content = request(server, "POST", path, body, {k: v for k, v in given.items() if v is not None})
    return status, json.loads(content)


def change(room, view, before, after):
    return {
        "scene": load_scene(room).content_hash, "view": view, "before": before.as_json(), "after": after.as_json(),
    }  # fmt: skip


class Running(LabellingServer):
    port = property(lambda self: self.server_address[1])


@pytest.fixture
def server(room):
    labelling = Labelling(room)
    server = Running(labelling, Handler)
    thread = threading.Thread(target=server.serve_forever, kwargs={"poll_interval": 0.01})
    thread.start()
    yield server
    server.shutdown()
    server.server_close()
    thread.join()
    labelling.close()


def test_the_page_and_its_files(server):
    status, headers, content = request(server, "GET", "/")
    assert status == 200
    assert headers["Content-Type"].startswith("text/html")
    assert "default-src 'none'" in headers["Content-Security-Policy"]
    for name in ("page.js", "changes.js", "stage.js", "page.css"):
        status, headers, more = request(server, "GET", f"/{name}")
        assert status == 200
        assert headers["Content-Type"].startswith("text/css" if name.endswith("css") else "text/javascript")
        content += more
    assert b"http://" not in content.replace(b"http://127.0.0.1", b"")  # nothing from elsewhere
    assert b"https://" not in content


def test_the_scene_as_the_page_gets_it(server, partly):
    scene = json.loads(request(server, "GET", "/api/scene")[2])
    assert (scene["name"], scene["file"], scene["unsaved"]) == ("toy_0", "room.h5", 0)
    assert [target["name"] for target in scene["targets"]] == list(partly.target_names)
    assert [view["label"] for view in scene["views"]] == ["labelled"] * 16 + ["proposed"] * 16 + ["unlabelled"] * 16
    assert [ViewLabels.from_json(view, partly.target_names) for view in scene["views"]] == labels_of(partly)


def test_images(server, partly):
    status, headers, content = request(server, "GET", "/view/7?x")
    assert (status, headers["Content-Type"], content) == (200, "image/png", partly.views[7])
    assert request(server, "GET", "/picture/2/3")[2] == partly.targets[2].pictures[3]
    assert Image.open(io.BytesIO(request(server, "GET", "/thumbnail/47")[2])).size == (96, 96)


@pytest.mark.parametrize(
    "path",
    ["/view/48", "/view/-1", "/view/x", "/view/", "/view/1/2", "/picture/3/0", "/picture/0/4", "/nowhere",
     "/../page.js", "/page/page.js", "/%2e%2e/server.py", "/server.py", "/view/" + "9" * 5000,
     "/view/%c2%b2", "/api/change"],
)  # fmt: skip
def test_what_is_not_there(server, path):
    assert request(server, "GET", path)[0] == 404


def test_a_change_is_kept_before_it_is_acknowledged(server, room):
    assert post(server, "/api/change", change(room, 40, NOTHING, DRAWN)) == (200, {"unsaved": 1})
    assert '"view":40' in (room.parent / "room.h5.labels.jsonl").read_text()
    assert post(server, "/api/change", change(room, 40, NOTHING, DRAWN))[0] == 200
    status, answer = post(server, "/api/change", change(room, 40, NOTHING, ViewLabels(LABELLED, {})))
    assert (status, answer["current"]) == (409, DRAWN.as_json())
    scene = load_scene(room).content_hash
    assert post(server, "/api/save", {"scene": scene}) == (200, {"saved": 1, "unsaved": 0})
    assert labels_of(load_scene(room))[40] == DRAWN


@pytest.mark.parametrize(
    ("headers", "status"),
    [
        ({"Origin": None}, 403),
        ({"Origin": "http://evil.example"}, 403),
        ({"Origin": "null"}, 403),
        ({"Origin": "https://127.0.0.1"}, 403),
        ({"Host": "evil.example", "Origin": "http://evil.example"}, 403),  # DNS rebinding
        ({"Host": "127.0.0.1.evil.example"}, 403),
        ({"Host": ""}, 403),
        ({"Host": "[::1"}, 403),
        ({"Content-Type": "text/plain"}, 415),
        ({"Content-Type": "application/x-www-form-urlencoded"}, 415),
        ({"Content-Type": None}, 415),
        ({"Content-Length": "-1"}, 411),
        ({"Content-Length": "x"}, 411),
        ({"Content-Length": str(LARGEST_POST + 1)}, 413),
        ({"Content-Length": "9" * 5000}, 413),
        ({"Transfer-Encoding": "chunked"}, 411),
    ],
)
def test_only_the_page_itself_may_post(server, room, headers, status):
    assert post(server, "/api/change", change(room, 40, NOTHING, DRAWN), **headers)[0] == status
    assert server.labelling.unsaved == 0
    assert request(server, "GET", "/api/scene")[0] == 200


@pytest.mark.parametrize("host", ["127.0.0.1:{}", "localhost:{}", "[::1]:{}", "LOCALHOST", "192.168.1.7:{}"])
def test_hosts_that_nobody_can_take_over_are_answered(server, host):
    assert request(server, "GET", "/", headers={"Host": host.format(server.port)})[0] == 200


def test_pages_of_others_are_not_shown_anything(server):
    for path in ("/", "/api/scene", "/view/0"):
        assert request(server, "GET", path, headers={"Host": "evil.example"})[0] == 403
        assert request(server, "GET", path)[1]["Cross-Origin-Resource-Policy"] == "same-origin"
    for method in ("PUT", "DELETE", "OPTIONS", "HEAD"):
        assert request(server, method, "/api/scene")[0] == 501


def broken(good):
    yield b""
    yield b"{"
    yield b"\xff\xfe"
    yield b"[" * 100_000
    yield b"[]"
    yield {**good, "more": 1}
    yield {key: value for key, value in good.items() if key != "before"}
    yield from ({**good, "view": view} for view in (-1, 48, "40", 4.0, True, None, [1], 10**30))
    yield {**good, "after": {"label": "labelled", "boxes": {"ball1": [0.5, 0.5, 2, 2]}}}
    yield {**good, "after": {"label": "labelled", "boxes": {"sofa": [0.5, 0.5, 0.1, 0.1]}}}
    yield {**good, "after": {"label": "sure", "boxes": {}}}
    yield {**good, "after": {"label": "unlabelled", "boxes": {"ball1": [0.5, 0.5, 0.1, 0.1]}}}
    yield {**good, "before": {"label": "labelled", "boxes": {"ball1": [float("nan")] * 4}}}
    yield {**good, "before": []}
    yield {**good, "scene": "another"}


def test_broken_posts_get_a_sentence_and_change_nothing(server, room):
    for value in broken(change(room, 40, NOTHING, DRAWN)):
        status, answer = post(server, "/api/change", value)
        assert status in (400, 404, 410), value
        assert len(answer["error"]) > 10
    assert post(server, "/api/else", {})[0] == 404
    assert post(server, "/api/save", {"scene": "another"})[0] == 410
    assert server.labelling.unsaved == 0
    assert labels_of(load_scene(room)) == server.labelling.views()


def test_what_cannot_be_kept_is_said(server, room, monkeypatch):
    def full_disk(*_):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("active_perceiver.labelling.journal.os.fsync", full_disk)
    monkeypatch.setattr("active_perceiver.labelling.journal.Journal._truncate", lambda *_: None)
    status, answer = post(server, "/api/change", change(room, 40, NOTHING, DRAWN))
    assert status == 500
    assert "No space left" in answer["error"]
    assert server.labelling.unsaved == 0


def test_many_at_once_are_all_kept(server, room):
    def draw(view):
        answers.append(post(server, "/api/change", change(room, view, NOTHING, DRAWN))[0])

    answers = []
    threads = [threading.Thread(target=draw, args=(view,)) for view in range(32, 48)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert answers == [200] * 16
    assert server.labelling.unsaved == 16


def test_half_a_request_holds_up_nobody(server):
    with socket.create_connection(("127.0.0.1", server.port)) as waiting:
        waiting.sendall(b"POST /api/change HTTP/1.1\r\nHost: 127.0.0.1\r\nContent-Le")
        assert request(server, "GET", "/")[0] == 200


def test_a_port_that_is_taken_or_none_is_said(server, room):
    with pytest.raises(ServerError, match="another --port"):
        LabellingServer(server.labelling, Handler, port=server.port)
    with pytest.raises(ServerError, match="cannot be served"):
        LabellingServer(server.labelling, Handler, port=70000)
    with pytest.raises(ServerError, match="cannot be served"):
        LabellingServer(server.labelling, Handler, host="203.0.113.7")


@pytest.mark.parametrize(("host", "local"), [("127.0.0.1", True), ("localhost", True), ("0.0.0.0", False)])
def test_it_knows_whether_others_can_reach_it(server, host, local):
    other = LabellingServer(server.labelling, Handler, host=host)
    assert other.is_local == local
    other.server_close()
