"""What belongs to the walls, the ceiling and the floor's corners: window, door, lamps, picture, clock, bin.

Things on a wall have their back at y = 0 and face -y, centred in x; metres.
"""

from __future__ import annotations

from indoor_rooms.geometry.boxes import box, rounded_box, slab
from indoor_rooms.geometry.curves import cylinder, disc, lathe, smooth_profile, sphere, tube
from indoor_rooms.geometry.mesh import Mesh, merge, quad, transform, with_uvs, without_sides
from indoor_rooms.geometry.pieces import Pieces
from indoor_rooms.materials import prints
from indoor_rooms.materials.material import Colour, Material
from indoor_rooms.materials.surfaces import BLACK_PLASTIC, BRASS, WHITE_PAINT, printed, steel

WALL_THICKNESS = 0.14
Opening = tuple[float, float, float, float]


def wall(width: float, height: float, opening: Opening | None = None) -> Mesh:
    """A wall with an optional opening (x from, x to, z from, z to); thickness lies behind y = 0."""
    xs, zs = [-width / 2, width / 2], [0.0, height]
    filled = [[True]]
    if opening:
        xs, zs = [-width / 2, opening[0], opening[1], width / 2], [0.0, opening[2], opening[3], height]
        filled = [[True, True, True], [True, False, True], [True, True, True]]
    lying = slab(xs, zs, filled, -WALL_THICKNESS, 0.0, 0.7)
    # Only the room's side and the reveals of the opening are ever seen.
    return transform(without_sides(lying, "-z"), rotate=(90.0, 0.0, 0.0))


def window(opening: Opening, panes: int = 2, sill: float = 0.10) -> Pieces:
    """Frame, sash bars, trim and sill of a window in a wall's opening; the sill reaches into the room."""
    x0, x1, z0, z1 = opening
    width, height = x1 - x0, z1 - z0
    y = WALL_THICKNESS - 0.035
    bars = []
    for x in (x0 + 0.026, x1 - 0.026):
        bars.append(box((x - 0.025, y - 0.03, z0 + 0.001), (x + 0.025, y + 0.03, z1 - 0.001)))
    for z in (z0 + 0.026, z1 - 0.026):
        bars.append(box((x0 + 0.0515, y - 0.0295, z - 0.025), (x1 - 0.0515, y + 0.0295, z + 0.025)))
    for pane in range(1, panes):
        x = x0 + width * pane / panes
        bars.append(box((x - 0.02, y - 0.02, z0 + 0.0515), (x + 0.02, y + 0.02, z1 - 0.0515)))
    z = z0 + height * 0.68
    for pane in range(panes):
        low, high = x0 + width * pane / panes, x0 + width * (pane + 1) / panes
        bars.append(
            box(
                (low + 0.021 + 0.031 * (pane == 0), y - 0.014, z - 0.014),
                (high - 0.021 - 0.031 * (pane == panes - 1), y + 0.014, z + 0.014),
            )
        )
    bars = [without_sides(bar, "+y") for bar in bars]
    trim = []
    for x in (x0 - 0.035, x1 + 0.035):
        trim.append(box((x - 0.0345, -0.0185, z0 + 0.0008), (x + 0.0345, -0.0005, z1 + 0.07)))
    trim.append(box((x0 + 0.0005, -0.0185, z1 + 0.0005), (x1 - 0.0005, -0.0005, z1 + 0.07)))
    trim = [without_sides(bar, "+y") for bar in trim]
    # One board from the sash to the room, wider in front of the wall, half a millimetre above the opening's floor.
    across = (x0 - 0.09, x0 + 0.0005, x1 - 0.0005, x1 + 0.09)
    trim.append(
        slab(
            across,
            (-sill, -0.0005, y - 0.031),
            ((True, False), (True, True), (True, False)),
            z0 - 0.0295,
            z0 + 0.0005,
        )
    )
    return [(merge([*bars, *trim]), WHITE_PAINT)]


