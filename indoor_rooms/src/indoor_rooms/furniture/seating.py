"""Table, chair, rug. Centred at the origin on z = 0; metres."""

from __future__ import annotations

import numpy as np

from indoor_rooms.geometry.boxes import rounded_box, slab
from indoor_rooms.geometry.curves import smooth_profile, tube
from indoor_rooms.geometry.mesh import merge, transform, with_uvs
from indoor_rooms.geometry.pieces import Pieces, standing
from indoor_rooms.materials import textures
from indoor_rooms.materials.material import Material
from indoor_rooms.materials.surfaces import cloth, printed

TABLE_HEIGHT = 0.75


def table(width: float, depth: float, top: Material, frame: Material) -> Pieces:
    """A dining table with four tapered legs."""
    board = transform(rounded_box((width, depth, 0.032), 0.010, 2, 0.9), (0.0, 0.0, TABLE_HEIGHT - 0.016))
    x, y = width / 2 - 0.07, depth / 2 - 0.07
    under = TABLE_HEIGHT - 0.033
    legs = [
        tube([[sx * (x + 0.012), sy * (y + 0.012), 0.0004], [sx * x, sy * y, under]], [0.019, 0.031], 16)
        for sx in (-1, 1)
        for sy in (-1, 1)
    ]
    rails = []
    for side in (-1, 1):
        rails.append(transform(rounded_box((2 * x - 0.05, 0.020, 0.08), 0.003), (0.0, side * y, under - 0.041)))
        rails.append(transform(rounded_box((0.020, 2 * y - 0.05, 0.08), 0.003), (side * x, 0.0, under - 0.041)))
    return [(board, top), (merge([*legs, *rails]), frame)]


def chair(material: Material, cushion: str | None = "#c9bda6") -> Pieces:
    """A wooden chair facing +y, its seat 0.45 m high; `cushion` is its seat pad's colour."""
    seat = transform(rounded_box((0.42, 0.41, 0.026), 0.012, 2, 1.6), (0.0, 0.0, 0.432))
    parts = [seat]
    for side in (-1, 1):
        parts.append(tube([[side * 0.195, 0.185, 0.0], [side * 0.175, 0.165, 0.422]], [0.012, 0.018], 12))
        back = [
            [side * 0.195, -0.215, 0.0],
            [side * 0.178, -0.18, 0.43],
            [side * 0.178, -0.19, 0.62],
            [side * 0.175, -0.235, 0.90],
        ]
        parts.append(tube(smooth_profile(back), [0.012, 0.018, 0.017, 0.013], 12))
        parts.append(tube([[side * 0.187, 0.17, 0.2], [side * 0.188, -0.195, 0.2]], 0.009, 8))
    for height, lean in ((0.84, -0.226), (0.70, -0.206), (0.58, -0.194)):
        across = np.linspace(-0.172, 0.172, 9)
        bow = np.stack([across, lean - 0.030 * (1 - (across / 0.172) ** 2), np.full(9, height)], axis=1)
        # A rail is a tube drawn out upwards: a thin board with round edges.
        rail = transform(tube(bow - [0.0, 0.0, height], 0.010, 12), (0.0, 0.0, height), scale=(1.0, 1.0, 2.6))
        parts.append(rail)
    pieces: Pieces = [(merge(parts), material)]
    if cushion:
        pad = transform(rounded_box((0.385, 0.37, 0.034), 0.016, 3, 4.0), (0.0, 0.008, 0.4625))
        pieces.append((pad, cloth(cushion)))
    return standing(pieces)


def rug(width: float, depth: float, ground: str, lines: str, accent: str) -> Pieces:
    """A thin rug with a border and diamonds."""
    mesh = slab((-width / 2, width / 2), (-depth / 2, depth / 2), [[True]], 0.0, 0.009)
    uvs = mesh.vertices[:, :2] / (width, depth) + 0.5
    return [(with_uvs(mesh, uvs), printed(textures.rug(ground, lines, accent), 1.0))]
