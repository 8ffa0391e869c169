"""`from active_perceiver import ...`: the names are there, and importing the package costs nothing."""

from __future__ import annotations

import ast
import subprocess
import sys
from pathlib import Path

import pytest

import active_perceiver

NAMES = [name for name in active_perceiver.__all__ if name != "__version__"]


def run(code: str) -> str:
    """What a new interpreter prints."""
    return subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout


def test_importing_loads_nothing():
    code = """
import importlib, sys, typing
before = set(sys.modules)
import active_perceiver
dir(active_perceiver), active_perceiver.__version__
print(*(set(sys.modules) - before))
"""
    assert set(run(code).split()) == {"active_perceiver", "active_perceiver.version"}


@pytest.mark.parametrize("name", NAMES)
def test_each_name_is_loaded_when_asked_for(name):
    code = f"""
import sys
from active_perceiver import {name}
import active_perceiver
assert vars(active_perceiver)["{name}"] is {name}
print({name}.__name__, "torch" in sys.modules)
"""
    assert run(code).split() == [name, "False"]


def test_all_names_come_at_once_and_are_listed_before():
    assert set(active_perceiver.__all__) <= set(dir(active_perceiver))
    assert run("from active_perceiver import *; print(search.__name__)").strip() == "search"


def test_an_unknown_name_is_the_usual_error():
    with pytest.raises(AttributeError, match="module 'active_perceiver' has no attribute 'serch'"):
        active_perceiver.serch  # noqa: B018
    with pytest.raises(ImportError, match="cannot import name 'serch'"):
        from active_perceiver import serch  # noqa: F401
    assert not hasattr(active_perceiver, "_wrong")


def test_type_checkers_see_the_same_names():
    tree = ast.parse(Path(active_perceiver.__file__).read_text())
    (block,) = [node for node in tree.body if isinstance(node, ast.If) and isinstance(node.test, ast.Name)]
    seen = {alias.asname: node.module for node in block.body for alias in node.names}
    assert seen == {name: f"active_perceiver.{home}" for name, home in active_perceiver._HOMES.items()}
