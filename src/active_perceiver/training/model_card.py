"""The card that goes with every agent: what it is, how good it is, how to use it (Hugging Face Hub layout)."""

from __future__ import annotations

from pathlib import Path

from active_perceiver.agent.config import AgentConfig
from active_perceiver.agent.goals import GOALS
from active_perceiver.evaluation.agent_evaluation import SEEN
from active_perceiver.training.training_result import RecogniserFigures, TrainingResult
from active_perceiver.utils.files import replacing
from active_perceiver.utils.result import format_number


def write_card(folder: Path, config: AgentConfig, result: TrainingResult) -> None:
    """Write `README.md` into an agent's folder.

    Args:
        folder: the agent.
        config: its configuration.
        result: of its training.
    """
    with replacing(folder / "README.md") as temporary:
        temporary.write_text(card_text(config, result))


def card_text(config: AgentConfig, result: TrainingResult) -> str:
    """The card as Markdown."""
    scenes = ", ".join(config.branches)
    words = GOALS[config.task].words
    own = result.evaluation.stops[SEEN].per_target
    rows = [
        [led.scene, led.target,
         format_number(led.success), format_number(led.mean_steps, ".2f"), format_number(led.ratio),
         *(format_number(share, ".2f") for share in (ended.true_found, ended.false_found))]
        for led, ended in zip(result.evaluation.policy.per_target, own, strict=True)
    ]  # fmt: skip
    return f"""---
library_name: active-perceiver
pipeline_tag: robotics
tags: [{words.tags}]
license: apache-2.0
---

# An agent that searches {scenes}

Give it a picture of {words.searched}; it looks at one camera image after the other, says what to do next, and says by
itself when it is {words.arrived}. It was trained in {scenes} and knows these rooms only.

```python
from active_perceiver import ActivePerceiver

agent = ActivePerceiver.from_pretrained("this/folder")
agent.reset("{words.picture}", scene="{next(iter(config.branches))}")
step = agent.act(image)  # (H, W, 3) uint8 RGB -> action, detection, probabilities, found
```

Backbone: {config.backbone} at {config.image_size} pixels. Recogniser: {config.recogniser or "none"}. Learner:
{config.training.learner}, seed {config.training.seed}.

## Searches

Success, steps and their ratio to the shortest paths are exact, over all starts; "found" is said by the agent itself,
true {words.right}, in {own[0].searches} searches from random starts.

| scene | target | success | steps | ratio | found, true | found, false |
|---|---|---|---|---|---|---|
{_lines(rows)}
{_recogniser_section(result.recogniser)}
`result.json` has all figures, the settings and the machine.
"""


def _recogniser_section(figures: RecogniserFigures | None) -> str:
    """How well it recognises objects; nothing if it does not."""
    if figures is None:
        return ""
    rows = [
        [pictures, *(format_number(metrics[name]) for name in ("auroc", "ap50", "mean_iou"))]
        for pictures, metrics in figures.metrics.items()
    ]
    return f"""
## Recogniser, in places it was not trained in

| | AUROC | AP50 | mean IoU |
|---|---|---|---|
{_lines(rows)}
"""


def _lines(rows: list[list[str]]) -> str:
    return "\n".join(f"| {' | '.join(row)} |" for row in rows)
