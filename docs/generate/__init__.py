"""Fills the marked blocks of README and docs from committed result files and from the package: `make docs`."""
