"""Boxes as COCO files, which labelling tools write and read."""
