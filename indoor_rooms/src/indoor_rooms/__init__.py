"""3D rooms made by code: geometry, materials, objects, furniture and layouts; baked light; a camera; capture.

A room's content is plain data (`Room`); `bake` computes its light, `render` photographs it from any pose, `capture`
turns it into a Scene. Rendering needs the `rooms` extra (Embree and Open Image Denoise).
"""

from indoor_rooms.layouts import LAYOUTS, make_room
from indoor_rooms.room import Lamp, Part, Room, Sun

__all__ = ["LAYOUTS", "Lamp", "Part", "Room", "Sun", "make_room"]
