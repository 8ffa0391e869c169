"""Devices with keys and screens: remote control, phone, laptop, calculator, game controller."""

from __future__ import annotations

import numpy as np

from indoor_rooms.geometry.boxes import rounded_box
from indoor_rooms.geometry.curves import cylinder, lathe, tube
from indoor_rooms.geometry.mesh import Mesh, merge, quad, transform, without_sides
from indoor_rooms.geometry.pieces import Pieces, placed
from indoor_rooms.materials import prints_devices
from indoor_rooms.materials.surfaces import BLACK_GLASS, BLACK_PLASTIC, display, metallic, plastic, printed
from indoor_rooms.objects.shaping import (
    GADGET_COLOURS,
    bulge,
    cap,
    closed_curve,
    facing,
    keypad,
    mirrored,
    pick,
    prism,
    rounded_rectangle,
    two_colours,
)

PLAY_COLOURS = ("#26272a", "#f2f2ef", "#c22f2a", "#2f5fa8", "#3f8a4c", "#7a4f96", "#e0a02c")


def remote_control(rng: np.random.Generator) -> Pieces:
    """A television's remote control lying on its back, its top end towards +y."""
    slim = rng.random() < 0.35
    width, length, height = (
        (0.036, rng.uniform(0.13, 0.15), 0.011)
        if slim
        else (rng.uniform(0.044, 0.054), rng.uniform(0.16, 0.21), rng.uniform(0.018, 0.024))
    )
    shell = pick(rng, ("#232427", "#303338", "#8f9499", "#ececea", "#3a3f4c"))
    light = shell in ("#ececea", "#8f9499")
    key, ink = ("#3a3d42", "#f4f4f4") if light else ("#c9ccd0", "#202226")
    accent = pick(rng, ("#d8342c", "#3f8fe0", "#e89a2c", "#4fb35a"))
    body = prism(rounded_rectangle(width, length, 0.3 * width if rng.random() < 0.6 else 0.006), height, 0.003)
    rows = 4 if slim else int(rng.integers(6, 9))
    pitch = (width * 0.27, (0.36 if slim else 0.56) * length / rows)
    names = [tuple(str(3 * row + column + 1) for column in range(3)) for row in range(3)]
    names += [("", "0", "")] + [("", "", "")] * 8
    fills = [(key, key, key)] * rows
    fills[-1] = ("#c8372d", "#3f8a4c", "#e0b02c") if not slim else (key, accent, key)
    keys = keypad(3, rows, pitch, rng.uniform(0.66, 0.8), 0.0022, bool(rng.random() < 0.5))
    pad = prints_devices.key_grid(tuple(names[:rows]), tuple(fills), ink)
    ring_at = length * (0.22 if slim else 0.25)
    ring = lathe([(width * 0.17, 0.0), (width * 0.36, 0.0), (width * 0.36, 0.002), (width * 0.17, 0.002)], 28)
    button = cylinder(width * 0.13, 0.003, 16, 0.0008)
    power = cylinder(0.0045, 0.0022, 14, 0.0006)
    return [
        (body, plastic(shell, rng.uniform(0.25, 0.5))),
        (transform(keys, (0.0, -length / 2 + pitch[1] * (rows + 0.4) / 2 + 0.006, height - 0.0002)), printed(pad)),
        (transform(without_sides(ring, "-z"), (0.0, ring_at, height)), plastic(key, 0.3)),
        (transform(button, (0.0, ring_at, height - 0.0006)), plastic(key if slim else accent, 0.3)),
        (transform(power, (-width * 0.28, length / 2 - 0.012, height - 0.0006)), plastic(accent)),
    ]


def phone(rng: np.random.Generator) -> Pieces:
    """A smartphone lying on its back, its screen up, its top towards +y."""
    width, length, height = rng.uniform(0.068, 0.078), rng.uniform(0.142, 0.162), 0.0085
    colour = pick(rng, ("#26272a", "#e9e6df", "#2d4a78", "#9c2f33", "#7a8f78", "#c9b3d0", "#d8b48a"))
    corner = rng.uniform(0.007, 0.012)
    rim = rng.uniform(0.0022, 0.006)
    body = prism(rounded_rectangle(width, length, corner), height, 0.0022)
    glass = cap(rounded_rectangle(width - 0.003, length - 0.003, corner - 0.001), height + 0.0004)
    tall = length - 2 * rim - (0.012 if rng.random() < 0.3 else 0.0)
    screen = cap(rounded_rectangle(width - 2 * rim, tall, corner - 0.003), height + 0.0009)
    key = transform(rounded_box((0.0012, 0.012, 0.003), 0.0005), (width / 2 + 0.0003, length * 0.18, height / 2))
    case = rng.random() < 0.35
    skin = plastic(colour, 0.6) if case else metallic(colour)
    return [
        (merge([body, key]), skin),
        (glass, BLACK_GLASS),
        (screen, display(prints_devices.phone_screen(int(rng.integers(10))))),
    ]


