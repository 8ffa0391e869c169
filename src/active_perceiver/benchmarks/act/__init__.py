"""`benchmark act`: how long one action takes, and what a start costs."""
