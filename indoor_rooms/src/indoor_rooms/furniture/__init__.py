"""Furniture, appliances and fixtures of a room, made of parameters."""
