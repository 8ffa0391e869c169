"""A TurtleBot in a rendered room: the room, the wheels, the camera, and rosbridge in front of it."""
