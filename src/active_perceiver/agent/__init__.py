"""The agent: what it is made of, how it decides at each view, when it says that it has found what it looks for."""
