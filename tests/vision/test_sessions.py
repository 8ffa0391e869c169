"""ONNX Runtime is imported at one place, and neither it nor anything else calls anybody or leaves a trace."""

from __future__ import annotations

import ast
import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import active_perceiver

AGENT = Path(__file__).parents[1] / "data" / "v0.1" / "agent"

RUN_A_POLICY = """
import sys, time
calls = []
sys.addaudithook(lambda event, args: calls.append(event) if event.startswith("socket.") else None)
import numpy as np
from active_perceiver.policies.policy import Policy
policy = Policy(sys.argv[1])
branch = next(iter(policy.branches))
features = np.zeros((1, policy.feature_dim), np.float32)
print(policy.probabilities(features, features, np.zeros((1, 25), np.float32), branch).sum())
time.sleep(0.5)  # its thread for events takes a while
assert calls == [], calls
"""


def run_in_new_home(home: Path, before: tuple[str, ...] = ()) -> None:
    environment = {key: value for key, value in os.environ.items() if key not in ("ORT_DISABLE_TELEMETRY",)}
    environment = {key: value for key, value in environment.items() if not key.startswith("XDG_")}
    command = [*before, sys.executable, "-c", RUN_A_POLICY, str(AGENT / "policy.onnx")]
    home.mkdir()
    done = subprocess.run(
        command, env={**environment, "HOME": str(home)}, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
    assert abs(float(done.stdout) - 1) < 1e-4


def test_running_a_model_leaves_nothing_in_the_home(tmp_path: Path) -> None:
    """ONNX Runtime's first trace would be the number that it gives this computer."""
    run_in_new_home(tmp_path / "home")
    assert list((tmp_path / "home").rglob("*")) == []


def test_running_a_model_opens_no_socket(tmp_path: Path) -> None:
    """Seen by the system, as code in C tells Python nothing; without strace only what Python sees is checked."""
    log = tmp_path / "calls.txt"
    strace = shutil.which("strace")
    works = strace is not None and subprocess.run([strace, "true"], capture_output=True, check=False).returncode == 0
    before = (str(strace), "-f", "-e", "trace=socket,connect,sendto,sendmsg", "-o", str(log)) if works else ()
    run_in_new_home(tmp_path / "home", before)
    if works:
        assert re.findall(r".*AF_(?:INET6?|NETLINK).*", log.read_text()) == []


def test_onnx_runtime_is_imported_at_one_place() -> None:
    """Or behind it: its tools for quantising are loaded by a function of a module that imports that place."""
    source = Path(active_perceiver.__file__).parent
    found = {}
    for path in source.rglob("*.py"):
        imported: set[str] = set()
        for node in ast.walk(ast.parse(path.read_text())):
            if isinstance(node, ast.Import):
                imported |= {alias.name for alias in node.names}
            elif isinstance(node, ast.ImportFrom):
                imported |= {f"{node.module}.{alias.name}" for alias in node.names}
        if any(name.split(".")[0] == "onnxruntime" for name in imported):
            found[path.relative_to(source).as_posix()] = imported
    assert found.keys() == {"vision/sessions.py", "deploy/quantize.py"}
    assert "active_perceiver.vision.sessions" in found["deploy/quantize.py"]
