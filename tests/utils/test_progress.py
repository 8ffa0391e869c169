"""Progress bars, as a log shows them."""

import subprocess
import sys

PROGRAM = """
from active_perceiver.utils.progress import progress_bar
with progress_bar("counting") as report:
    for step in range(1, 4):
        report(step, 3, f"at {step}")
with progress_bar("cached"):
    pass
"""


def test_one_line_stays_on_standard_error_for_each_stage():
    done = subprocess.run([sys.executable, "-c", PROGRAM], capture_output=True, text=True, check=True)
    assert done.stdout == ""
    lines = [line for line in done.stderr.splitlines() if line.strip()]
    assert "counting" in lines[0]
    assert "3/3" in lines[0].replace(" ", "")
    assert "at 3" in lines[0]
    assert "cached" in lines[-1]
    assert "nothing left to do" in lines[-1]
