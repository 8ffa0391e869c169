"""What an agent makes of an image, or of a few in a row, as JSON: to try an exported agent on the robot.

`python -m active_perceiver.deploy.try_agent AGENT --picture mug.jpg FRAME.jpg`; it needs no more than an agent does.
"""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Sequence
from pathlib import Path

from active_perceiver.agent.perceiver import ActivePerceiver
from active_perceiver.errors import UserError
from active_perceiver.scenes import read_image


def main(arguments: Sequence[str] | None = None) -> int:
    """Print a line for each image: its name, the action, whether it is found, and score and box or null.

    Args:
        arguments: without the program's name; those of the process if not given.

    Returns:
        The exit code: 0 well done, 2 wrong input.
    """
    parser = argparse.ArgumentParser(prog="python -m active_perceiver.deploy.try_agent", description=__doc__)
    parser.add_argument("agent", type=Path, help="folder of the agent")
    parser.add_argument(
        "frames", type=Path, nargs="+", metavar="frame", help="what the robot sees, one after the other"
    )
    parser.add_argument("--picture", type=Path, required=True, help="what is searched for")
    parser.add_argument("--scene", help="where the robot is; needed if the agent knows several scenes")
    given = parser.parse_args(arguments)
    try:
        agent = ActivePerceiver.from_pretrained(given.agent)
        agent.reset(given.picture, given.scene, seed=0)
        for frame in given.frames:
            step = agent.act(read_image(frame))
            seen = step.detection
            line = {
                "frame": str(frame),
                "action": step.action.value,
                "found": step.found,
                "score": None if seen is None else round(seen.score, 4),
                "box": None if seen is None else [round(float(value), 4) for value in seen.box],
            }
            print(json.dumps(line), flush=True)
    except UserError as error:
        print(f"error: {error}", file=sys.stderr)
        return 2
    return 0


if __name__ == "__main__":
    sys.exit(main())
