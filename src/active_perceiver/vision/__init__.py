"""Vision: the frozen feature extractor and the cache of what it makes of a scene. Importing this needs no torch."""

from active_perceiver.vision.backbone import BACKBONES, Backbone, load_backbone, pooled, pooled_middle
from active_perceiver.vision.cache import SceneFeatures, scene_features
from active_perceiver.vision.sessions import BackboneError

__all__ = [
    "BACKBONES",
    "Backbone",
    "BackboneError",
    "SceneFeatures",
    "load_backbone",
    "pooled",
    "pooled_middle",
    "scene_features",
]
