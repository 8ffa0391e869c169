"""Every `--help` is what was committed: an option that vanishes, or changes by accident, shows."""

import subprocess
import sys
from pathlib import Path

HERE = Path(__file__).parent
RENEW = "python tests/golden/record.py --only help --out tests/golden/expected --force"


def test_every_help_is_as_expected():
    script = [sys.executable, HERE / "record.py", "--only", "help", "--check", HERE / "expected"]
    done = subprocess.run(script, capture_output=True, text=True, check=False)
    assert done.returncode == 0, f"{done.stdout}{done.stderr}\nif that is meant: {RENEW}"


def test_a_difference_is_shown(tmp_path):
    text = (HERE / "expected" / "help.txt").read_text()
    (tmp_path / "help.txt").write_text(text.replace("--recogniser-steps", "--steps-of-the-recogniser"))
    script = [sys.executable, HERE / "record.py", "--only", "help", "--check", tmp_path]
    done = subprocess.run(script, capture_output=True, text=True, check=False)
    assert done.returncode == 1
    assert "-  --steps-of-the-recogniser" in done.stdout
    assert "+  --recogniser-steps" in done.stdout
