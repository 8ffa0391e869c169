"""From something that moves and looks to a scene: walking every pose and keeping what was seen."""
