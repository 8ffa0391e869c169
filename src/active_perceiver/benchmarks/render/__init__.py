"""`benchmark render`: how long rooms take to make, to light and to photograph."""
