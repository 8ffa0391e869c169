"""Helpers that know nothing of searching: files, progress, memory, linear algebra, result files."""
