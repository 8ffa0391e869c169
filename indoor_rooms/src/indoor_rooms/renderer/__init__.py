"""The renderer: rays, light, shading and the camera."""
