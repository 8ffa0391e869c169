"""An environment with what a robot has to have, and nothing else: three packages, and this one without its own."""

from __future__ import annotations

import os
import subprocess
import sys
from importlib.metadata import version
from pathlib import Path

import active_perceiver
from active_perceiver.errors import UserError

PACKAGES = ("numpy", "onnxruntime", "pillow")


def make_clean_environment(folder: Path) -> Path:
    """Make a virtual environment with the versions of `PACKAGES` that are installed here.

    Args:
        folder: the new environment.

    Returns:
        Its Python, to be started with `clean_variables`.

    Raises:
        UserError: if the packages cannot be had.
    """
    _run([sys.executable, "-m", "venv", "--without-pip", str(folder)])
    python = folder / "bin" / "python"
    pinned = [f"{package}=={version(package)}" for package in PACKAGES]
    _run([sys.executable, "-m", "pip", "--python", str(python), "install", "--quiet", *pinned])
    site = _run([str(python), "-c", "import sysconfig; print(sysconfig.get_path('purelib'))"])
    # As `pip install --no-deps` of this package would, but without building it.
    (Path(site) / "active_perceiver").symlink_to(Path(active_perceiver.__file__).parent)
    return python


def clean_variables() -> dict[str, str]:
    """The process's environment variables without those that would let a Python find packages elsewhere."""
    return {name: value for name, value in os.environ.items() if name not in ("PYTHONPATH", "PYTHONHOME")}


def _run(command: list[str]) -> str:
    done = subprocess.run(command, env=clean_variables(), capture_output=True, text=True, check=False)
    if done.returncode != 0:
        said = (done.stderr or done.stdout).strip().splitlines() or [f"exit code {done.returncode}"]
        raise UserError(
            f"no environment with {', '.join(PACKAGES)} alone could be made ({said[-1]}); is the package registry in "
            "reach, and pip installed?"
        )
    return done.stdout.strip()
