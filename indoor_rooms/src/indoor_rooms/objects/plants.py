"""House plants: pots of several shapes, and several habits of leaves."""

from __future__ import annotations

import numpy as np

from indoor_rooms.geometry.curves import disc, lathe, leaf, smooth_profile, tube
from indoor_rooms.geometry.mesh import Mesh, grid_faces, merge, smooth_normals, transform
from indoor_rooms.geometry.pieces import Pieces
from indoor_rooms.materials import prints_patterns
from indoor_rooms.materials.material import Material, from_hex
from indoor_rooms.materials.surfaces import glazed, glossy_print, patterned, plastic
from indoor_rooms.objects.shaping import PALETTE, blob, pick, two_colours

SOIL = Material(from_hex("#4a3526"), roughness=0.95, specular=0.1)
GREENS = ("#3f7a34", "#4f8a3a", "#2f6a3c", "#6f9a44", "#7fae4a", "#3a6a5a", "#8a9f5a")


def house_plant(rng: np.random.Generator) -> Pieces:
    """A potted plant for a table or sill."""
    radius, height = rng.uniform(0.055, 0.08), rng.uniform(0.09, 0.13)
    habit = (_swords, _rubber_tree, _fountain, _cactus, _rosette, _bush)[int(rng.integers(6))]
    pot, level = _pot(rng, radius, height)
    green = Material(from_hex(pick(rng, GREENS)), roughness=rng.uniform(0.35, 0.6))
    plant = [(transform(mesh, (0.0, 0.0, level - 0.004)), material) for mesh, material in habit(rng, radius, green)]
    return [*pot, *plant]


def _pot(rng: np.random.Generator, radius: float, height: float) -> tuple[Pieces, float]:
    """A pot filled with soil, and the soil's height."""
    colour, other = two_colours(rng)
    look = (
        Material(from_hex(pick(rng, ("#c4744a", "#a85a38", "#d88a60"))), roughness=0.85),
        glazed(colour),
        glazed(pick(rng, ("#f2f2ef", "#e6dfd0", "#3a3d42")), 0.35),
        glossy_print(prints_patterns.pattern(pick(rng, prints_patterns.PATTERNS), colour, other, "#f2f2ef", 4, 0.0)),
        patterned(prints_patterns.cane("#6a4526", "#c9a06a", colour)),
    )[int(rng.integers(5))]
    level = height - 0.012
    shape, wall = int(rng.integers(4)), 0.006
    if shape == 0:  # the flower pot with its collar
        outside = [(radius * 0.68, 0.0), (radius * 0.9, height * 0.74), (radius, height * 0.74), (radius, height)]
    elif shape == 1:
        outside = [(radius * 0.94, 0.0), (radius, 0.006), (radius, height)]
    elif shape == 2:
        outside = [
            (radius * 0.5, 0.0),
            (radius * 0.8, height * 0.1),
            (radius * 1.12, height * 0.5),
            (radius * 0.9, height),
        ]
    else:
        outside = [
            (radius * 0.6, 0.0),
            (radius * 0.62, height * 0.08),
            (radius * 0.5, height * 0.14),
            (radius * 0.9, height * 0.5),
            (radius, height),
        ]
    mouth = outside[-1][0] - wall
    inside = [(mouth, height), (mouth, level - 0.004)]
    line = np.concatenate([[(0.0, 0.0)], smooth_profile([*outside, *inside], 1), [(0.0, level - 0.004)]])
    return [(lathe(line, 36, (2.0, 1.0)), look), (disc(mouth + 0.001, level), SOIL)], level


def _around(rng: np.random.Generator, blades: list[Mesh], rim: float) -> Mesh:
    """Leaves turned about the middle by the golden angle, each growing from within `rim` metres of it."""
    return merge(
        [
            transform(
                transform(blade, (rim * rng.uniform(0.1, 1.0), 0, 0)),
                rotate=(0.0, 0.0, 137.5 * index + rng.uniform(-14, 14)),
            )
            for index, blade in enumerate(blades)
        ]
    )


def _swords(rng: np.random.Generator, radius: float, green: Material) -> Pieces:
    """Stiff upright leaves with pale edges."""
    tall = rng.uniform(0.2, 0.3)
    sizes = [(tall * rng.uniform(0.55, 1.0), rng.uniform(0.028, 0.04), rng.uniform(0.02, 0.16)) for _ in range(11)]
    inner = _around(rng, [leaf(size, width, bend, 7) for size, width, bend in sizes], radius * 0.5)
    return [(inner, green)]


def _rubber_tree(rng: np.random.Generator, radius: float, green: Material) -> Pieces:
    """A stem with large oval leaves."""
    tall, count = rng.uniform(0.2, 0.27), int(rng.integers(9, 14))
    stem = tube([[0.0, 0.0, 0.0], [0.008, 0.004, tall * 0.5], [-0.004, 0.006, tall]], [0.005, 0.0035], 8)
    leaves = []
    for index in range(count):
        share = 0.25 + 0.75 * index / (count - 1)
        blade = leaf(
            rng.uniform(0.085, 0.125),
            rng.uniform(0.05, 0.065),
            rng.uniform(0.55, 0.95) * (1.15 - 0.5 * share),
            6,
            0.12,
        )
        leaves.append(transform(blade, (0.0, 0.0, tall * share), (0.0, 0.0, 137.5 * index + rng.uniform(-15, 15))))
    return [(merge(leaves), Material(green.colour, roughness=0.3, coat=0.3)), (stem, plastic("#6a5236", 0.8))]


