from __future__ import annotations

import os
import subprocess
import sys

SCRIPT = """
import sys

class NoTorch:
    def find_spec(self, name, path=None, target=None):
        if name.split(".")[0] in ("torch", "onnx", "onnxscript", "safetensors"):
            raise ModuleNotFoundError(f"No module named '{name}'", name=name)

sys.meta_path.insert(0, NoTorch())
import numpy as np
import active_perceiver.recognition, active_perceiver.vision
from active_perceiver.vision import (BackboneError, load_backbone)
try:
    load_backbone()
except BackboneError as error:
    print(error)
"""


def test_running_parts_do_without_torch_and_say_what_is_missing(tmp_path):
    done = subprocess.run(
        [sys.executable, "-c", SCRIPT],
        env={**os.environ, "ACTIVE_PERCEIVER_CACHE": str(tmp_path)},
        capture_output=True,
        text=True,
        check=True,
    )
    assert "not in the cache" in done.stdout
    assert "copy backbone.onnx into the agent's folder" in done.stdout
