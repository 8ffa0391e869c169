"""Bound and printed paper: book, stack of books, notebook, file."""

from __future__ import annotations

import numpy as np

from indoor_rooms.geometry.boxes import rounded_box
from indoor_rooms.geometry.curves import arc, cylinder, lathe, tube
from indoor_rooms.geometry.mesh import merge, quad, transform
from indoor_rooms.geometry.pieces import Pieces, placed
from indoor_rooms.materials import prints, prints_paper, prints_patterns
from indoor_rooms.materials.surfaces import BLACK_PLASTIC, CHROME, PAPER, metallic, plastic, printed, rubber
from indoor_rooms.objects.shaping import facing, pick, two_colours

TITLES = (
    "THE KITCHEN BOOK",
    "BREAD AND SALT",
    "SOUPS",
    "THE SEA",
    "NIGHT TRAIN",
    "GARDENS",
    "ATLAS OF BIRDS",
    "A SHORT WALK",
    "STARS",
    "WINTER",
    "ON LIGHT",
    "THE LONG ROAD",
)
FILES = ("TAX", "BILLS", "LETTERS", "PLANS", "MINUTES", "INVOICES", "2023", "2024", "A - K", "L - Z")
BOARD = 0.003


def _colours(rng: np.random.Generator) -> tuple[str, str, str]:
    """Ground, ornament and ink of a cover."""
    ground, accent = two_colours(rng)
    pale = sum(int(ground[start : start + 2], 16) for start in (1, 3, 5)) > 480
    return ground, accent, "#23252a" if pale else "#fff6e4"


def _hardback(rng: np.random.Generator, width: float, depth: float, height: float) -> Pieces:
    """A hardback lying on its back, front cover up, spine towards -x, with a title on both."""
    title, style = pick(rng, TITLES), int(rng.integers(7))
    ground, accent, ink = _colours(rng)
    face = (
        prints.book_cover(title, ground, accent, int(rng.integers(3)))
        if style == 6
        else prints_paper.cover(title, ground, accent, ink, style)
    )
    boards = [
        rounded_box((width, depth, BOARD), 0.0012, base=True),
        transform(rounded_box((width, depth, BOARD), 0.0012, base=True), (0.0, 0.0, height - BOARD)),
        transform(
            rounded_box((BOARD, depth, height - 2 * BOARD + 0.0004), 0.0005),
            (-width / 2 + BOARD / 2, 0.0, height / 2),
        ),
    ]
    pages = transform(
        rounded_box((width - 0.009, depth - 0.008, height - 2 * BOARD + 0.0006), 0.0008), (-0.0008, 0.0, height / 2)
    )
    front = quad(
        (-width / 2 + 0.002, -depth / 2 + 0.002, height + 0.0005), (width - 0.004, 0, 0), (0, depth - 0.004, 0)
    )
    back = quad((-width / 2 - 0.0006, depth / 2 - 0.002, 0.002), (0, 0.004 - depth, 0), (0, 0, height - 0.004))
    return [
        (merge(boards), plastic(ground, 0.5)),
        (pages, PAPER),
        (front, printed(face, 0.4)),
        (back, printed(prints_paper.spine(title, ground, ink if style != 4 else accent), 0.4)),
    ]


def book(rng: np.random.Generator) -> Pieces:
    """A hardback lying on its back, its front cover up, spine towards -x."""
    width = rng.uniform(0.135, 0.2)
    return _hardback(rng, width, width * rng.uniform(1.15, 1.5), rng.uniform(0.022, 0.045))


def book_stack(rng: np.random.Generator) -> Pieces:
    """Three to five books lying on one another, spines towards -y, the larger ones below."""
    pieces: Pieces = []
    level, width = 0.0, rng.uniform(0.18, 0.215)
    for _ in range(int(rng.integers(3, 6))):
        depth, height = width * rng.uniform(1.25, 1.4), rng.uniform(0.02, 0.042)
        turn = 90.0 + rng.uniform(-9.0, 9.0)
        pieces += placed(_hardback(rng, width, depth, height), (0.0, rng.uniform(-0.006, 0.006), level), turn)
        # The cover's print lies half a millimetre above the board.
        level += height + 0.0011
        width *= rng.uniform(0.86, 0.99)
    return pieces


def _pen_lying(rng: np.random.Generator) -> Pieces:
    """A pen along y, resting on z = 0."""
    radius, length = 0.0045, rng.uniform(0.13, 0.145)
    parts = (
        [(0.0, 0.0), (0.0012, 0.002), (radius * 0.6, 0.01), (radius, 0.018), (radius, length * 0.6)],
        [(radius * 1.1, length * 0.6), (radius * 1.1, length - 0.004), (0.003, length), (0.0, length)],
    )
    barrel, end = (
        transform(lathe(profile, 14), (0.0, -length / 2, radius * 1.1), (-90.0, 0.0, 0.0)) for profile in parts
    )
    clip = transform(rounded_box((0.003, 0.036, 0.0012), 0.0004), (0.0, length * 0.28, radius * 2.1 + 0.0006))
    first, second = two_colours(rng)
    return [
        (barrel, plastic(first, 0.25)),
        (merge([end, clip]), plastic(second, 0.25) if rng.random() < 0.6 else CHROME),
    ]


