"""Scenes of what was captured elsewhere: a folder a format, with a reader and, for some, a writer."""