def laptop(rng: np.random.Generator) -> Pieces:
    """An open laptop, its screen towards -y, leaning back."""
    width = rng.uniform(0.30, 0.36)
    depth, base = width * rng.uniform(0.66, 0.7), rng.uniform(0.012, 0.018)
    colour = pick(rng, ("#c5c8cc", "#c5c8cc", "#5a5e66", "#2b2c30", "#e4cfc0", "#33507a", "#f0efec"))
    dark = colour in ("#2b2c30", "#5a5e66", "#33507a")
    key, ink = ("#1f2023", "#e8e8e8") if dark or rng.random() < 0.6 else ("#f4f4f2", "#55585c")
    shell = metallic(colour, 0.35) if rng.random() < 0.6 else plastic(colour)
    foot = prism(rounded_rectangle(width, depth, 0.012), base, 0.003)
    pitch = width * 0.9 / 13
    letters = ("1234567890-=<", "QWERTYUIOP[]+", "ASDFGHJKL;'#^", "ZXCVBNM,./   ")
    keys = keypad(13, 4, (pitch, pitch), 0.86, 0.0016, round_=False)
    pad = prints_devices.key_grid(tuple(tuple(row) for row in letters), ((key,) * 13,) * 4, ink)
    space = transform(rounded_box((width * 0.34, 0.014, 0.003), 0.0008), (0.0, -0.021, base))
    touch = quad((-0.05, -depth / 2 + 0.014, base + 0.0006), (0.1, 0, 0), (0, 0.058, 0))
    lid_depth, thick = depth * 0.97, 0.007
    lid = facing(prism(rounded_rectangle(width, lid_depth, 0.01), thick, 0.002), thick, lid_depth / 2)
    bezel = quad((-width / 2 + 0.005, -0.0005, 0.006), (width - 0.01, 0, 0), (0, 0, lid_depth - 0.011))
    screen = quad((-width / 2 + 0.012, -0.001, 0.017), (width - 0.024, 0, 0), (0, 0, lid_depth - 0.028))
    hinge = transform(cylinder(0.006, width * 0.72, 16), (-width * 0.36, depth / 2 - 0.004, base), (0.0, 90.0, 0.0))
    picture = display(prints_devices.laptop_screen(int(rng.integers(12))))
    opened: Pieces = [(lid, shell), (bezel, BLACK_GLASS), (screen, picture)]
    lean = -rng.uniform(12.0, 28.0)
    opened = [
        (transform(mesh, (0.0, depth / 2 - 0.008, base - 0.001), (lean, 0.0, 0.0)), material)
        for mesh, material in opened
    ]
    return [
        (foot, shell),
        (transform(keys, (0.0, depth * 0.16, base - 0.0002)), printed(pad)),
        (space, plastic(key)),
        (touch, plastic("#3a3b3f" if dark else "#b5b8bc", 0.3)),
        (hinge, BLACK_PLASTIC),
        *opened,
    ]


