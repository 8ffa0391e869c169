"""What importing brings in: a robot has numpy, onnxruntime and pillow, and no time to load more.

Which folder may import which is a matter of `make lint` (import-linter, see pyproject.toml).
"""

from __future__ import annotations

import subprocess
import sys

import pytest

ROBOT = {"numpy", "onnxruntime", "PIL"}
HEAVY = {
    "torch", "embreex", "mitsuba_oidn", "onnx", "onnxscript", "safetensors", "stable_baselines3", "roslibpy", "yaml",
    "websockets", "matplotlib",
}  # fmt: skip
BROUGHT_IN = """
import sys
before = set(sys.modules)
import {module}
print(*sorted({{name.partition(".")[0] for name in set(sys.modules) - before}}))
"""


def brought_in(module: str) -> set[str]:
    """Top-level names that importing a module adds to `sys.modules`."""
    code = BROUGHT_IN.format(module=module)
    return set(
        subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout.split()
    )


@pytest.mark.parametrize("module", ["agent.perceiver", "robots", "live"])
def test_a_robot_needs_three_packages_only(module):
    """Those three import others, which are theirs; none of this project's dependencies is among what is left."""
    theirs = {name for package in ROBOT for name in brought_in(package)}
    more = brought_in(f"active_perceiver.{module}") - theirs - sys.stdlib_module_names - {"active_perceiver"}
    assert not more


@pytest.mark.parametrize(
    "module", ["robots.ros.robot", "scenes", "vision", "recognition", "policies", "envs", "cli.main"]
)
def test_running_brings_in_nothing_heavy(module):
    assert not brought_in(f"active_perceiver.{module}") & HEAVY
