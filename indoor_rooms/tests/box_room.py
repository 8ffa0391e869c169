"""Small rooms of quads and boxes whose pictures and light can be computed by hand."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from indoor_rooms.geometry.mesh import Mesh, merge, quad
from indoor_rooms.materials.material import Material
from indoor_rooms.room import Lamp, Part, Room, Sun

WIDTH, DEPTH, HEIGHT = 4.0, 3.0, 2.5
GREY = Material((0.5, 0.5, 0.5), roughness=0.9)
# East of the room's middle, between the camera and the east wall.
BOX = ((3.0, 1.3, 1.0), (3.2, 1.7, 1.4))
TABLE = np.array([[1.0, 0.4], [1.6, 0.4], [1.6, 1.0], [1.0, 1.0]])


def solid(low: Sequence[float], high: Sequence[float]) -> Mesh:
    """An axis-aligned box seen from outside."""
    start = np.array(low, float)
    x, y, z = np.diag(np.array(high, float) - start)
    faces = [(start, y, x), (start + z, x, y), (start, x, z), (start + y, z, x), (start, z, y), (start + x, y, z)]
    return merge([quad(tuple(corner), tuple(right), tuple(up)) for corner, right, up in faces])


def walls() -> tuple[Part, ...]:
    """Floor, ceiling and four walls, seen from inside."""
    x, y, z = (WIDTH, 0, 0), (0, DEPTH, 0), (0, 0, HEIGHT)
    back_x, back_y = (-WIDTH, 0, 0), (0, -DEPTH, 0)
    return (
        Part("floor", quad((0, 0, 0), x, y), GREY),
        Part("ceiling", quad((0, DEPTH, HEIGHT), x, back_y), GREY),
        Part("wall", quad((0, 0, 0), y, z), GREY),
        Part("wall", quad((WIDTH, 0, 0), back_x, z), GREY),
        Part("wall", quad((0, DEPTH, 0), x, z), GREY),
        Part("wall", quad((WIDTH, DEPTH, 0), back_y, z), GREY),
    )


def make_room(
    parts: tuple[Part, ...],
    sky: tuple[float, float, float] = (0.0, 0.0, 0.0),
    sun: Sun | None = None,
    lamps: tuple[Lamp, ...] = (),
    targets: dict[str, str] | None = None,
    obstacles: tuple[tuple[str, np.ndarray], ...] = (),
) -> Room:
    """A room of the standard size."""
    return Room("test-1", (WIDTH, DEPTH, HEIGHT), parts, targets or {}, sun, sky, lamps, obstacles)


def box_room() -> Room:
    """A closed room with a lamp, a red box and a table."""
    edges = ((0.0, 1.0, 0.0), (1.0, 0.0, 0.0))
    lamp = Lamp("lamp", (2.0, 1.5, HEIGHT - 0.02), edges, 0.0, (8.0, 8.0, 8.0))
    glow = Part("lamp", quad((1.5, 1.0, HEIGHT - 0.02), *edges), Material((1.0, 1.0, 1.0), emission=8.0))
    box = Part("box", solid(*BOX), Material((0.7, 0.1, 0.1), roughness=0.6))
    table = Part("table", solid((1.0, 0.4, 0.0), (1.6, 1.0, 0.7)), Material((0.3, 0.2, 0.1)))
    return make_room(
        (*walls(), glow, box, table), lamps=(lamp,), targets={"box": "carton"}, obstacles=(("table", TABLE),)
    )
