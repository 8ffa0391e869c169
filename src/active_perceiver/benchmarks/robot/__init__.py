"""`benchmark robot`: a robot that is never quite on the lattice."""
