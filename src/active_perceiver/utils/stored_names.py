"""Names that earlier versions gave to what they stored, so that their files are read on."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

# Since version 0.2.0; 0.1.0 wrote the names on the left.
AGENT = {
    "found_area": "stop_area_threshold",
    "known_similarity": "match_threshold",
    "changed_views": "view_augmentation",
    "changed_degrees": "viewpoint_jitter_degrees",
}
VIEW_MAP = {"looks": "descriptors"}
RECORDING = {"branch": "scene"}
ROBOT = {
    "stale": "max_image_age",
    "turning": "angular_velocity",
    "close": "position_tolerance",
    "straight": "heading_tolerance",
}
LEARNER = {
    "searches": "num_envs",
    "rollout_steps": "num_steps",
    "trace_decay": "gae_lambda",
    "value_weight": "value_coef",
    "gradient_norm": "max_grad_norm",
}


def current_names(data: Mapping[str, Any], names: Mapping[str, str]) -> dict[str, Any]:
    """What was read, under the names of now.

    Args:
        data: by the names of any version.
        names: earlier name -> name of now. An entry that is there under both is left as it is.
    """
    return {names[key] if names.get(key, key) not in data else key: value for key, value in data.items()}


def stored_names(data: Mapping[str, Any], names: Mapping[str, str]) -> dict[str, Any]:
    """The other way round: data of now under the names that were stored before."""
    earlier = {now: then for then, now in names.items()}
    return {earlier.get(key, key): value for key, value in data.items()}