def backdrop(width: float, distance: float, glow: Colour, seed: int = 0) -> Pieces:
    """The view out of a window at x = 0: a glowing picture `distance` behind the wall, horizon at eye height.

    Args:
        width: metres.
        distance: metres.
        glow: linear RGB, how bright the picture is.
        seed: of clouds and trees.
    """
    height = width * 0.5
    low = 1.25 - height * 0.46
    mesh = quad((-width / 2, distance, low), (width, 0, 0), (0, 0, height))
    strength = max(glow)
    tint = (glow[0] / strength, glow[1] / strength, glow[2] / strength)
    return [(mesh, Material(tint, prints.outside_view(seed), roughness=1.0, emission=strength))]


def door(material: Material, width: float = 0.88, height: float = 2.04) -> Pieces:
    """A closed panelled door with its frame and a knob."""
    leaf = box((-width / 2, -0.022, 0.004), (width / 2, -0.001, height), 0.9)
    panels = []
    for low, high in ((0.16, 0.92), (1.04, height - 0.13)):
        for side in (-1, 1):
            mesh = rounded_box((width / 2 - 0.15, 0.016, high - low), 0.007, 1, 0.9)
            panels.append(transform(mesh, (side * (width / 4 - 0.02), -0.0235, (low + high) / 2)))
    frame = [
        box(
            (side * (width / 2 + 0.044) - 0.0425, -0.0345, 0.0),
            (side * (width / 2 + 0.044) + 0.0425, -0.0005, height + 0.085),
        )
        for side in (-1, 1)
    ]
    frame.append(box((-width / 2 + 0.001, -0.0345, height + 0.0045), (width / 2 - 0.001, -0.0005, height + 0.0845)))
    frame = [without_sides(bar, "+y") for bar in frame]
    profile = smooth_profile(
        [(0.026, 0.0), (0.026, 0.006), (0.010, 0.008), (0.010, 0.03), (0.026, 0.04), (0.022, 0.06), (0.0, 0.062)]
    )
    knob = transform(lathe(profile, 24), (-width / 2 + 0.06, -0.0225, 1.02), (90.0, 0.0, 0.0))
    boards = merge([leaf, *panels])
    # The grain runs along u: a door's runs upwards.
    boards = with_uvs(boards, boards.uvs[:, ::-1])
    return [(boards, material), (merge(frame), WHITE_PAINT), (knob, BRASS)]


def baseboard(width: float) -> Pieces:
    """A skirting board along a wall."""
    board = box((-width / 2, -0.0145, 0.0), (width / 2, -0.0005, 0.09))
    return [(without_sides(board, "+y", "-z"), WHITE_PAINT)]


def ceiling_lamp(size: float, glow: Colour) -> tuple[Pieces, Pieces]:
    """A square lamp under the ceiling (z = 0): its housing, and its glowing face 4.5 cm below, facing down."""
    housing = box((-size / 2 - 0.03, -size / 2 - 0.03, -0.04), (size / 2 + 0.03, size / 2 + 0.03, -0.001))
    face = quad((-size / 2, size / 2, -0.045), (size, 0, 0), (0, -size, 0))
    return [(housing, WHITE_PAINT)], [(face, Material(glow, emission=1.0))]


def pendant_lamp(drop: float, shade: Material, glow: Colour, bulb_radius: float = 0.045) -> tuple[Pieces, Pieces]:
    """A lamp hanging `drop` below the ceiling (z = 0): its shade and cord, and its glowing bulb."""
    outer = [(0.02, 0.17), (0.022, 0.165), (0.09, 0.135), (0.17, 0.02), (0.178, 0.0)]
    outside = lathe(smooth_profile(outer[::-1]), 44)
    inside = lathe(smooth_profile([(radius - 0.004, z) for radius, z in outer]), 44)
    cap = transform(cylinder(0.022, 0.05, 20), (0.0, 0.0, 0.155))
    cord = tube([[0.0, 0.0, 0.2], [0.0, 0.0, drop - 0.02]], 0.004, 8)
    rose = transform(cylinder(0.05, 0.024, 28), (0.0, 0.0, drop - 0.0245))
    lift = (0.0, 0.0, -drop)
    fixed: Pieces = [
        (transform(outside, lift), shade),
        (transform(inside, lift), WHITE_PAINT),
        (transform(merge([cap, cord, rose]), lift), BLACK_PLASTIC),
    ]
    bulb = transform(sphere(bulb_radius, 20), (0.0, 0.0, 0.025 - drop))
    return fixed, [(bulb, Material(glow, emission=1.0))]


