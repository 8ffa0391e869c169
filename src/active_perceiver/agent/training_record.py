"""How an agent was trained: what measuring it again, or training it again, has to know."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass, field, fields
from typing import Any

from active_perceiver.utils.stored_names import AGENT, current_names

KINDS: dict[str, type | tuple[type, ...]] = {
    "scenes": list,
    "learner": str,
    "seed": int,
    "recogniser_scenes": list,
    "rank": int,
    "held_out_pictures": dict,
    "held_out_views": dict,
    "view_augmentation": int,
    "viewpoint_jitter_degrees": (int, float),
}
"""Field of a `TrainingRecord` -> what it is in JSON."""


@dataclass(frozen=True)
class TrainingRecord:
    """What an agent's configuration keeps of its training.

    Attributes:
        scenes: where, bundled names or files, in the order of the policy's branches.
        learner: of the policy.
        seed: of everything random.
        recogniser_scenes: what the recogniser was trained on; nothing if there is none.
        rank: goal states are those whose box is at least as large as the `rank`-th largest.
        held_out_pictures: scene -> target -> number of its last pictures that training never saw.
        held_out_views: scene -> views that the recogniser was not trained on.
        view_augmentation: how many times the policy was shown each view as another camera would.
        viewpoint_jitter_degrees: by how much the camera looked aside in these.
    """

    scenes: tuple[str, ...] = ()
    learner: str = ""
    seed: int = 0
    recogniser_scenes: tuple[str, ...] = ()
    rank: int = 5
    held_out_pictures: Mapping[str, Mapping[str, int]] = field(default_factory=dict)
    held_out_views: Mapping[str, list[int]] = field(default_factory=dict)
    view_augmentation: int = 0
    viewpoint_jitter_degrees: float = 0.0

    def to_json(self) -> dict[str, Any]:
        """Plain data, see `from_json`."""
        return asdict(self)

    @classmethod
    def from_json(cls, data: Any) -> TrainingRecord:
        """Read what `to_json` gave, of this version or an earlier one; what else is in it is left out.

        Raises:
            TypeError: if it is no object, or something in it has another type.
        """
        if not isinstance(data, dict):
            raise TypeError("training is no object")
        data = current_names(data, AGENT)
        for name, kinds in KINDS.items():
            if name in data and (not isinstance(data[name], kinds) or isinstance(data[name], bool)):
                raise TypeError(f"training's {name} is {data[name]!r}")
        given = {entry.name: data[entry.name] for entry in fields(cls) if entry.name in data}
        for name in ("scenes", "recogniser_scenes"):
            if name in given:
                if not all(isinstance(source, str) for source in given[name]):
                    raise TypeError(f"training's {name} are not texts")
                given[name] = tuple(given[name])
        return cls(**given)
