"""Scenes of what was captured elsewhere: photographs, and the files of other projects."""
