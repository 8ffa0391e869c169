"""Standing clocks of several kinds."""

from __future__ import annotations

import numpy as np

from indoor_rooms.geometry.boxes import rounded_box
from indoor_rooms.geometry.curves import cylinder, disc, lathe, smooth_profile, tube
from indoor_rooms.geometry.mesh import Mesh, merge, quad, transform
from indoor_rooms.geometry.pieces import Pieces, standing
from indoor_rooms.materials import prints_devices
from indoor_rooms.materials.surfaces import beech, metallic, plastic, printed, steel, wood
from indoor_rooms.objects.shaping import PALETTE, facing, pick, prism, rounded_rectangle


def _hands(size: float, hour: float) -> Mesh:
    """Hands of a clock about the origin, lying, its twelve towards +y; the hour as a number of hours."""
    hands = []
    for reach, width, angle, z in ((0.5, 0.07, 30 * hour, 0.0), (0.78, 0.05, 360 * (hour % 1), 0.0012)):
        hand = transform(rounded_box((width * size, reach * size, 0.001), 0.0003), (0.0, reach * size * 0.42, 0.0))
        hands.append(transform(hand, (0.0, 0.0, z), (0.0, 0.0, -angle)))
    return merge([*hands, cylinder(0.05 * size, 0.0028, 14, 0.0)])


def clock(rng: np.random.Generator) -> Pieces:
    """A clock standing, its face towards -y: an alarm clock with bells, a mantel clock, a round one or digits."""
    family = int(rng.integers(4))
    colour = pick(rng, PALETTE)
    if family == 3:
        return _digital_clock(rng, colour)
    style = pick(rng, ("numbers", "quarters", "roman", "strokes"))
    ground, ink = (("#f6f3ea", "#202226"), ("#26282d", "#f0ece0"), ("#efe0b8", "#4a2f1c"), (colour, "#fbfbf8"))[
        int(rng.integers(4))
    ]
    if ground == colour and sum(int(colour[i : i + 2], 16) for i in (1, 3, 5)) > 430:
        ground, ink = "#fbfbf8", "#26282d"
    size = rng.uniform(0.045, 0.065) if family == 0 else rng.uniform(0.06, 0.085)
    depth = size * rng.uniform(0.7, 1.0) if family != 2 else size * 0.45
    rim = [
        (size * 0.93, -0.001),
        (size * 0.95, 0.003),
        (size * 1.03, 0.004),
        (size * 1.05, 0.0),
        (size * 1.05, -0.006),
    ]
    face = [
        (facing(disc(size, 0.0005, 44)), printed(prints_devices.dial(style, ground, ink), 0.25)),
        (facing(transform(_hands(size, rng.uniform(0, 12)), (0.0, 0.0, 0.0012))), plastic(ink)),
    ]
    metal = metallic(pick(rng, ("#c9ccd0", "#d8b45a", "#b5763a")), 0.2)
    ring = (facing(lathe(rim[::-1], 44)), metal)
    pieces: Pieces = [*face, ring]
    if family == 0:
        drum = facing(cylinder(size * 1.04, depth, 40, 0.004), depth - 0.0002)
        legs = [
            tube([[x * size * 0.5, depth / 2, -size * 0.85], [x * size * 0.75, depth / 2, -size * 1.3]], 0.005, 10)
            for x in (-1, 1)
        ]
        bell = [
            (0.0, 0.0),
            (size * 0.42, 0.0),
            (size * 0.4, size * 0.14),
            (size * 0.2, size * 0.26),
            (0.0, size * 0.29),
        ]
        bells = [
            transform(
                lathe(smooth_profile(bell, 1), 24), (x * size * 0.62, depth / 2, size * 0.96), (0.0, x * 32.0, 0.0)
            )
            for x in (-1, 1)
        ]
        posts = [
            tube([[x * size * 0.5, depth / 2, size * 0.8], [x * size * 0.7, depth / 2, size * 1.08]], 0.003, 8)
            for x in (-1, 1)
        ]
        hammer = tube([[0, depth / 2, size * 0.98], [0, depth / 2, size * 1.3]], [0.002, 0.002, 0.005], 8)
        pieces += [(drum, plastic(colour, 0.25)), (merge([*legs, *bells, *posts, hammer]), metal)]
    elif family == 1:
        w, low = size * rng.uniform(1.3, 1.6), -size * 1.35
        bow = [
            (w * np.cos(a) * 0.86, size * 0.1 + size * 1.15 * np.sin(a)) for a in np.radians(np.linspace(0, 180, 15))
        ]
        outline = (
            [(-w * 0.86, low), (w * 0.86, low), *bow]
            if rng.random() < 0.6
            else rounded_rectangle(2 * w * 0.9, 2.6 * size, 0.008)
        )
        case = facing(prism(outline, depth, 0.003, 3.0), depth - 0.0002)
        plinth = transform(rounded_box((w * 2.1, depth * 1.3, 0.016), 0.004, 1, 3.0), (0.0, depth / 2, low))
        timber = (
            wood("#4a2a18", "#7a4a2a", int(rng.integers(3))) if rng.random() < 0.6 else wood("#8a5a30", "#c08a50", 2)
        )
        pieces.append((merge([case, plinth]), timber))
    else:
        drum = facing(cylinder(size * 1.05, depth, 44, 0.004), depth - 0.0002)
        wings = [
            transform(
                rounded_box((size * 0.16, depth * 1.6, size * 0.5), 0.004), (x * size * 0.62, depth / 2, -size * 0.95)
            )
            for x in (-1, 1)
        ]
        pieces += [(drum, plastic(colour, 0.3)), (merge(wings), beech() if rng.random() < 0.5 else metal)]
    return standing(pieces)


def _digital_clock(rng: np.random.Generator, colour: str) -> Pieces:
    width, height, depth = rng.uniform(0.13, 0.19), rng.uniform(0.06, 0.085), rng.uniform(0.05, 0.075)
    text = f"{int(rng.integers(0, 24)):02d}:{int(rng.integers(0, 60)):02d}"
    ink, ground = (("#ff4434", "#1a0f10"), ("#5fe07a", "#0f1812"), ("#7fd0ff", "#10161c"), ("#23281f", "#b9c9ae"))[
        int(rng.integers(4))
    ]
    side = [(-depth / 2, 0.0), (depth / 2, 0.0), (depth / 2, height), (-depth * 0.36, height)]
    lean = np.degrees(np.arctan2(depth * 0.14, height))
    body = transform(prism(side, width, 0.004, 3.0), (-width / 2, 0.0, 0.0), (90.0, 0.0, 90.0))
    panel = transform(
        quad((-width * 0.44, -0.0008, height * 0.14), (width * 0.88, 0, 0), (0, 0, height * 0.74)),
        (0, -depth / 2, 0),
        (-lean, 0, 0),
    )
    bar = transform(rounded_box((width * 0.4, depth * 0.3, 0.008), 0.003), (0.0, depth * 0.1, height + 0.001))
    look = wood("#8a5a30", "#c08a50", 2) if rng.random() < 0.4 else plastic(colour, 0.35)
    return [(body, look), (panel, printed(prints_devices.digits(text, ink, ground), 0.12)), (bar, steel())]
