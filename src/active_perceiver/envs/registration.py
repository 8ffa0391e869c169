"""The ids under which Gymnasium makes the environments: `ActivePerceiver/Search-v0`, and one for each bundled scene.

Gymnasium 1 has no plugins: ids are there once the module that registers them was imported, which
`import active_perceiver.envs` does, and so does an id with a module, as in
`gymnasium.make("active_perceiver.envs:ActivePerceiver/Kitchen1-v0")`; see
https://gymnasium.farama.org/api/registry/. Registering opens no scene; making an environment does.
"""

from __future__ import annotations

from typing import Any

import gymnasium

from active_perceiver.scenes.bundled import TARGETS_OF_RECORD

NAMESPACE = "ActivePerceiver"
SEARCH_ID = f"{NAMESPACE}/Search-v0"


def scene_id(name: str) -> str:
    """The id of a bundled scene: "kitchen_1" is "ActivePerceiver/Kitchen1-v0"."""
    return f"{NAMESPACE}/{''.join(part.capitalize() for part in name.split('_'))}-v0"


def register_environments() -> None:
    """Register all ids, once; the bundled scenes' search for their four targets of record if no others are given."""
    ids: dict[str, dict[str, Any]] = {SEARCH_ID: {}} | {
        scene_id(name): {"scene": name, "targets": targets} for name, targets in TARGETS_OF_RECORD.items()
    }
    for name, arguments in ids.items():
        if name not in gymnasium.registry:
            gymnasium.register(
                id=name,
                entry_point="active_perceiver.envs.env:SearchEnv",
                vector_entry_point="active_perceiver.envs.vector_env:SearchVectorEnv",
                kwargs=arguments,
            )
