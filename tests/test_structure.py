"""The tree shows the design: imports point downwards, running never imports torch, docs point to what exists."""

import ast
import re
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
PACKAGE = ROOT / "src" / "active_perceiver"

# What each folder or module may import from the package, besides itself and the leaves below.
LEAVES = {"__init__", "ahead", "averaging", "errors", "files", "memory", "progress"}
ALLOWED = {
    "scenes": set(),
    "vision": {"scenes"},
    "search": {"scenes", "vision"},
    "recognition": {"scenes", "vision"},
    "policies": {"scenes", "search", "vision"},
    "agent_config": {"scenes"},
    "known_targets": {"agent_config", "policies", "recognition", "scenes", "vision"},
    "exploring": {"agent_config", "policies", "recognition", "scenes"},
    "checksums": {"agent_config"},
    "course": {"exploring", "known_targets", "policies"},
    "perceiver": {
        "agent_config", "checksums", "course", "exploring", "known_targets", "policies", "recognition", "scenes",
        "vision",
    },
    "robots": {"perceiver", "scenes"},
    "robots/simulated": {"robots", "rooms", "scenes"},
    "rooms": {"scenes"},
    "figures": {"recognition", "robots", "scenes"},
    "experiments": {
        "agent_config", "checksums", "course", "exploring", "figures", "known_targets", "perceiver", "policies",
        "recognition", "robots", "scenes", "search", "vision",
    },
    "cli_import": {"cli_help", "experiments", "scenes"},
    "labelling": {"scenes"},
    "cli_label": {"experiments", "labelling", "scenes"},
    "capturing": {"robots", "rooms", "scenes"},
    "cli_capture": {"capturing", "cli_help", "experiments", "robots", "rooms", "scenes"},
    "cli_scenes": {"cli_capture", "cli_help", "cli_import", "cli_label", "experiments", "rooms", "scenes"},
    "cli_bridge": {"cli_help", "robots"},
    "cli_benchmarks_agents": {"cli_help", "cli_outputs", "experiments", "rooms"},
    "cli_benchmarks_training": {"cli_help", "cli_outputs", "experiments"},
    "cli_benchmarks": {
        "cli_benchmarks_agents", "cli_benchmarks_training", "cli_help", "cli_outputs", "experiments", "rooms",
    },
    "cli": {"cli_benchmarks", "cli_bridge", "cli_help", "cli_scenes", "experiments", "rooms", "scenes", "vision"},
    "__main__": {"cli"},
}  # fmt: skip

FILES = sorted(PACKAGE.rglob("*.py"))
HEAVY = {
    "torch", "embreex", "mitsuba_oidn", "onnx", "onnxscript", "safetensors", "stable_baselines3", "roslibpy", "yaml",
    "websockets",
}  # fmt: skip


def unit_of(path: Path) -> str:
    parts = path.relative_to(PACKAGE).with_suffix("").parts
    return own if (own := "/".join(parts)) in ALLOWED else parts[0]


def imports(path: Path, top_level_only: bool = False) -> set[str]:
    tree = ast.parse(path.read_text())
    typing_only = {
        id(node)
        for block in ast.walk(tree)
        if isinstance(block, ast.If) and getattr(block.test, "id", "") == "TYPE_CHECKING"
        for node in ast.walk(block)
    }
    later = {
        id(node)
        for block in ast.walk(tree)
        if top_level_only and isinstance(block, ast.FunctionDef)
        for node in ast.walk(block)
    }
    nodes = [node for node in ast.walk(tree) if id(node) not in typing_only | later]
    names = set()
    for node in nodes:
        if isinstance(node, ast.Import):
            names |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom) and node.module:
            names.add(node.module)
            names |= {f"{node.module}.{alias.name}" for alias in node.names if node.module == "active_perceiver"}
    return names


@pytest.mark.parametrize("path", FILES, ids=lambda path: str(path.relative_to(PACKAGE)))
def test_imports_point_downwards(path):
    unit = unit_of(path)
    used = {name.split(".")[1] for name in imports(path) if name.startswith("active_perceiver.")}
    used -= LEAVES | {unit, "__version__"}
    assert used <= ALLOWED.get(unit, set()), f"{unit} must not import {used - ALLOWED.get(unit, set())}"


def reachable(start: str) -> set[Path]:
    """Files that importing a module brings in, by imports at top level."""
    found: set[Path] = set()
    todo = [start]
    while todo:
        name = todo.pop()
        base = PACKAGE.joinpath(*name.split(".")[1:])
        for path in (base.with_suffix(".py"), base / "__init__.py"):
            if path.is_file() and path not in found:
                found.add(path)
                todo += [used for used in imports(path, True) if used.startswith("active_perceiver.")]
                todo += [".".join(used.split(".")[:-1]) for used in imports(path, True) if used.count(".") > 1]
    return found


@pytest.mark.parametrize(
    "module",
    ["perceiver", "robots", "robots.rosbridge", "scenes", "vision", "recognition", "policies", "search", "cli"],
)
def test_running_brings_in_nothing_heavy(module):
    for path in reachable(f"active_perceiver.{module}"):
        heavy = {name.split(".")[0] for name in imports(path, True)} & HEAVY
        assert not heavy, f"importing {module} imports {heavy} in {path.relative_to(PACKAGE)}"


@pytest.mark.parametrize("module", ["perceiver", "robots"])
def test_a_robot_needs_three_packages_only(module):
    for path in reachable(f"active_perceiver.{module}"):
        packages = {name.split(".")[0] for name in imports(path, True)} - sys.stdlib_module_names
        more = packages - {"active_perceiver", "numpy", "onnxruntime", "PIL"}
        assert not more, f"importing {module} imports {more} in {path.relative_to(PACKAGE)}"


@pytest.mark.parametrize("path", FILES, ids=lambda path: str(path.relative_to(PACKAGE)))
def test_no_file_is_too_long(path):
    assert len(path.read_text().splitlines()) <= 500


def test_the_architecture_names_existing_modules():
    text = (ROOT / "docs" / "architecture.md").read_text()
    for name in re.findall(r"`([a-z_]+(?:/[a-z_]+)*(?:\.py|/))`", text):
        assert (PACKAGE / name).exists(), f"docs/architecture.md names {name}"
