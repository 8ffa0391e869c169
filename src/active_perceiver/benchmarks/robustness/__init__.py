"""`benchmark robustness`: an agent that sees something else than it was trained on."""
