"""Meshes and the primitives everything in a room is made of."""