def calculator(rng: np.random.Generator) -> Pieces:
    """A pocket calculator lying on its back, its display at the +y end, which is the thicker one."""
    width, length = rng.uniform(0.075, 0.11), rng.uniform(0.13, 0.17)
    front, back = 0.009, rng.uniform(0.014, 0.024)
    shell = pick(rng, ("#26272a", "#e8e6e0", "#3f5f8a", "#d87a8f", "#9fc8b0", "#8f9499"))
    light = shell in ("#e8e6e0", "#9fc8b0", "#d87a8f", "#8f9499")
    key, ink = ("#2d2f33", "#fafafa") if light else ("#e8e8e6", "#1c1d20")
    accent = pick(rng, ("#d8542c", "#2f6fb0", "#7a7f86", "#c8302c"))
    side = np.array([[-length / 2, 0.0], [length / 2, 0.0], [length / 2, back], [-length / 2, front]])
    body = transform(prism(side, width, 0.003), (-width / 2, 0.0, 0.0), (90.0, 0.0, 90.0))
    names = (
        ("7", "8", "9", "/", "C"),
        ("4", "5", "6", "x", "%"),
        ("1", "2", "3", "-", "M"),
        ("0", ".", "+", "+", "="),
    )
    columns = 5 if rng.random() < 0.5 else 4
    fills = tuple((key,) * 3 + ((accent,) if row < 3 else (key,)) + (accent,) for row in range(4))
    pitch = (width * 0.9 / columns, length * 0.56 / 4)
    keys = keypad(columns, 4, pitch, 0.78, 0.003, bool(rng.random() < 0.25))
    pad = prints_devices.key_grid(tuple(row[:columns] for row in names), tuple(row[:columns] for row in fills), ink)
    window = rounded_box((width * 0.88, length * 0.24, 0.003), 0.001)
    number = f"{int(rng.integers(10, 99999))}".rjust(8)
    text = quad((-width * 0.4, -length * 0.075, 0.0020), (width * 0.8, 0, 0), (0, length * 0.15, 0))
    slope = np.degrees(np.arctan2(back - front, length))

    def laid(mesh: Mesh, y: float) -> Mesh:
        """Put on the slanting top, `y` metres from its middle."""
        return transform(mesh, (0.0, y, (front + back) / 2 + y * (back - front) / length), (slope, 0.0, 0.0))

    return [
        (body, plastic(shell)),
        (laid(keys, -length * 0.18), printed(pad, 0.4)),
        (laid(window, length * 0.32), BLACK_PLASTIC),
        (laid(text, length * 0.32), display(prints_devices.digits(number, "#20281f", "#aebfa4"))),
    ]


_PAD = (
    (0.0, -0.010),
    (0.030, -0.014),
    (0.045, -0.031),
    (0.068, -0.058),
    (0.083, -0.050),
    (0.084, -0.015),
    (0.074, 0.034),
    (0.055, 0.047),
    (0.030, 0.044),
    (0.0, 0.042),
)


def game_controller(rng: np.random.Generator) -> Pieces:
    """A controller with two grips lying on its back, grips towards -y."""
    shell, other = two_colours(rng, PLAY_COLOURS)
    high, size = 0.021, rng.uniform(0.92, 1.06)
    body = bulge(closed_curve(mirrored(_PAD)), high, 0.017, 0.42, 6, (0.0, 0.03))
    top = high + 0.017
    stick = [(0.006, 0.0), (0.0045, 0.006), (0.0085, 0.008), (0.0085, 0.011), (0.006, 0.0105), (0.0, 0.009)]
    offset = rng.random() < 0.5
    left = (-0.05, 0.024) if offset else (-0.022, 0.0)
    cross = (-0.024, -0.002) if offset else (-0.05, 0.022)
    sticks = merge([transform(lathe(stick, 20), (x, y, top - 0.004)) for x, y in (left, (0.022, 0.0))])
    arms = merge(
        [
            transform(rounded_box(arm, 0.0015), (*cross, top - 0.0015))
            for arm in ((0.023, 0.008, 0.007), (0.008, 0.023, 0.0069))
        ]
    )
    pieces: Pieces = [(body, plastic(shell, 0.45)), (merge([sticks, arms]), plastic(other, 0.5))]
    colours = ("#3f8fe0", "#e0453c", "#e8b52e", "#4fb35a") if rng.random() < 0.6 else ("#d8d8d6",) * 4
    for colour, (x, y) in zip(colours, ((-1, 0), (1, 0), (0, 1), (0, -1)), strict=True):
        button = transform(cylinder(0.005, 0.006, 14, 0.001), (0.05 + 0.0115 * x, 0.022 + 0.0115 * y, top - 0.004))
        pieces.append((button, plastic(colour, 0.2)))
    shoulders = [
        tube([[side * 0.034, 0.043, 0.021], [side * 0.056, 0.0445, 0.020], [side * 0.068, 0.036, 0.018]], 0.0065, 10)
        for side in (-1, 1)
    ]
    pieces.append((merge(shoulders), plastic(other, 0.5)))
    if rng.random() < 0.5:
        pad = prism(rounded_rectangle(0.034, 0.018, 0.003), 0.006, 0.001)
        pieces.append((transform(pad, (0.0, 0.026, top - 0.0045)), plastic(pick(rng, GADGET_COLOURS), 0.3)))
    return placed(pieces, scale=size)
