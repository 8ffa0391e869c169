"""Food without a package: fruit and bread."""

from __future__ import annotations

import numpy as np

from indoor_rooms.geometry.curves import arc, lathe, leaf, tube
from indoor_rooms.geometry.mesh import grid_faces, smooth_normals, transform
from indoor_rooms.geometry.pieces import Pieces, bounds
from indoor_rooms.materials import textures
from indoor_rooms.materials.material import Material, from_hex
from indoor_rooms.materials.surfaces import STALK

WHITE = (1.0, 1.0, 1.0)
_REDS = (("#a5121c", "#d8863a"), ("#8a1018", "#b5402a"), ("#b8242a", "#e0b050"))
_GREENS = (("#6fa52c", "#c4d66a"), ("#8fb83a", "#d8dc7a"), ("#5a9430", "#a8c45a"))
_ORANGES = ("#f2831a", "#ee7412", "#f4922c")


def _apple(rng: np.random.Generator, skin: textures.Texture) -> Pieces:
    radius = 0.044 * rng.uniform(0.86, 1.1)
    angle = np.linspace(-np.pi / 2, np.pi / 2, 26)
    reach = radius * np.cos(angle) * (1 + 0.13 * np.sin(angle))
    height = radius * 0.95 * (np.sin(angle) + 1)
    dimple = np.exp(-((reach / (0.32 * radius)) ** 2))
    height += np.where(angle > 0, -0.42, 0.16) * radius * dimple
    reach[[0, -1]] = 0.0
    height -= height.min()
    stalk = tube(
        [[0, 0, height[-1] - 0.004], [0.001, 0, height[-1] + 0.012], [0.006, 0, height[-1] + 0.027]], 0.0019, 8
    )
    blade = transform(leaf(0.034, 0.017, 0.9, 5), (0.002, 0.0, height[-1] + 0.014), (0.0, 0.0, rng.uniform(0, 360)))
    return [
        (lathe(np.stack([reach, height], axis=1), 36), Material(WHITE, skin, roughness=0.28, coat=0.3)),
        (stalk, STALK),
        (blade, Material(from_hex("#5a8a34"), roughness=0.5)),
    ]


def apple(rng: np.random.Generator) -> Pieces:
    """A red apple."""
    return _apple(rng, textures.apple_skin(*_REDS[int(rng.integers(len(_REDS)))], int(rng.integers(4))))


def green_apple(rng: np.random.Generator) -> Pieces:
    """A green apple."""
    return _apple(rng, textures.apple_skin(*_GREENS[int(rng.integers(len(_GREENS)))], 10 + int(rng.integers(4))))


def orange(rng: np.random.Generator) -> Pieces:
    """An orange."""
    radius = 0.044 * rng.uniform(0.86, 1.1)
    angle = np.linspace(-np.pi / 2, np.pi / 2, 24)
    profile = np.stack([radius * np.cos(angle), 0.95 * radius * (np.sin(angle) + 1)], axis=1)
    profile[:, 1] -= 0.06 * radius * np.exp(-((profile[:, 0] / (0.16 * radius)) ** 2)) * np.sign(angle)
    profile[[0, -1], 0] = 0.0
    profile[:, 1] -= profile[:, 1].min()
    peel = textures.citrus_peel(_ORANGES[int(rng.integers(3))], seed=int(rng.integers(4)))
    return [(lathe(profile, 32), Material(WHITE, peel, roughness=0.42))]


def lemon(rng: np.random.Generator) -> Pieces:
    """A lemon lying on its side along x."""
    size = rng.uniform(0.88, 1.1)
    angle = np.linspace(-np.pi / 2, np.pi / 2, 28)
    reach = 0.031 * np.cos(angle) ** 0.85
    along = 0.040 * np.sin(angle) + 0.009 * np.sign(angle) * np.exp(-((reach / 0.009) ** 2))
    reach[[0, -1]] = 0.0
    peel = textures.citrus_peel(
        ("#f6d224", "#f2c81c", "#efdc4a")[int(rng.integers(3))], "#c8a81c", int(rng.integers(4))
    )
    body = transform(lathe(np.stack([reach, along], axis=1), 30), rotate=(0.0, 90.0, 0.0), scale=size)
    return [(transform(body, (0.0, 0.0, -float(bounds([body])[0, 2]))), Material(WHITE, peel, roughness=0.36))]


