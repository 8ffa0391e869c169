"""What hangs at windows and stands in corners: curtains, blinds, radiator, floor lamp.

Things at a wall have their back at y = 0 and face -y; metres.
"""

from __future__ import annotations

from typing import Literal

import numpy as np

from indoor_rooms.furniture.building import CLOTH_REPEATS, at, check_range
from indoor_rooms.furniture.fixtures import WALL_THICKNESS, Opening
from indoor_rooms.geometry.boxes import rounded_box
from indoor_rooms.geometry.curves import cylinder, lathe, smooth_profile, sphere, tube
from indoor_rooms.geometry.mesh import Mesh, Vector, grid_faces, merge, quad, smooth_normals, transform
from indoor_rooms.geometry.pieces import Pieces
from indoor_rooms.materials.material import Colour, Material, from_hex
from indoor_rooms.materials.surfaces import BLACK_PLASTIC, BRASS, WHITE_PAINT, cloth, plastic, wood

# A drawn-aside curtain covers this share of a window's width on either side.
CURTAIN_COVER = 0.14
# Curtains hang this far in front of the wall, clear of the window's sill, and swing so far to and fro.
CURTAIN_DISTANCE = 0.15
_SWING = 0.032
RADIATOR_DEPTH = 0.105
_PLEAT = 0.075


def _check_opening(opening: Opening) -> None:
    x0, x1, z0, z1 = opening
    if not (x0 < x1 and 0 <= z0 < z1):
        raise ValueError(f"an opening is (x from, x to, z from, z to) with rising values, got {opening}")


def _pleated(low_x: float, high_x: float, low_z: float, high_z: float, phase: float) -> Mesh:
    """A hanging cloth in waves about y = 0, two sheets back to back."""
    pleats = max(3, round((high_x - low_x) / _PLEAT))
    across, down = 8 * pleats + 1, 9
    u, v = np.meshgrid(np.linspace(0, 1, across), np.linspace(0, 1, down), indexing="ij")
    # Pinched at the rod, wider and drifting a little below: no two pleats fall alike.
    drift = 0.35 * np.sin(5.1 * u * pleats / 4 + phase) * (1 - v)
    swing = _SWING * (0.62 + 0.38 * (1 - v)) * (0.85 + 0.15 * np.sin(2.3 * pleats * u + phase))
    y = swing * np.sin(2 * np.pi * pleats * u + drift + phase)
    x = low_x + (high_x - low_x) * u
    z = low_z + (high_z - low_z) * v
    sheets = []
    length = u * (high_x - low_x) * 2.0
    uvs = CLOTH_REPEATS * 0.6 * np.stack([length, z], axis=-1).reshape(-1, 2)
    for side in (-1, 1):
        vertices = np.stack([x, y + side * 0.0012, z], axis=-1).reshape(-1, 3)
        faces = grid_faces(across, down)
        sheets.append(smooth_normals(vertices, uvs, faces if side < 0 else faces[:, ::-1]))
    return merge(sheets)


def curtains(opening: Opening, fabric: Material, rod: Material, drop: Literal["floor", "sill"] = "floor") -> Pieces:
    """Two pleated curtains drawn aside, left and right of a window, on a rod above it.

    Args:
        opening: of the window in the wall, as for `fixtures.window`.
        fabric: of the curtains.
        rod: of the rod, its knobs, rings and brackets.
        drop: whether they reach down to the floor or to just below the sill.

    Raises:
        ValueError: if the opening is not one, or `drop` is not known.
    """
    _check_opening(opening)
    if drop not in ("floor", "sill"):
        raise ValueError(f"curtains drop to the floor or to the sill, not to '{drop}'")
    x0, x1, z0, z1 = opening
    width = x1 - x0
    rod_z, low = z1 + 0.13, 0.015 if drop == "floor" else max(0.015, z0 - 0.14)
    inside, outside = CURTAIN_COVER * width, max(0.16, 0.10 * width)
    y = -CURTAIN_DISTANCE
    panels = []
    for phase, (left, right) in enumerate(((x0 - outside, x0 + inside), (x1 - inside, x1 + outside))):
        panels.append(at(_pleated(left, right, low, rod_z - 0.022, 1.0 + 2.0 * phase), 0.0, y))
    half = width / 2 + outside + 0.06
    middle = (x0 + x1) / 2
    bar = transform(cylinder(0.011, 2 * half, 16, 0.001), (middle - half, y, rod_z), (0.0, 90.0, 0.0))
    hardware = [bar]
    for side in (-1, 1):
        end = middle + side * half
        hardware.append(at(sphere(0.022, 16), end, y, rod_z - 0.022))
        x = end - side * 0.05
        path = [[x, -0.004, rod_z - 0.02], [x, y * 0.7, rod_z - 0.02], [x, y, rod_z - 0.013]]
        hardware.append(tube(path, 0.006, 8))
        hardware.append(transform(cylinder(0.02, 0.008, 18), (x, -0.001, rod_z - 0.02), (90.0, 0.0, 0.0)))
    for left, right in ((x0 - outside, x0 + inside), (x1 - inside, x1 + outside)):
        for x in np.linspace(left + 0.02, right - 0.02, max(3, round((right - left) / _PLEAT))):
            ring = [(0.0155, -0.004), (0.019, -0.004), (0.019, 0.004), (0.0155, 0.004), (0.0155, -0.004)]
            hardware.append(transform(lathe(ring, 14), (float(x), y, rod_z - 0.005), (0.0, 90.0, 0.0)))
    return [(merge(panels), fabric), (merge(hardware), rod)]


