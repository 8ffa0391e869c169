"""An agent on a robot: one folder without torch, with 8-bit numbers if asked for, and a way to try it."""