def banana(rng: np.random.Generator) -> Pieces:
    """A bunch of three or four bananas lying on their side, joined at the stalk."""
    points, bend = 18, 0.125 * rng.uniform(0.95, 1.1)
    skin = Material(
        WHITE,
        textures.banana_skin(("#f2ca3a", "#ecc02c", "#e8d04a")[int(rng.integers(3))], int(rng.integers(4))),
        roughness=0.42,
    )
    path = arc((0.0, 0.0, 0.0), bend, -152, -48, points, "xy")
    start = path[0].copy()
    thickness = np.interp(np.linspace(0, 1, points), [0, 0.08, 0.2, 0.5, 0.85, 0.97, 1], [5, 6, 16, 20, 16, 7, 4])
    pieces: Pieces = []
    for index in range(int(rng.integers(3, 5))):
        fruit = tube(path - start, thickness * 0.001 * rng.uniform(0.95, 1.04), 10)
        # v runs from the stalk, the texture from the tip.
        flipped = fruit.uvs * [1.0, -1.0] + [0.0, 1.0]
        fruit = type(fruit)(fruit.vertices, fruit.normals, flipped, fruit.faces)
        fruit = transform(fruit, rotate=(0.0, -4.0 * (index % 2), 14.0 * index + rng.uniform(-2, 2)))
        pieces.append((fruit, skin))
    box = bounds(mesh for mesh, _ in pieces)
    centre = (box[0] + box[1]) / 2
    offset = (-float(centre[0]), -float(centre[1]), -float(box[0, 2]))
    return [(transform(mesh, offset), material) for mesh, material in pieces]


def bread(rng: np.random.Generator) -> Pieces:
    """A loaf with cuts across its crust, lying along x."""
    length, width, height = rng.uniform(0.24, 0.3), rng.uniform(0.11, 0.135), rng.uniform(0.09, 0.115)
    across, around = 34, 36
    along = np.sin(np.linspace(-np.pi / 2, np.pi / 2, across))
    angle = np.linspace(-np.pi / 2, 1.5 * np.pi, around + 1)
    taper = np.sqrt(np.clip(1 - np.abs(along) ** 2.6, 4e-4, 1.0))[:, None]
    # A superellipse, flat beneath; the crust bulges between the cuts.
    y = np.sign(np.cos(angle)) * np.abs(np.cos(angle)) ** 0.75
    z = np.sign(np.sin(angle)) * np.abs(np.sin(angle)) ** np.where(np.sin(angle) > 0, 0.9, 0.35)
    bulge = 1 + 0.05 * np.cos(2 * np.pi * 4 * (along[:, None] + 1) / 2 + np.pi) * np.clip(z, 0, 1)
    low, high = 0.30 * height, 0.70 * height
    rise = np.where(z > 0, z * high * bulge, z * low) * (0.25 + 0.75 * taper)
    vertices = np.stack(
        np.broadcast_arrays(along[:, None] * length / 2, -y * width / 2 * taper, rise + low), axis=-1
    ).reshape(-1, 3)
    u, v = np.meshgrid(np.linspace(0, 1, across), np.linspace(0, 1, around + 1), indexing="ij")
    mesh = smooth_normals(vertices, np.stack([u, v], axis=-1).reshape(-1, 2), grid_faces(across, around + 1))
    mesh = transform(mesh, (0.0, 0.0, -float(mesh.vertices[:, 2].min())))
    shade = float(rng.uniform(0.72, 1.0))
    return [
        (
            mesh,
            Material(
                (shade, shade * 0.98, shade * 0.95),
                textures.bread_crust(int(rng.integers(6))),
                roughness=0.75,
                specular=0.25,
            ),
        )
    ]
