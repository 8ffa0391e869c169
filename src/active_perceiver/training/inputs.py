"""What a training begins with: scenes, the backbone, features."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from active_perceiver.errors import UserError
from active_perceiver.scenes import Scene, open_scene
from active_perceiver.scenes.box_labels import label_states
from active_perceiver.scenes.scene import PROPOSED, UNLABELLED
from active_perceiver.training.config import TrainConfig
from active_perceiver.utils.progress import console
from active_perceiver.vision.backbone import Backbone, load_backbone


def open_scenes(sources: Sequence[str]) -> tuple[Scene, ...]:
    """Open scenes to train in.

    Raises:
        UserError: if one cannot be opened, there are none, or two have the same name.
    """
    scenes = tuple(open_scene(source) for source in sources)
    names = [scene.name for scene in scenes]
    if not names or len(set(names)) != len(names):
        raise UserError(f"training needs scenes of different names, at least one; got {names}")
    return scenes


def open_backbone(config: TrainConfig) -> Backbone:
    """Load the backbone that a training names."""
    with console.status(f"backbone {config.backbone}; the first time it is converted, which takes half a minute"):
        return load_backbone(config.backbone, image_size=config.image_size)


def label_warnings(scenes: Iterable[Scene]) -> list[str]:
    """Sentences on views whose boxes nobody has drawn or looked at, and what that means for training."""
    warnings = []
    for scene in scenes:
        unlabelled, proposed = (int((label_states(scene) == state).sum()) for state in (UNLABELLED, PROPOSED))
        if unlabelled:
            warnings.append(
                f"{unlabelled} of {len(scene)} views of {scene.name} are not labelled: no recogniser learns from "
                "them, and none of them is where a search should end; label them with `scenes label`"
            )
        if proposed:
            warnings.append(
                f"the boxes of {proposed} of {len(scene)} views of {scene.name} were proposed by a recogniser and "
                "not accepted: they are learned from as they are; look at them with `scenes label`"
            )
    return warnings
