"""The card that goes with every agent: what it is, how good it is, how to use it (Hugging Face Hub layout)."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

from active_perceiver.agent.config import AgentConfig, SearchKind
from active_perceiver.utils.files import replacing
from active_perceiver.utils.result import format_number


@dataclass(frozen=True)
class _Words:
    """What a card says differently of agents that search for different things."""

    tags: str
    searched: str
    arrived: str
    picture: str
    right: str


_WORDS: dict[SearchKind, _Words] = {
    "object": _Words(
        "active-perception, object-search, visual-navigation",
        "an object",
        "in front of the object",
        "mug.jpg",
        "if its box is on the object (IoU at least 0.5)",
    ),
    "view": _Words(
        "active-perception, visual-navigation",
        "one of the views it was trained for, which are in `targets`",
        "where that picture was taken",
        "view.png",
        "at the very state whose view it was given",
    ),
}


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
    words = _WORDS[config.task]
    own = body["stop_evaluation"]["pictures_seen"]
    rows = [
        [result["scene"], result["target"],
         format_number(result["success"]), format_number(result["mean_steps"], ".2f"), format_number(result["ratio"]),
         *(format_number(word[name], ".2f") for name in ("true_found", "false_found"))]
        for result, word in zip(body["per_target"], own["per_target"], strict=True)
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

Backbone: {config.backbone} at {config.image_size} pixels. Recogniser: {config.recogniser}. Learner:
{config.training["learner"]}, seed {config.training["seed"]}.

## Searches

Success, steps and their ratio to the shortest paths are exact, over all starts; "found" is said by the agent itself,
true {words.right}, in {own["per_target"][0]["searches"]} searches from random starts.

| scene | target | success | steps | ratio | found, true | found, false |
|---|---|---|---|---|---|---|
{_lines(rows)}
{_recogniser_section(body)}
`result.json` has all figures, the settings and the machine.
"""


def _recogniser_section(body: dict[str, Any]) -> str:
    """How well it recognises objects; nothing if it does not."""
    if "recogniser" not in body:
        return ""
    rows = [
        [pictures, *(format_number(metrics[name]) for name in ("auroc", "ap50", "mean_iou"))]
        for pictures, metrics in body["recogniser"]["metrics"].items()
    ]
    return f"""
## Recogniser, in places it was not trained in

| | AUROC | AP50 | mean IoU |
|---|---|---|---|
{_lines(rows)}
"""


def _lines(rows: list[list[str]]) -> str:
    return "\n".join(f"| {' | '.join(row)} |" for row in rows)
