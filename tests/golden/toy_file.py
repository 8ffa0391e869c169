"""Write the tests' toy scene into a file: python tests/golden/toy_file.py toy_0.h5."""

import sys
from pathlib import Path

from active_perceiver.scenes import save_scene

sys.path.insert(0, str(Path(__file__).parents[1]))

from helpers.toy import toy_scene

if __name__ == "__main__":
    save_scene(toy_scene(), Path(sys.argv[1]))
