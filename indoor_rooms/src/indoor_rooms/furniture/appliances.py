"""Stove, hood, fridge, microwave. Backs at y = 0, fronts towards -y, centred in x; metres."""

from __future__ import annotations

from indoor_rooms.geometry.boxes import box, rounded_box
from indoor_rooms.geometry.curves import cylinder, lathe, smooth_profile, tube
from indoor_rooms.geometry.mesh import Mesh, Vector, merge, transform
from indoor_rooms.geometry.pieces import Pieces
from indoor_rooms.materials import textures
from indoor_rooms.materials.material import Material, from_hex
from indoor_rooms.materials.surfaces import BLACK_GLASS, BLACK_PLASTIC, CHROME, plastic, printed, steel

STOVE_TOP = 0.912
BURNERS = ((-0.15, -0.17), (0.15, -0.17), (-0.15, -0.43), (0.15, -0.43))


def _at(mesh: Mesh, *place: float) -> Mesh:
    return transform(mesh, (place[0], place[1], place[2]))


def _grip(low: Vector, high: Vector, reach: float = 0.045, radius: float = 0.010) -> Mesh:
    """A bar handle between two points of a front, standing out by `reach`."""
    out = [(low[0], low[1] - reach, low[2]), (high[0], high[1] - reach, high[2])]
    return tube(smooth_profile([low, out[0], out[1], high], 2), radius, 10)


def stove(width: float = 0.62, depth: float = 0.60, towel: str | None = "#c2472f") -> Pieces:
    """A free-standing cooker with a black glass hob and an oven; `towel` is a checked tea towel's colour."""
    front = -depth
    body = box((-width / 2, front, 0.0), (width / 2, -0.004, 0.895))
    top = _at(rounded_box((width + 0.004, depth + 0.01, 0.016), 0.004), 0.0, -depth / 2 - 0.006, 0.904)
    rings = []
    for (x, y), radius in zip(BURNERS, (0.075, 0.095, 0.095, 0.075), strict=True):
        ring = lathe([(radius, 0.0), (radius, 0.0008), (radius - 0.006, 0.0008), (radius - 0.006, 0.0)], 40)
        rings.append(_at(ring, x, y, STOVE_TOP + 0.0002))
    door = _at(rounded_box((width - 0.02, 0.03, 0.50), 0.008, 2), 0.0, front - 0.0155, 0.44)
    window = _at(rounded_box((width - 0.14, 0.006, 0.28), 0.002), 0.0, front - 0.0325, 0.43)
    drawer = _at(rounded_box((width - 0.02, 0.03, 0.13), 0.008, 2), 0.0, front - 0.0155, 0.115)
    panel = _at(rounded_box((width - 0.004, 0.03, 0.16), 0.008, 2), 0.0, front - 0.0155, 0.805)
    display = _at(rounded_box((0.12, 0.004, 0.05), 0.001), 0.0, front - 0.0315, 0.815)
    knobs = []
    for x in (-0.25, -0.16, 0.16, 0.25):
        knob = merge([cylinder(0.022, 0.022, 24, 0.003), _at(rounded_box((0.008, 0.04, 0.01), 0.002), 0, 0, 0.025)])
        knobs.append(transform(knob, (x, front - 0.030, 0.81), (90.0, 0.0, 0.0)))
    bar_y, bar_z = front - 0.030, 0.645
    handle = _grip((-width / 2 + 0.06, bar_y, bar_z), (width / 2 - 0.06, bar_y, bar_z))
    pieces: Pieces = [
        (merge([body, door, drawer, panel]), steel()),
        (merge([top, window, display]), BLACK_GLASS),
        (merge(rings), plastic("#8a8d90", 0.4)),
        (merge(knobs), BLACK_PLASTIC),
        (handle, CHROME),
    ]
    if towel:
        cloth = printed(textures.gingham(towel), 0.95)
        back = _at(rounded_box((0.19, 0.005, 0.24), 0.002, 1, 4.0), 0.1, bar_y - 0.031, bar_z - 0.108)
        face = _at(rounded_box((0.19, 0.006, 0.32), 0.002, 1, 4.0), 0.1, bar_y - 0.060, bar_z - 0.148)
        fold = transform(cylinder(0.0165, 0.19, 20, 0.001), (0.005, bar_y - 0.0455, bar_z + 0.001), (0.0, 90.0, 0.0))
        pieces.append((merge([back, face, fold]), cloth))
    return pieces


