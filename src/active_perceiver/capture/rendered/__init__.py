"""From a room to a scene file: views, boxes, the store that makes it resumable."""
