"""`benchmark policies`: how good policies are in many rooms, over many seeds."""
