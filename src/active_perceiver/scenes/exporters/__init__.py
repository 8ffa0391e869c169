"""Scenes written for other software: labelling tools, and other projects."""