def hood(width: float = 0.62, height: float = 0.95) -> Pieces:
    """An extractor hood, its underside at z = 0, with a chimney `height` high in all."""
    canopy = _at(rounded_box((width, 0.48, 0.07), 0.008), 0.0, -0.242, 0.035)
    slope = _at(rounded_box((width * 0.62, 0.34, 0.07), 0.02, 2), 0.0, -0.172, 0.10)
    chimney = box((-0.13, -0.25, 0.13), (0.13, -0.002, height))
    grease_filter = _at(rounded_box((width - 0.08, 0.38, 0.006), 0.002), 0.0, -0.24, -0.001)
    buttons = _at(rounded_box((0.14, 0.004, 0.018), 0.001), 0.0, -0.4825, 0.035)
    return [(merge([canopy, slope, chimney]), steel()), (merge([grease_filter, buttons]), BLACK_PLASTIC)]


def fridge(colour: str | None = None, width: float = 0.68, depth: float = 0.66, height: float = 1.82) -> Pieces:
    """A fridge with a freezer below; steel, or enamelled in a colour."""
    shell = steel() if colour is None else Material(from_hex(colour), roughness=0.2, coat=0.4)
    door = 0.055
    body = _at(
        rounded_box((width, depth - door, height - 0.03), 0.012), 0.0, -(depth - door) / 2 - 0.002, height / 2 + 0.015
    )
    foot = box((-width / 2 + 0.02, -depth + 0.09, 0.0), (width / 2 - 0.02, -0.03, 0.029))
    split, y = 0.68, -depth + door / 2 - 0.004
    upper = _at(
        rounded_box((width - 0.004, door, height - split - 0.006), 0.016, 2), 0.0, y, (height + split) / 2 + 0.001
    )
    lower = _at(rounded_box((width - 0.004, door, split - 0.045), 0.016, 2), 0.0, y, (split + 0.036) / 2)
    front, x = -depth - 0.002, width / 2 - 0.07
    handles = merge(
        [
            _grip((x, front, 0.86), (x, front, 1.34), 0.045, 0.011),
            _grip((x, front, 0.34), (x, front, 0.60), 0.045, 0.011),
        ]
    )
    return [(merge([body, upper, lower]), shell), (foot, BLACK_PLASTIC), (handles, CHROME)]


def microwave(width: float = 0.48, depth: float = 0.34, height: float = 0.28) -> Pieces:
    """A microwave oven on four feet."""
    body = _at(rounded_box((width, depth, height - 0.014), 0.010, 2), 0.0, -depth / 2, 0.014 + (height - 0.014) / 2)
    window = _at(
        rounded_box((width * 0.64, 0.010, height * 0.72), 0.003), -width * 0.13, -depth - 0.003, height * 0.53
    )
    panel = _at(rounded_box((width * 0.20, 0.008, height * 0.80), 0.003), width * 0.36, -depth - 0.002, height * 0.53)
    display = _at(rounded_box((width * 0.15, 0.004, 0.03), 0.001), width * 0.36, -depth - 0.0065, height * 0.82)
    dial = transform(cylinder(0.026, 0.014, 28), (width * 0.36, -depth - 0.0055, height * 0.32), (90.0, 0.0, 0.0))
    x = width * 0.225
    handle = _grip((x, -depth - 0.001, height * 0.22), (x, -depth - 0.001, height * 0.84), 0.034, 0.008)
    feet = [
        _at(cylinder(0.014, 0.016, 14), sx * width * 0.4, -depth / 2 + sy * depth * 0.36, 0)
        for sx in (-1, 1)
        for sy in (-1, 1)
    ]
    return [
        (body, steel()),
        (merge([window, panel]), BLACK_GLASS),
        (display, Material(from_hex("#8fd8c0"), roughness=0.3)),
        (merge([dial, handle]), CHROME),
        (merge(feet), BLACK_PLASTIC),
    ]