def notebook(rng: np.random.Generator) -> Pieces:
    """A notebook lying closed with a pen on it: bound with an elastic band, or on a spiral at its -x edge."""
    width, height = rng.uniform(0.135, 0.165), rng.uniform(0.010, 0.018)
    depth = width * rng.uniform(1.3, 1.45)
    ground, accent, ink = _colours(rng)
    spiral = rng.random() < 0.5
    rounding = 0.0012
    covers = [
        transform(rounded_box((width, depth, 0.0022), rounding, base=True), (0.0, 0.0, z))
        for z in (0.0, height - 0.0022)
    ]
    pages = transform(
        rounded_box((width - 0.004, depth - 0.004, height - 0.0038), 0.0006), (-0.0005, 0.0, height / 2)
    )
    front = quad(
        (-width / 2 + 0.002, -depth / 2 + 0.002, height + 0.0006), (width - 0.004, 0, 0), (0, depth - 0.004, 0)
    )
    if rng.random() < 0.3:
        kind = pick(rng, prints_patterns.PATTERNS)
        face = prints_patterns.pattern(kind, ground, accent, ink, 6, 0.0)
    else:
        style = int(rng.integers(6))
        face = prints_paper.cover(pick(rng, ("NOTES", "IDEAS", "DIARY", "")), ground, accent, ink, style)
    pieces: Pieces = [(merge(covers), plastic(ground, 0.55)), (pages, PAPER), (front, printed(face, 0.5))]
    if spiral:
        size = height / 2 + 0.0035
        ring = tube(arc((0.0, 0.0, 0.0), size, 35, 325, 13), 0.0011, 6)
        rings = [
            transform(ring, (-width / 2 + 0.002, y, size + 0.0011))
            for y in np.linspace(-depth * 0.45, depth * 0.45, 16)
        ]
        pieces.append((merge(rings), metallic(pick(rng, ("#c9ccd0", "#3a3d42", "#d8b45a")))))
        lift = 0.0
    else:
        spine = transform(rounded_box((0.003, depth, height), 0.001), (-width / 2, 0.0, height / 2))
        band = transform(
            rounded_box((0.007, depth + 0.002, height + 0.0022), 0.0008), (width * 0.38, 0.0, height / 2 + 0.0009)
        )
        pieces.append((merge([spine, band]), rubber(accent)))
        lift = 0.0003
    pieces = placed(pieces, (0.0, 0.0, lift))
    top = height + lift + 0.0006
    return pieces + placed(
        _pen_lying(rng), (rng.uniform(-0.02, 0.02), rng.uniform(-0.01, 0.01), top), rng.uniform(-40, 40)
    )


def binder(rng: np.random.Generator) -> Pieces:
    """A standing file of papers, its spine with the label towards -y."""
    width, depth, height = float(rng.choice([0.052, 0.075, 0.08])), 0.285, 0.318
    ground, accent, _ = _colours(rng)
    board = 0.0028
    sides = [
        transform(rounded_box((board, depth, height), 0.001, base=True), (x, 0.0, 0.0))
        for x in (-(width - board) / 2, (width - board) / 2)
    ]
    back = transform(
        rounded_box((width - 2 * board + 0.0006, board, height - 0.001), 0.0008, base=True),
        (0.0, -(depth - board) / 2, 0.0004),
    )
    fill = rng.uniform(0.35, 0.9) * (width - 2 * board)
    paper = transform(
        rounded_box((fill, 0.215, 0.297), 0.001, base=True), (-(width - fill) / 2 + board, -0.012, 0.006)
    )
    front = -depth / 2
    label_high = rng.uniform(0.15, 0.19)
    label = quad((-width * 0.38, front - 0.0008, 0.29 - label_high), (width * 0.76, 0, 0), (0, 0, label_high))
    ring = lathe([(0.009, 0.0), (0.0125, 0.0), (0.0125, 0.0012), (0.0105, 0.002), (0.009, 0.001)], 26)
    hole = cylinder(0.0095, 0.0008, 24, 0.0)
    low = 0.05
    rail = merge(
        [
            transform(rounded_box((width - 0.002, 0.004, 0.0012), 0.0004), (0.0, front + 0.004, z))
            for z in (0.0006, height - 0.0002)
        ]
    )
    tag = prints_paper.binder_label(pick(rng, FILES), accent)
    grain = rng.random() < 0.4
    look = (
        printed(prints_patterns.pattern("dots", ground, ground, ground, 8, 0.16), 0.6) if grain else plastic(ground)
    )
    return [
        (merge([*sides, back]), look),
        (paper, PAPER),
        (label, printed(tag)),
        (facing(ring, front + 0.0004, low), CHROME),
        (facing(hole, front + 0.0004, low), BLACK_PLASTIC),
        (rail, metallic("#b5b8bc")),
    ]
