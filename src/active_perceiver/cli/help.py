"""What `--help` says about a command, in one form for all."""

from __future__ import annotations


def help_text(summary: str, *examples: str) -> str:
    """What `--help` says about a command."""
    lines = "\n".join(f"  active-perceiver {example}" for example in examples)
    return f"{summary}\n\nExamples:\n{lines}"
