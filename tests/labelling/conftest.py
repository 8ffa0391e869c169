"""A small scene of which a third is labelled and a third has proposals, and a server that is a process of its own."""

from __future__ import annotations

import dataclasses
import os
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from active_perceiver.scenes import Scene, save_scene
from active_perceiver.scenes.scene import LABELLED, PROPOSED, UNLABELLED
from helpers.toy import toy_scene

LABELLED_VIEWS, PROPOSED_VIEWS = 16, 32
"""The first so many views are labelled; those up to the second number have proposals; there are 48."""


@pytest.fixture(scope="session")
def partly() -> Scene:
    scene = toy_scene(side=2, image_size=64)
    labels = np.full(len(scene), UNLABELLED, np.uint8)
    labels[:PROPOSED_VIEWS], labels[:LABELLED_VIEWS] = PROPOSED, LABELLED
    boxes = scene.boxes.copy()
    boxes[PROPOSED_VIEWS:] = np.nan
    return dataclasses.replace(scene, labels=labels, boxes=boxes)


@pytest.fixture
def room(partly: Scene, tmp_path: Path) -> Path:
    path = tmp_path / "room.h5"
    save_scene(partly, path)
    return path


class Server:
    """`scenes label` in a process of its own."""

    def __init__(self, room: Path, *arguments: str) -> None:
        command = [sys.executable, "-m", "active_perceiver", "scenes", "label", str(room), *arguments]
        self.process = subprocess.Popen(
            command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, env={**os.environ, "COLUMNS": "200"}
        )
        self.said = ""
        for line in self.process.stdout:
            self.said += line
            if "Ctrl-C" in line:
                break
        self.url = (
            next(word for word in self.said.split() if word.startswith("http://")) if "http" in self.said else ""
        )
        self.port = int(self.url.rpartition(":")[2].strip("/")) if self.url else 0

    def end(self, signal: int) -> str:
        """Send a signal, wait, and give all that it said."""
        if self.process.poll() is None:
            self.process.send_signal(signal)
        self.said += self.process.communicate(timeout=60)[0]
        return self.said


@pytest.fixture
def start() -> Iterator:
    """Starts servers, which do not outlive the test."""
    servers = []

    def begin(room: Path, *arguments: str) -> Server:
        servers.append(Server(room, *arguments))
        return servers[-1]

    yield begin
    for server in servers:
        if server.process.poll() is None:
            server.process.kill()
            server.process.communicate()
