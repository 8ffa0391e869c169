"""`benchmark env`: environment steps per second."""
