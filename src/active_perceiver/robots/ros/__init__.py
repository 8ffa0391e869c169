"""A robot behind rosbridge: its settings, its messages, the connection, and the robot itself."""
