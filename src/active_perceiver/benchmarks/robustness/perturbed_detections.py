"""What an agent sees in a scene that is not as it was trained: the tables that its searches are measured with."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from active_perceiver.agent.perceiver import ActivePerceiver
from active_perceiver.benchmarks.robustness.perturbations import DetectionChange, ImageChange
from active_perceiver.evaluation.agent_scenes import features_of
from active_perceiver.evaluation.detections import DetectionTable, detect_images, even_pictures
from active_perceiver.scenes import Scene
from active_perceiver.utils.progress import ProgressCallback, quiet


@dataclass(frozen=True, eq=False)
class Queries:
    """What an agent is asked to search for in one of its scenes: its targets, with the pictures trained on.

    Attributes:
        scene: as it was trained in.
        names: of the T targets.
        features: (T, K, D) float32 of their pictures.
        embeddings: (T, K, C) float32, the recogniser's of them.
    """

    scene: Scene
    names: tuple[str, ...]
    features: NDArray[np.float32]
    embeddings: NDArray[np.float32]

    @classmethod
    def of(cls, agent: ActivePerceiver, scene: Scene, names: Sequence[str]) -> Queries:
        """Those that an agent was trained for in a scene.

        Raises:
            AgentError: if it searches for views.
        """
        recogniser = agent.recogniser
        features = features_of(scene, agent.backbone)
        targets = np.array([scene.target_index(name) for name in names])
        pictures, trained = even_pictures([scene.targets[target] for target in targets])
        wanted = (targets[:, None], pictures[:, :trained])
        embeddings = np.stack([recogniser.encode_target(maps) for maps in features.target_maps[wanted]])
        return cls(scene, tuple(names), features.target_features[wanted], embeddings)


def look_around(
    agent: ActivePerceiver,
    asked: Queries,
    shown: Scene,
    change: ImageChange | None = None,
    seed: int = 0,
    progress: ProgressCallback = quiet,
) -> DetectionTable:
    """Let an agent look at every view of a scene, as `ActivePerceiver.act` does.

    Args:
        agent: looks.
        asked: what for.
        shown: what is there: the scene itself, or the same room with something changed; it must have the targets.
        change: happens to every view before the agent sees it. What is random in it is drawn once for a view.
        seed: of these draws.
        progress: called with the number of views done and of all.

    Returns:
        Its tables; the scene in them has the name of the one asked about, whose policy branch decides.

    Raises:
        SceneError: if a target is not in the scene that is shown.
    """
    targets = np.array([shown.target_index(name) for name in asked.names], np.int64)
    images = (_changed(shown, state, change, seed) for state in range(len(shown)))
    features, scores, boxes = detect_images(
        images, len(shown), agent.backbone, agent.recogniser, asked.embeddings, progress
    )
    return DetectionTable(
        scene=replace(shown, name=asked.scene.name),
        targets=targets,
        trained=asked.embeddings.shape[1],
        view_features=features,
        target_features=asked.features,
        target_embeddings=asked.embeddings,
        scores=scores,
        boxes=boxes,
    )


def _changed(shown: Scene, state: int, change: ImageChange | None, seed: int) -> NDArray[np.uint8]:
    view = shown.view(state)
    return view if change is None else change(view, np.random.default_rng([seed, state]))


def with_detections_changed(
    seen: DetectionTable, change: DetectionChange, threshold: float, seed: int
) -> DetectionTable:
    """The same views, but the recogniser says something else; drawn once for each view and picture."""
    scores, boxes = change(seen.scores, seen.boxes, threshold, np.random.default_rng(seed))
    return replace(seen, scores=scores, boxes=boxes)


def views_of_new_places(
    agent: ActivePerceiver, asked: Sequence[Queries], seen: Sequence[DetectionTable]
) -> dict[str, list[int]]:
    """Which of the views shown are from places that the agent's recogniser was not trained in, for each scene.

    The agent's own record numbers the views of the scene it was trained in; where something stands elsewhere there
    may be other places.
    """
    held_out_views = {}
    for one, shown in zip(asked, seen, strict=True):
        held_out = agent.config.training.held_out_views[one.scene.name]
        trained = np.delete(one.scene.poses[:, :2], held_out, axis=0)
        known = {tuple(place) for place in np.round(trained, 2).tolist()}
        places = np.round(shown.scene.poses[:, :2], 2).tolist()
        held_out_views[one.scene.name] = [view for view, place in enumerate(places) if tuple(place) not in known]
    return held_out_views
