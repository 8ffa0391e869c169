"""Pages that show what was searched, measured or trained, each one file."""
