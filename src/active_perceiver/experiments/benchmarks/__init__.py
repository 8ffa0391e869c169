"""How fast it is on this machine: `active-perceiver benchmark env` and `benchmark act`."""
