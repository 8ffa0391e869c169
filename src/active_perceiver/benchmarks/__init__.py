"""How fast and how good it is on this machine: `active-perceiver benchmark ...`, a folder for each."""
