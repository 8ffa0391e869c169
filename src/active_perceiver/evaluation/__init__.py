"""How good an agent is: its detections, its policy, and the searches that it ends itself."""