def picture(width: float, height: float, frame: Material, seed: int = 0) -> Pieces:
    """A framed landscape, its middle at the origin."""
    bar = 0.035
    bars = []
    for side in (-1, 1):
        bars.append(
            transform(rounded_box((bar, 0.028, height), 0.004, 1, 2.0), (side * (width - bar) / 2, -0.0145, 0.0))
        )
        bars.append(
            transform(
                rounded_box((width - 2 * bar, 0.028, bar), 0.004, 1, 2.0), (0.0, -0.0145, side * (height - bar) / 2)
            )
        )
    x, z = width / 2 - bar, height / 2 - bar
    mount = quad((-x, -0.006, -z), (2 * x, 0, 0), (0, 0, 2 * z))
    inset = 0.045
    canvas = quad((-x + inset, -0.008, -z + inset), (2 * (x - inset), 0, 0), (0, 0, 2 * (z - inset)))
    return [(merge(bars), frame), (mount, WHITE_PAINT), (canvas, printed(prints.painting(seed), 0.6))]


def clock(radius: float = 0.16) -> Pieces:
    """A round wall clock at ten past ten, its middle at the origin."""
    upright = (90.0, 0.0, 0.0)
    rim_profile = [
        (radius - 0.02, 0.0),
        (radius, 0.0),
        (radius, 0.03),
        (radius - 0.018, 0.034),
        (radius - 0.018, 0.018),
    ]
    rim = transform(lathe(smooth_profile(rim_profile, 1), 48), (0.0, -0.001, 0.0), upright)
    face_mesh = transform(disc(radius - 0.017, 0.018, 48), (0.0, -0.001, 0.0), upright)
    # Seen from -y, the upright disc's u runs to the right already, v upwards.
    face = with_uvs(face_mesh, face_mesh.vertices[:, [0, 2]] / (2 * (radius - 0.017)) + 0.5)
    hands = []
    for angle, length in ((-55.0, 0.5), (60.0, 0.74)):
        hand = transform(rounded_box((0.009, 0.003, radius * length), 0.001), (0.0, 0.0, radius * length / 2 - 0.012))
        hands.append(transform(hand, (0.0, -0.024, 0.0), (0.0, angle, 0.0)))
    pin = transform(cylinder(0.008, 0.01, 16), (0.0, -0.0185, 0.0), upright)
    return [(rim, BLACK_PLASTIC), (face, printed(prints.clock_face(), 0.3)), (merge([*hands, pin]), BLACK_PLASTIC)]


def bin_with_pedal(radius: float = 0.145, height: float = 0.58) -> Pieces:
    """A round steel bin with a black lid."""
    body = lathe(
        smooth_profile([(0.0, 0.0), (radius - 0.01, 0.0), (radius - 0.008, 0.01), (radius - 0.008, 0.025)], 1), 36
    )
    drum = cylinder(radius, height - 0.10, 40, 0.003)
    lid = [(radius + 0.002, 0.0), (radius + 0.002, 0.02), (radius * 0.8, 0.06), (0.0, 0.072)]
    pedal = transform(rounded_box((0.06, 0.05, 0.01), 0.004), (0.0, -radius - 0.012, 0.016))
    return [
        (transform(drum, (0.0, 0.0, 0.026)), steel()),
        (merge([body, transform(lathe(smooth_profile(lid), 40), (0.0, 0.0, height - 0.072)), pedal]), BLACK_PLASTIC),
    ]
