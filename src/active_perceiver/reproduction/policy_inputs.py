"""What the policy is shown in each scene: by the paper's recogniser, cross-validated, or by the ground truth."""

from __future__ import annotations

import hashlib
import json
from dataclasses import asdict
from pathlib import Path
from typing import Any, Literal

import numpy as np

from active_perceiver.envs.observations import Observations
from active_perceiver.envs.task import SearchTask
from active_perceiver.evaluation.agent_scenes import features_of
from active_perceiver.policies.training_task import TrainingTask
from active_perceiver.recognition.cross_validation import CrossValidated, cross_validate
from active_perceiver.recognition.train import RecogniserConfig
from active_perceiver.scenes import Scene, open_scene
from active_perceiver.utils.progress import progress_bar
from active_perceiver.vision.backbone import Backbone
from active_perceiver.vision.cache import SceneFeatures

Boxes = Literal["recogniser", "ground-truth"]


class PolicyInputs:
    """The scenes and what is seen in them; everything is made when it is first asked for, and kept.

    Args:
        folder: where the detections of cross-validated recognisers are kept.
        backbone: of the features.
        recogniser: how it is trained.
        folds: of the cross-validation.
        boxes: whose boxes the policy is shown.
    """

    def __init__(
        self, folder: Path, backbone: Backbone, recogniser: RecogniserConfig, folds: int, boxes: Boxes
    ) -> None:
        self.boxes: Boxes = boxes
        self._folder = folder
        self._backbone = backbone
        self._recogniser = recogniser
        self._folds = folds
        self._scenes: dict[str, tuple[Scene, SceneFeatures]] = {}
        self._detections: dict[str, CrossValidated] = {}

    def scene(self, name: str) -> Scene:
        """A scene by name."""
        return self._opened(name)[0]

    def training_task(self, name: str, targets: tuple[str, ...], boxes: Boxes | None = None) -> TrainingTask:
        """The search for some targets of a scene, each with its first picture: the paper has one each.

        Args:
            name: of the scene.
            targets: what is searched for.
            boxes: whose boxes the policy is shown; `self.boxes` if None.
        """
        scene, features = self._opened(name)
        task = SearchTask.from_scene(scene, targets)
        index = [scene.target_index(target) for target in targets]
        pictures = features.target_features[index][:, :1]
        if (boxes or self.boxes) == "ground-truth":
            return TrainingTask(
                task, Observations.from_boxes(features.view_features, pictures, scene.boxes[:, index])
            )
        found = self.detections(name)
        seen, where = found.seen[:, index, :1].astype(np.float32), found.boxes[:, index, :1]
        return TrainingTask(task, Observations.from_detections(features.view_features, pictures, seen, where))

    def detections(self, name: str) -> CrossValidated:
        """What recognisers see in the views of the places that they were not trained in."""
        if name not in self._detections:
            scene, features = self._opened(name)
            path = self._folder / f"{name}-{self.fingerprint(name, 'recogniser')}.npz"
            if not path.exists():
                with progress_bar(f"{self._folds} recognisers of {name}") as report:
                    made = cross_validate(scene, features, self._recogniser, self._folds, report)
                made.save(path)
            self._detections[name] = CrossValidated.load(path)
        return self._detections[name]

    def fingerprint(self, name: str, boxes: Boxes | None = None) -> str:
        """Short hash of everything that the sights of a scene depend on; arguments as of `problem`."""
        boxes = boxes or self.boxes
        facts: dict[str, Any] = {
            "scene": self.scene(name).content_hash,
            "backbone": self._backbone.fingerprint,
            "image_size": self._backbone.image_size,
            "boxes": boxes,
        }
        if boxes == "recogniser":
            facts |= {"recogniser": asdict(self._recogniser), "folds": self._folds}
        return short_hash(facts)

    def _opened(self, name: str) -> tuple[Scene, SceneFeatures]:
        if name not in self._scenes:
            scene = open_scene(name)
            self._scenes[name] = (scene, features_of(scene, self._backbone))
        return self._scenes[name]


def short_hash(facts: dict[str, Any]) -> str:
    """Eight hexadecimal digits that differ if the facts do."""
    return hashlib.sha256(json.dumps(facts, sort_keys=True).encode()).hexdigest()[:8]
