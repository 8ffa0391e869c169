"""`benchmark train`: how fast policies get good, beside stable-baselines3's."""
