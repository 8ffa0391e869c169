"""Furniture of living rooms and conference rooms: sound, as large as asked, with its surfaces where it says."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from indoor_rooms.furniture import lounge, office, screens, soft, storage, tables
from indoor_rooms.geometry.pieces import Pieces, bounds
from indoor_rooms.materials import board_prints, textures
from indoor_rooms.materials.surfaces import CHROME, beech, cloth
from test_content import assert_sound

WOOD, CLOTH = beech(), cloth("#7d8b95")
OPENING = (-0.6, 0.6, 0.9, 2.1)


def rng(seed: int = 1) -> np.random.Generator:
    return np.random.default_rng(seed)


def lamp(seed: int) -> Pieces:
    fixed, glowing, _, _ = soft.floor_lamp(rng(seed), (1.0, 1.0, 1.0))
    return fixed + glowing


# Standing pieces with the width (x) and the height (z) they were asked for or promise; None: not promised.
STANDING: dict[str, tuple[Callable[[], Pieces], float | None, float | None]] = {
    "two-seater": (lambda: lounge.sofa(1.6, CLOTH, WOOD), 1.6, None),
    "three-seater": (lambda: lounge.sofa(2.2, CLOTH, WOOD), 2.2, None),
    "armchair": (lambda: lounge.armchair(CLOTH, WOOD), 0.86, None),
    "coffee table": (lambda: tables.coffee_table(1.1, 0.6, WOOD, WOOD), 1.1, 0.42),
    "round coffee table": (lambda: tables.coffee_table(0.8, 0.8, WOOD, WOOD, "round"), 0.8, 0.42),
    "coffee table with a shelf": (lambda: tables.coffee_table(1.1, 0.6, WOOD, WOOD, "shelf"), 1.1, 0.42),
    "side table": (lambda: tables.side_table(0.45, WOOD, WOOD), 0.45, tables.SIDE_TABLE_HEIGHT),
    "round table": (lambda: tables.round_table(0.55, WOOD, WOOD), 1.1, 0.75),
    "desk": (lambda: tables.desk(1.4, 0.7, WOOD, WOOD), 1.4, tables.DESK_HEIGHT),
    "conference table": (lambda: tables.conference_table(2.6, 1.2, WOOD, WOOD), 2.6, None),
    "bookcase": (lambda: storage.bookcase(0.9, 1.9, WOOD, 6), 0.9, 1.9),
    "books": (lambda: storage.row_of_books(0.8, 0.28, 0.22, rng(1)), 0.8, None),
    "leaning books": (lambda: storage.row_of_books(0.4, 0.28, 0.22, rng(7)), None, None),
    "tv stand": (lambda: storage.tv_stand(1.6, WOOD), 1.6, storage.TV_STAND_HEIGHT),
    "chest": (lambda: storage.chest_of_drawers(0.9, WOOD, WOOD, 4), 0.9, storage.CHEST_HEIGHT),
    "filing cabinet": (lambda: storage.filing_cabinet(WOOD), 0.42, storage.FILING_CABINET_HEIGHT),
    "television": (lambda: screens.television(1.1), 1.1, None),
    "office chair": (lambda: office.office_chair(CLOTH), None, None),
    "meeting chair": (lambda: office.meeting_chair(CLOTH, CHROME), None, None),
    "paper bin": (office.paper_bin, None, 0.31),
    "coat stand": (office.coat_stand, None, None),
    "flip chart": (office.flip_chart, None, None),
    "radiator": (lambda: soft.radiator(1.2), None, 0.55),
    "floor lamp 1": (lambda: lamp(1), None, None),
    "floor lamp 2": (lambda: lamp(2), None, None),
}
HANGING: dict[str, Callable[[], Pieces]] = {
    "wall screen": lambda: screens.wall_screen(1.4),
    "dark wall screen": lambda: screens.wall_screen(1.4, None),
    "whiteboard": lambda: screens.whiteboard(1.8, 1.1),
    "pinboard": lambda: screens.pinboard(1.2, 0.9, rng()),
    "long curtains": lambda: soft.curtains(OPENING, CLOTH, WOOD),
    "short curtains": lambda: soft.curtains(OPENING, CLOTH, WOOD, "sill"),
    "blinds": lambda: soft.blinds(OPENING, "#e8e4da"),
}


def extent(pieces: Pieces) -> np.ndarray:
    return bounds(mesh for mesh, _ in pieces)


def heights_at(pieces: Pieces, x: float, y: float) -> list[float]:
    """The z of the upward faces straight above or below a place, highest first."""
    found = []
    for mesh, _ in pieces:
        a, b, c = (mesh.vertices[mesh.faces[:, corner]] for corner in range(3))
        normal = np.cross(b - a, c - a)
        level = normal[:, 2] > 0.99 * np.maximum(np.linalg.norm(normal, axis=1), 1e-15)
        point = np.array([x, y])

        def left(p: np.ndarray, q: np.ndarray, point: np.ndarray = point) -> np.ndarray:
            return (q[:, 0] - p[:, 0]) * (point[1] - p[:, 1]) - (q[:, 1] - p[:, 1]) * (point[0] - p[:, 0]) >= -1e-12

        found += a[level & left(a, b) & left(b, c) & left(c, a), 2].tolist()
    return sorted(found, reverse=True)


def has_surface(pieces: Pieces, x: float, y: float, z: float) -> bool:
    return any(abs(found - z) < 1e-4 for found in heights_at(pieces, x, y))


@pytest.mark.parametrize("name", STANDING)
def test_standing_pieces_are_sound_and_as_large_as_asked(name: str) -> None:
    make, width, height = STANDING[name]
    pieces = make()
    for mesh, _ in pieces:
        assert_sound(mesh)
    low, high = extent(pieces)
    assert abs(low[2]) < 1e-3
    if width is not None:
        assert high[0] - low[0] == pytest.approx(width, abs=2e-3)
        assert high[0] + low[0] == pytest.approx(0.0, abs=2e-3)
    if height is not None:
        assert high[2] == pytest.approx(height, abs=1e-3)
    assert sum(len(mesh.faces) for mesh, _ in pieces) <= (2500 if "books" in name else 6000)


@pytest.mark.parametrize("name", HANGING)
def test_hanging_pieces_are_sound(name: str) -> None:
    pieces = HANGING[name]()
    for mesh, _ in pieces:
        assert_sound(mesh)
    assert sum(len(mesh.faces) for mesh, _ in pieces) <= 6000


def test_hanging_pieces_hang_where_they_say() -> None:
    low, high = extent(HANGING["wall screen"]())
    np.testing.assert_allclose(low[[0, 2]], -high[[0, 2]], atol=1e-9)
    assert high[0] - low[0] == pytest.approx(1.4)
    assert extent(HANGING["whiteboard"]())[1, 2] == pytest.approx(0.55, abs=1e-6)
    low, high = extent(HANGING["pinboard"]())
    np.testing.assert_allclose(high - low, [1.2, high[1] - low[1], 0.9], atol=1e-6)


@pytest.mark.parametrize(
    "name",
    ["three-seater", "desk", "bookcase", "books", "tv stand", "chest", "filing cabinet", "television", "radiator"],
)
def test_what_stands_on_a_wall_is_in_front_of_it(name: str) -> None:
    assert -0.02 <= extent(STANDING[name][0]())[1, 1] <= 1e-6


@pytest.mark.parametrize("width", [1.6, 2.2])
def test_sofas_have_their_seat_where_they_say(width: float) -> None:
    pieces = lounge.sofa(width, CLOTH, WOOD)
    seats = lounge.seat_centres(width)
    assert len(seats) == (2 if width < 1.95 else 3)
    for x in seats:
        for share in (0.1, 0.5, 0.98):
            y = -lounge.SOFA_BACK_DEPTH - share * lounge.SOFA_SEAT_DEPTH
            assert heights_at(pieces, x, y)[0] == pytest.approx(lounge.SEAT_HEIGHT, abs=1e-6)
    cushions = pieces[0][0].vertices
    above = cushions[(cushions[:, 2] > lounge.SEAT_HEIGHT + 0.02) & (np.abs(cushions[:, 0]) < width / 2 - 0.2)]
    assert above[:, 1].min() > -lounge.SOFA_BACK_DEPTH


@pytest.mark.parametrize(
    ("pieces", "place", "z"),
    [
        (lounge.armchair(CLOTH, WOOD), (0.0, -0.1), lounge.SEAT_HEIGHT),
        (tables.coffee_table(1.1, 0.6, WOOD, WOOD), (0.4, 0.2), tables.COFFEE_TABLE_HEIGHT),
        (tables.coffee_table(0.9, 0.9, WOOD, WOOD, "round"), (0.2, 0.2), tables.COFFEE_TABLE_HEIGHT),
        (tables.coffee_table(1.1, 0.6, WOOD, WOOD, "shelf"), (0.3, 0.1), tables.COFFEE_TABLE_SHELF),
        (tables.side_table(0.45, WOOD, WOOD), (0.1, 0.1), tables.SIDE_TABLE_HEIGHT),
        (tables.round_table(0.5, WOOD, WOOD), (0.3, 0.1), 0.75),
        (tables.desk(1.4, 0.7, WOOD, WOOD), (0.5, -0.3), tables.DESK_HEIGHT),
        (tables.conference_table(2.6, 1.2, WOOD, WOOD), (0.9, 0.4), tables.CONFERENCE_TABLE_HEIGHT),
        (storage.tv_stand(1.6, WOOD), (0.5, -0.2), storage.TV_STAND_HEIGHT),
        (storage.chest_of_drawers(0.9, WOOD, WOOD, 4), (0.3, -0.2), storage.CHEST_HEIGHT),
        (storage.filing_cabinet(WOOD), (0.1, -0.2), storage.FILING_CABINET_HEIGHT),
        (office.office_chair(CLOTH), (0.05, 0.05), office.OFFICE_SEAT_HEIGHT),
        (office.meeting_chair(CLOTH, CHROME), (0.05, 0.05), office.MEETING_SEAT_HEIGHT),
    ],
)
def test_exported_heights_are_true(pieces: Pieces, place: tuple[float, float], z: float) -> None:
    assert has_surface(pieces, *place, z)


@pytest.mark.parametrize(("height", "boards"), [(1.9, 6), (1.5, 5), (0.8, 2)])
def test_boards_are_at_the_heights_given(height: float, boards: int) -> None:
    heights = storage.board_heights(height, boards)
    assert len(heights) == boards
    assert heights[-1] == pytest.approx(height)
    pieces = storage.bookcase(0.9, height, WOOD, boards)
    for z in heights:
        assert has_surface(pieces, storage.inner_width(0.9) / 2 - 0.01, -0.15, z)


@pytest.mark.parametrize("seed", range(6))
def test_rows_of_books_fill_their_space_and_no_more(seed: int) -> None:
    low, high = extent(storage.row_of_books(0.6, 0.28, 0.22, rng(seed)))
    np.testing.assert_allclose([low[0], high[0]], [-0.3, 0.3], atol=2e-3)
    assert high[2] <= 0.28
    assert -0.2201 <= low[1] < -0.2
    assert high[1] <= 1e-9


@pytest.mark.parametrize("pieces", [office.office_chair(CLOTH), office.meeting_chair(CLOTH, CHROME)])
def test_chairs_face_north(pieces: Pieces) -> None:
    vertices = np.concatenate([mesh.vertices for mesh, material in pieces if material is CLOTH])
    assert vertices[vertices[:, 2] > 0.7, 1].max() < 0.0


@pytest.mark.parametrize("pieces", [office.office_chair(CLOTH), office.meeting_chair(CLOTH, CHROME)])
def test_backrests_are_wound_outwards(pieces: Pieces) -> None:
    mesh = next(mesh for mesh, material in pieces if material is CLOTH)
    faces = mesh.faces[mesh.vertices[mesh.faces][:, :, 2].min(axis=1) > 0.5]
    a, b, c = (mesh.vertices[faces[:, corner]] - [0.0, -0.25, 0.7] for corner in range(3))
    assert (a * np.cross(b, c)).sum() > 0


@pytest.mark.parametrize("drop", ["floor", "sill"])
def test_curtains_leave_the_window_free(drop: str) -> None:
    pieces = soft.curtains(OPENING, CLOTH, WOOD, drop)
    x = pieces[0][0].vertices[:, 0]
    width = OPENING[1] - OPENING[0]
    assert np.abs(x).min() >= width / 2 - 0.2 * width
    # In front of the sill, which sticks out 10 cm.
    assert pieces[0][0].vertices[:, 1].max() < -0.10
    lowest = pieces[0][0].vertices[:, 2].min()
    assert lowest < 0.05 if drop == "floor" else 0.6 < lowest < OPENING[2]


def test_blinds_stay_in_their_opening() -> None:
    low, high = extent(soft.blinds(OPENING, "#e8e4da"))
    assert OPENING[0] < low[0] < high[0] < OPENING[1]
    assert OPENING[2] < low[2] < high[2] < OPENING[3]
    assert low[1] > 0.0


@pytest.mark.parametrize("seed", range(5))
def test_floor_lamps_say_where_their_bulb_is(seed: int) -> None:
    _, glowing, centre, radius = soft.floor_lamp(rng(seed), (3.0, 2.0, 1.0))
    mesh, material = glowing[0]
    np.testing.assert_allclose(np.linalg.norm(mesh.vertices - centre, axis=1), radius, rtol=1e-6)
    assert material.emission > 0
    assert material.colour == (3.0, 2.0, 1.0)


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: lounge.sofa(-1.0, CLOTH, WOOD), "a sofa's width in metres must be between 1.3 and 2.8, got -1"),
        (lambda: lounge.armchair(CLOTH, WOOD, width=5.0), "an armchair's width"),
        (lambda: tables.coffee_table(1.0, -0.5, WOOD, WOOD), "a coffee table's depth"),
        (lambda: tables.coffee_table(1.0, 0.5, WOOD, WOOD, "star"), "no coffee table of shape 'star'; choose"),
        (lambda: tables.conference_table(1.6, 1.7, WOOD, WOOD), "a conference table's depth"),
        (lambda: tables.desk(float("nan"), 0.7, WOOD, WOOD), "a desk's width"),
        (lambda: storage.bookcase(0.9, 1.0, WOOD, 12), "12 boards leave only .* take at most 6"),
        (lambda: storage.board_heights(1.8, 1), "at least 2 boards"),
        (lambda: storage.bookcase(-0.9, 1.8, WOOD, 4), "a bookcase's width"),
        (lambda: storage.row_of_books(0.0, 0.3, 0.2, rng()), "a row of books' width"),
        (lambda: storage.chest_of_drawers(0.9, WOOD, WOOD, 9), "a chest's number of drawers"),
        (lambda: storage.filing_cabinet(WOOD, 0), "a filing cabinet's number of drawers"),
        (lambda: screens.television(0.0), "a television's width"),
        (lambda: screens.whiteboard(1.0, -1.0), "a whiteboard's height"),
        (lambda: soft.curtains((0.5, -0.5, 1.0, 2.0), CLOTH, WOOD), "rising values"),
        (lambda: soft.curtains(OPENING, CLOTH, WOOD, "roof"), "not to 'roof'"),
        (lambda: soft.blinds(OPENING, "#ffffff", 1.5), "the share of the window"),
        (lambda: soft.radiator(-1.0), "a radiator's width"),
    ],
)
def test_sizes_no_one_would_build_are_refused(make: Callable[[], Pieces], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        make()


TILEABLE: dict[str, Callable[[int], textures.Texture]] = {
    "carpet": lambda seed: textures.carpet("#8a8f94", seed),
    "carpet tiles": lambda seed: textures.carpet_tiles("#5d6670", seed, size=512),
    "leather": lambda seed: textures.leather("#7a4528", seed),
    "cork": textures.cork,
}


@pytest.mark.parametrize("name", TILEABLE)
def test_new_textures_tile_and_follow_their_seed(name: str) -> None:
    image = TILEABLE[name](3)
    assert image.dtype == np.float32
    assert not np.array_equal(image, TILEABLE[name](4))
    for axis in (0, 1):
        steps = np.abs(np.diff(image, axis=axis, append=np.take(image, [0], axis=axis))).mean(axis=(1 - axis, 2))
        assert steps[-1] <= steps[:-1].max() * 1.3 + 1e-4


@pytest.mark.parametrize("make", [board_prints.book_spines, board_prints.whiteboard_writing, board_prints.slide])
def test_prints_follow_their_seed(make: Callable[[int], textures.Texture]) -> None:
    assert make(1) is make(1)
    assert not np.array_equal(make(1), make(2))