def blinds(opening: Opening, colour: str, share: float = 0.35) -> Pieces:
    """A venetian blind in a window's opening, its slats gathered in the upper part.

    Args:
        opening: of the window in the wall, as for `fixtures.window`.
        colour: of the slats, hex.
        share: of the window's height it covers.

    Raises:
        ValueError: if the opening is not one, or the share is not within 0.1 to 1.
    """
    _check_opening(opening)
    check_range("the share of the window a blind covers", share, 0.1, 1.0)
    x0, x1, _, z1 = opening
    width, middle, y = x1 - x0 - 0.016, (x0 + x1) / 2, WALL_THICKNESS * 0.27
    covered = share * (opening[3] - opening[2])
    head = at(rounded_box((width, 0.05, 0.04), 0.004), middle, y, z1 - 0.0215)
    foot = at(rounded_box((width, 0.03, 0.018), 0.004), middle, y, z1 - covered + 0.01)
    pitch = 0.028
    slats = []
    for z in np.arange(z1 - 0.058, z1 - covered + 0.03, -pitch):
        slat = rounded_box((width, 0.034, 0.002), 0.0008)
        slats.append(transform(slat, (middle, y, float(z)), (32.0, 0.0, 0.0)))
    cords = [
        tube([[x, y - 0.0185, z1 - 0.04], [x, y - 0.0185, z1 - covered + 0.01]], 0.0012, 6)
        for x in (x0 + 0.15 * width, x1 - 0.15 * width)
    ]
    pull = tube([[x1 - 0.05, y - 0.028, z1 - 0.04], [x1 - 0.05, y - 0.028, z1 - covered - 0.18]], 0.0015, 6)
    return [(merge([head, foot, *slats]), plastic(colour, 0.45)), (merge([*cords, pull]), WHITE_PAINT)]


def radiator(width: float, height: float = 0.55) -> Pieces:
    """A panel radiator for the wall under a window, with its valve, standing on two thin feet.

    Args:
        width: metres.
        height: from the floor to its top, metres.

    Raises:
        ValueError: if a size is out of range.
    """
    check_range("a radiator's width in metres", width, 0.4, 2.4)
    check_range("a radiator's height in metres", height, 0.3, 1.2)
    low, front = 0.11, -RADIATOR_DEPTH
    flutes = max(4, round(width / 0.07))
    across = 6 * flutes + 1
    x = np.linspace(-width / 2 + 0.01, width / 2 - 0.01, across)
    wave = np.clip(1.6 * np.cos(2 * np.pi * np.linspace(0, flutes, across)), -1, 1)
    y = front + 0.004 + 0.0035 * wave
    rows = np.array([low + 0.012, height - 0.014])
    vertices = np.stack([np.repeat(x, 2), np.repeat(y, 2), np.tile(rows, across)], axis=1)
    sheet = smooth_normals(vertices, vertices[:, [0, 2]], grid_faces(across, 2))
    core = at(
        rounded_box((width - 0.004, 0.068, height - low - 0.016), 0.006), 0.0, front + 0.0425, (height + low) / 2
    )
    grille = at(rounded_box((width, 0.084, 0.012), 0.003), 0.0, front + 0.044, height - 0.006)
    slots = [
        quad((float(sx) - 0.003, front + 0.0165, height + 0.0004), (0.006, 0, 0), (0, 0.055, 0))
        for sx in np.arange(-width / 2 + 0.03, width / 2 - 0.029, 0.024)
    ]
    feet = [
        at(rounded_box((0.022, 0.03, low + 0.02), 0.004, 1, 1.0, base=True), side * width * 0.38, -0.055)
        for side in (-1, 1)
    ]
    pipe_x = width / 2 + 0.035
    pipe = [[width / 2 - 0.01, -0.06, low + 0.05], [pipe_x, -0.06, low + 0.05], [pipe_x, -0.06, 0.0]]
    valve = transform(cylinder(0.017, 0.06, 18, 0.004), (pipe_x - 0.005, -0.06, low + 0.05), (0.0, 90.0, 0.0))
    white = merge([sheet, core, grille, *feet, tube(smooth_profile(pipe, 2), 0.008, 10), valve])
    return [(white, WHITE_PAINT), (merge(slots), BLACK_PLASTIC)]