def _fountain(rng: np.random.Generator, radius: float, green: Material) -> Pieces:
    """Many narrow leaves that arch over and hang, some with a pale stripe."""
    count, width = int(rng.integers(30, 42)), rng.uniform(0.011, 0.017)
    blades = [
        leaf(rng.uniform(0.15, 0.26), width, rng.uniform(0.35, 0.95), 7, rng.uniform(0.1, 0.5)) for _ in range(count)
    ]
    pale = Material(from_hex("#c9d89a"), roughness=0.5) if rng.random() < 0.5 else green
    return [(_around(rng, blades[::2], radius * 0.3), green), (_around(rng, blades[1::2], radius * 0.3), pale)]


def _cactus(rng: np.random.Generator, radius: float, green: Material) -> Pieces:
    """A ribbed column or ball with a flower on top, perhaps with arms."""
    tall, wide, ribs = rng.uniform(0.1, 0.22), radius * rng.uniform(0.5, 0.75), int(rng.integers(8, 13))

    def column(width: float, height: float) -> Mesh:
        angle, along = np.meshgrid(np.linspace(0, 2 * np.pi, 6 * ribs + 1), np.linspace(0, np.pi / 2, 9))
        reach = width * np.cos(along) ** 0.45 * (1 + 0.13 * np.cos(ribs * angle) * np.cos(along))
        reach[-1] = 0.0
        points = np.stack([reach * np.cos(angle), reach * np.sin(angle), height * np.sin(along)], axis=-1)
        uvs = np.stack([angle, along], axis=-1).reshape(-1, 2)
        return smooth_normals(points.reshape(-1, 3), uvs, grid_faces(*angle.shape)[:, ::-1])

    parts = [column(wide, tall)]
    if rng.random() < 0.5 and tall > 0.14:
        for side in (-1, 1):
            low = tall * rng.uniform(0.35, 0.5)
            path = smooth_profile(
                [[0, 0, low], [side * wide * 1.7, 0, low + 0.004], [side * wide * 1.8, 0, low + 0.06]]
            )
            parts += [
                tube(path, wide * 0.38, 12, capped=False),
                blob((side * wide * 1.8, 0, low + 0.06), (wide * 0.38,) * 3, 12),
            ]
    bloom = merge(
        [transform(leaf(0.024, 0.012, 0.6, 4), (0, 0, tall - 0.003), (0, 0, 51.4 * index)) for index in range(7)]
    )
    return [
        (merge(parts), Material(green.colour, roughness=0.65)),
        (bloom, plastic(pick(rng, ("#e8588f", "#f2b32c", "#e8523f", "#f4efe4")), 0.6)),
    ]


def _rosette(rng: np.random.Generator, radius: float, green: Material) -> Pieces:
    """A succulent: thick pointed leaves in rings, steeper inwards; larger ones are aloes."""
    aloe = rng.random() < 0.5
    count, size = (18, 0.19) if aloe else (30, 0.1)
    leaves = []
    for index in range(count):
        share = index / (count - 1)
        blade = leaf(size * (1 - 0.45 * share), (0.024 if aloe else 0.034) * (1 - 0.3 * share), 0.9 - 0.75 * share, 5)
        leaves.append(transform(blade, (0, 0, 0.03 * share), (0.0, 0.0, 137.5 * index)))
    hue = pick(rng, ("#6f9a7a", "#8fae8a", "#7a9f5a", "#a87a8a", "#5a8a6a"))
    return [
        (merge(leaves), Material(from_hex(hue), roughness=0.45)),
        (blob((0, 0, 0.012), (0.03, 0.03, 0.016), 14), green),
    ]


def _bush(rng: np.random.Generator, radius: float, green: Material) -> Pieces:
    """A round bush of small leaves on branches, perhaps in flower."""
    high, leaves, branches, blooms = rng.uniform(0.11, 0.17), [], [], []
    for index in range(13):
        turn, lean = np.radians(137.5 * index), rng.uniform(0.02, 0.085)
        tip = np.array([lean * np.cos(turn), lean * np.sin(turn), high * rng.uniform(0.75, 1.1) - 4 * lean**2])
        branches.append(tube(np.stack([0 * tip, tip * [0.45, 0.45, 0.6], tip]), 0.002, 6))
        for share in (0.62, 0.85, 1.0):
            blade = leaf(rng.uniform(0.045, 0.065), 0.032, rng.uniform(0.5, 0.95), 4, 0.1)
            leaves.append(
                transform(blade, tuple(tip * [share, share, 0.25 + 0.75 * share]), (0, 0, rng.uniform(0, 360)))
            )
        blooms.append(blob((tip[0], tip[1], tip[2] + 0.012), (0.013, 0.013, 0.01), 8))
    pieces: Pieces = [(merge([*leaves, *branches]), green)]
    if rng.random() < 0.6:
        pieces.append((merge(blooms), plastic(pick(rng, PALETTE[:12]), 0.6)))
    return pieces
