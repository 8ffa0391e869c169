"""A process of its own that acts as a robot's program would, and prints how long everything took.

Being fresh, it shows the cold start and the memory of one agent with one number of threads. What is heavy to import
is imported inside the functions, under the clock. Run by `measure.py`.
"""

from __future__ import annotations

import json
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

from active_perceiver.utils.memory import peak_memory
from active_perceiver.utils.sections import listening

PARTS = ("decoding", "backbone", "recogniser", "policy")
# After so many actions a new search begins: about as long as searches are.
_ACTIONS = 20

Seconds = dict[str, list[float]]


def run_agent(
    folder: str, picture: str, frames: list[str], threads: int, repeats: int, launched: float
) -> dict[str, Any]:
    """Load an agent and let it act on encoded pictures.

    Args:
        folder: of the agent.
        picture: file of what is searched for.
        frames: files of what the camera sees, taken by turns.
        threads: CPU threads.
        repeats: actions to measure after the first one.
        launched: when this process was started, seconds since the epoch.

    Returns:
        "seconds": for each of `PARTS` and "whole" one number per action, without the first; "cold_start": seconds of
        "import", which includes starting the interpreter, "load", "reset" and "first action"; "peak_memory_gib";
        "torch": whether anything imported it.
    """
    from active_perceiver.agent.perceiver import ActivePerceiver
    from active_perceiver.scenes import read_image

    imported = time.time()
    data = [Path(frame).read_bytes() for frame in frames]
    started = time.perf_counter()
    agent = ActivePerceiver.from_pretrained(folder, threads)
    branch = next(iter(agent.config.branches))
    loaded = time.perf_counter()
    agent.reset(read_image(picture), branch, seed=0)
    begun = time.perf_counter()
    agent.act(data[0])
    acted = time.perf_counter()
    cold = {
        "import": imported - launched,
        "load": loaded - started,
        "reset": begun - loaded,
        "first action": acted - begun,
    }
    times: Seconds = {part: [] for part in (*PARTS, "whole")}

    # What an action leaves out takes no time in it.
    spent: dict[str, float] = {}

    def hear(name: str, seconds: float) -> None:
        spent[name] = spent.get(name, 0.0) + seconds

    for number in range(repeats):
        if number % _ACTIONS == 0:
            agent.reset(read_image(picture), branch, seed=number)
        with listening(hear):
            started = time.perf_counter()
            agent.act(data[number % len(data)])
            spent["whole"] = time.perf_counter() - started
        for part, each in times.items():
            each.append(spent.pop(part, 0.0))
    return _result(times, cold)


def run_torch(
    backbone: str, image_size: int, frames: list[str], threads: int, repeats: int, launched: float
) -> dict[str, Any]:
    """The same for the backbone alone as torch runs it eagerly, with random weights; see `run_agent`.

    Returns:
        As `run_agent`, with the part "backbone" only; scaling the picture is part of it, as it is there.
    """
    import torch

    from active_perceiver.scenes.images import decode_image, square_image
    from active_perceiver.vision.untrained import untrained_trunk

    imported = time.time()
    torch.set_num_threads(threads)
    started = time.perf_counter()
    network = untrained_trunk(backbone)
    loaded = time.perf_counter()
    images = [decode_image(Path(frame).read_bytes(), side=image_size) for frame in frames]

    @torch.inference_mode()
    def maps(image: Any) -> Any:
        return network(torch.from_numpy(square_image(image, image_size).copy())[None]).numpy()

    begun = time.perf_counter()
    maps(images[0])
    acted = time.perf_counter()
    cold = {"import": imported - launched, "load": loaded - started, "first action": acted - begun}
    seconds: Seconds = {"backbone": []}
    for number in range(repeats):
        started = time.perf_counter()
        maps(images[number % len(images)])
        seconds["backbone"].append(time.perf_counter() - started)
    return _result(seconds, cold)


def _result(seconds: Seconds, cold: dict[str, float]) -> dict[str, Any]:
    return {
        "seconds": seconds,
        "cold_start": {**cold, "whole": sum(cold.values())},
        "peak_memory_gib": peak_memory(),
        "torch": "torch" in sys.modules,
    }


RUNS: dict[str, Callable[..., dict[str, Any]]] = {"agent": run_agent, "torch": run_torch}

if __name__ == "__main__":
    request = json.loads(sys.argv[1])
    print(json.dumps(RUNS[request.pop("run")](**request)))
