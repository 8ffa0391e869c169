"""What `benchmark recogniser` trains: the default recogniser, others that lack one ingredient, and the paper's."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any, Literal

from active_perceiver.benchmarks.config import RecogniserBenchmarkConfig
from active_perceiver.errors import UserError
from active_perceiver.recognition.augmentation import AugmentationConfig
from active_perceiver.recognition.train import CONFIGS, NO_AUGMENTATION, RecogniserConfig
from active_perceiver.scenes import Scene

EVERY = 4
"""Of a scene's targets, in their order, every fourth one is held out from the first on."""


@dataclass(frozen=True)
class Variant:
    """A recogniser to be trained.

    Attributes:
        meaning: in a line, what is different from the default.
        kind: of the defaults that it differs from, a name in `CONFIGS`.
        changes: fields of `RecogniserConfig`.
        hides_targets: whether it is not trained on every fourth target.
        never_learned: the measurement that is of targets which it has not learned; none if it has learned all.
    """

    meaning: str
    kind: str = "matching"
    changes: Mapping[str, Any] = field(default_factory=dict)
    hides_targets: bool = False
    never_learned: Literal["unknown targets", "unseen pictures"] | None = None

    def config(self, scene: Scene, settings: RecogniserBenchmarkConfig, seed: int) -> RecogniserConfig:
        """How it is trained in a scene."""
        steps = {} if settings.steps is None or self.changes.get("steps") == 0 else {"steps": settings.steps}
        return replace(
            CONFIGS[self.kind],
            **{**self.changes, **steps},
            held_out_targets=scene.target_names[::EVERY] if self.hides_targets else (),
            seed=seed,
            threads=settings.threads,
        )


VARIANTS: dict[str, Variant] = {
    "default": Variant("as `train` has it"),
    "from scratch": Variant("random weights to start from", changes={"start": "scratch"}),
    "no further views": Variant("no changed copies of views", changes={"augmentation": AugmentationConfig(views=0)}),
    "no further pictures": Variant(
        "neither changed copies of target pictures nor cut-outs",
        changes={"augmentation": AugmentationConfig(pictures=0, crops=0)},
    ),
    "no cut-outs": Variant(
        "no target pictures cut out of views", changes={"augmentation": AugmentationConfig(crops=0)}
    ),
    "no averaging": Variant("the last weights, not their running mean", changes={"averaging": 0.0}),
    "float32": Variant("no product in bfloat16", changes={"precision": "float32"}),
    "1400 steps": Variant("fewer updates", changes={"steps": 1400}),
    "as before": Variant(
        "without all of these: from scratch, nothing further, no averaging, float32, 1400 steps",
        changes={
            "start": "scratch", "augmentation": NO_AUGMENTATION, "averaging": 0.0, "precision": "float32",
            "steps": 1400,
        },
    ),
    "targets held out": Variant(
        "every fourth target of the scene not learned", hides_targets=True, never_learned="unknown targets"
    ),
    "from scratch, targets held out": Variant(
        "nor any other thing of their kind, in other rooms",
        changes={"start": "scratch"},
        hides_targets=True,
        never_learned="unknown targets",
    ),
    "not trained here": Variant(
        "the weights learned in other rooms as they are", changes={"steps": 0}, never_learned="unseen pictures"
    ),
    "pooled": Variant("the paper's recogniser", kind="pooled"),
    "pooled, targets held out": Variant(
        "the paper's, every fourth target not learned",
        kind="pooled",
        hides_targets=True,
        never_learned="unknown targets",
    ),
}  # fmt: skip


def chosen_variants(settings: RecogniserBenchmarkConfig) -> dict[str, Variant]:
    """The variants that the settings name, in the order of `VARIANTS`; all if they name none.

    Raises:
        UserError: if there is none of a name, or the numbers make no sense.
    """
    if unknown := [name for name in settings.variants if name not in VARIANTS]:
        raise UserError(f"there is no variant '{unknown[0]}'; there are {', '.join(map(repr, VARIANTS))}")
    given = [number for number in (settings.seeds, settings.steps, settings.threads) if number is not None]
    if min(given) < 1:
        raise UserError("seeds, steps and threads must be at least 1; the variant 'not trained here' has no steps")
    return {name: variant for name, variant in VARIANTS.items() if not settings.variants or name in settings.variants}