def floor_lamp(rng: np.random.Generator, glow: Colour) -> tuple[Pieces, Pieces, Vector, float]:
    """A standing lamp with a drum shade, on a round foot or a wooden tripod.

    Args:
        rng: kind, height, shade.
        glow: radiance of its bulb, linear RGB.

    Returns:
        Its fixed pieces, its glowing bulb, the bulb's centre (metres, relative to the lamp's origin) and radius.
    """
    height, tripod = rng.uniform(1.42, 1.62), rng.random() < 0.5
    colour = ("#efe6d2", "#f4f1ea", "#d9c7a8", "#6f7f86", "#c9713f")[int(rng.integers(5))]
    low, high, tall = rng.uniform(0.19, 0.23), rng.uniform(0.14, 0.19), rng.uniform(0.22, 0.28)
    top = height
    bottom = top - tall
    outside = lathe([(low, bottom), (high, top)], 44)
    inside = lathe([(high - 0.003, top), (low - 0.003, bottom)], 44)
    rims = [
        lathe([(r, z), (r + 0.002, z), (r + 0.002, z + 0.006), (r, z + 0.006)], 44)
        for r, z in ((low - 0.001, bottom - 0.002), (high - 0.001, top - 0.004))
    ]
    metal = BRASS if rng.random() < 0.5 else BLACK_PLASTIC
    neck = bottom + 0.03
    stand: list[Mesh] = [at(cylinder(0.018, 0.05, 18), z=neck - 0.01)]
    for angle in np.radians([90.0, 210.0, 330.0]):
        reach = high + (low - high) * 0.3 - 0.004
        c, s = float(np.cos(angle)), float(np.sin(angle))
        stand.append(tube([[0.0, 0.0, top - tall * 0.3], [reach * c, reach * s, top - tall * 0.3]], 0.002, 6))
    stand.append(tube([[0.0, 0.0, neck + 0.03], [0.0, 0.0, neck + 0.055]], 0.011, 10))
    timber: list[Mesh] = []
    if tripod:
        hub = bottom - 0.05
        stand.append(at(cylinder(0.034, 0.03, 24), z=hub))
        stand.append(at(cylinder(0.009, neck - hub, 12), z=hub + 0.01))
        for angle in np.radians([90.0, 210.0, 330.0]):
            c, s = float(np.cos(angle)), float(np.sin(angle))
            leg = tube([[0.27 * c, 0.27 * s, 0.0], [0.02 * c, 0.02 * s, hub + 0.015]], [0.010, 0.014], 12)
            timber.append(at(leg, z=-float(leg.vertices[:, 2].min())))
    else:
        stand.append(
            lathe(smooth_profile([(0.0, 0.0), (0.15, 0.0), (0.15, 0.015), (0.02, 0.026), (0.012, 0.05)], 1), 44)
        )
        stand.append(at(cylinder(0.011, neck - 0.03, 14, 0.001), z=0.035))
    radius = 0.036
    centre = (0.0, 0.0, neck + 0.055 + radius)
    bulb = at(sphere(radius, 20), 0.0, 0.0, centre[2] - radius)
    fixed: Pieces = [
        (merge([outside, *rims]), cloth(colour)),
        (inside, Material(from_hex("#f6f1e6"), roughness=0.9)),
        (merge(stand), metal),
    ]
    if timber:
        fixed.append((merge(timber), wood("#8a5f3a", "#bb8d5c", 3)))
    return fixed, [(bulb, Material(glow, emission=1.0))], centre, radius
