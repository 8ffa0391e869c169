"""Training an agent: the recipe, its stages, and what is kept of it."""
