"""The card that goes with every agent: what it is, how good it is, how to use it (Hugging Face Hub layout)."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from active_perceiver.agent_config import AgentConfig
from active_perceiver.experiments.result import shown
from active_perceiver.files import replacing


def write_card(folder: Path, config: AgentConfig, body: dict[str, Any]) -> None:
    """Write `README.md` into an agent's folder.

    Args:
        folder: the agent.
        config: its configuration.
        body: of its result file.
    """
    with replacing(folder / "README.md") as temporary:
        temporary.write_text(card_text(config, body))


def card_text(config: AgentConfig, body: dict[str, Any]) -> str:
    """The card as Markdown."""
    scenes = ", ".join(config.branches)
    words = body["own_word"]["pictures_seen"]
    rows = [
        [result["scene"], result["target"], shown(result["success"]), shown(result["mean_steps"], ".2f"),
         shown(result["ratio"]), shown(word["true_found"], ".2f"), shown(word["false_found"], ".2f")]
        for result, word in zip(body["per_target"], words["per_target"], strict=True)
    ]  # fmt: skip
    recogniser = [
        [pictures, *(shown(metrics[name]) for name in ("auroc", "ap50", "mean_iou"))]
        for pictures, metrics in body["recogniser"]["metrics"].items()
    ]
    return f"""---
library_name: active-perceiver
pipeline_tag: robotics
tags: [active-perception, object-search, visual-navigation]
license: apache-2.0
---

# An agent that searches {scenes}

Give it a picture of an object; it looks at one camera image after the other, says what to do next, and says by itself
when it is in front of the object. It was trained in {scenes} and knows these rooms only.

```python
from active_perceiver.perceiver import ActivePerceiver

agent = ActivePerceiver.from_pretrained("this/folder")
agent.reset("mug.jpg", scene="{next(iter(config.branches))}")
step = agent.act(image)  # (H, W, 3) uint8 RGB -> action, detection, probabilities, found
```

Backbone: {config.backbone} at {config.image_size} pixels. Recogniser: {config.recogniser}. Learner:
{config.training["learner"]}, seed {config.training["seed"]}.

## Searches

Success, steps and their ratio to the shortest paths are exact, over all starts; "found" is the agent's own word, true
if its box is on the object (IoU at least 0.5), in {words["per_target"][0]["searches"]} searches from random starts.

| scene | target | success | steps | ratio | found, true | found, false |
|---|---|---|---|---|---|---|
{_lines(rows)}

## Recogniser, in places it was not trained in

| | AUROC | AP50 | mean IoU |
|---|---|---|---|
{_lines(recogniser)}

`result.json` has all figures, the settings and the machine.
"""


def _lines(rows: list[list[str]]) -> str:
    return "\n".join(f"| {' | '.join(row)} |" for row in rows)
