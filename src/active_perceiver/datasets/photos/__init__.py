"""Somebody's photographs of a room, with the poses they were taken at."""
