"""Ways to break a file: what a full disk, a bad copy, a spreadsheet program or another program's author makes of it.

`broken` draws one that suits the kind of file; everything follows from the generator it is given.
"""

from __future__ import annotations

import csv
import io
import json
from collections.abc import Callable
from typing import Any

import h5py
import numpy as np
from PIL import Image
from scipy.io import loadmat, savemat

Breaker = Callable[[bytes, np.random.Generator], bytes]

# Beginnings of what HDF5 keeps between the data; flips are near to them, as data may hold anything anyway.
HDF5_MARKS = (b"\x89HDF", b"TREE", b"HEAP", b"SNOD", b"OHDR", b"GCOL")
ODD_TEXTS = (
    "", "nan", "-inf", "1e999", "1e308", "-1e9", "99999999999999999999", "0x10", "1,5", "٣", "1_0", "zwölf", "a\nb",
    "\x00", "\x1b[2J", '"', "'", ";", "=1+1", "../../x", "/dev/zero", ".", "..", "%00", "x" * 5000, "MoveAhead",
    " 1 ", "[/red]",
)  # fmt: skip
ODD_VALUES: tuple[Any, ...] = (
    None, True, False, -1, 0, 1, 2**31, 2**63, 10**400, 1e308, float("nan"), float("inf"), [], {}, [[]], [None] * 4,
    "\ud800", {"a": {"b": []}}, *ODD_TEXTS,
)  # fmt: skip


def broken(data: bytes, suffix: str, rng: np.random.Generator) -> tuple[str, bytes]:
    """A file broken in one way: what was done to it, and its bytes.

    Args:
        data: the sound file.
        suffix: what kind it is, such as ".csv".
        rng: draws way and place.
    """
    special = BREAKERS.get(suffix, ())
    breaker = rng.choice(np.array(special if special and rng.random() < 0.65 else ANY_FILE, object))
    return breaker.__name__.strip("_"), breaker(data, rng)


def _truncated(data: bytes, rng: np.random.Generator) -> bytes:
    return data[: int(rng.integers(len(data)))]


def _bits_flipped(data: bytes, rng: np.random.Generator) -> bytes:
    flipped = bytearray(data)
    for place in _places(data, rng, int(rng.integers(1, 20))):
        flipped[place] ^= 1 << int(rng.integers(8))
    return bytes(flipped)


def _bytes_changed(data: bytes, rng: np.random.Generator) -> bytes:
    changed = bytearray(data)
    for place in _places(data, rng, int(rng.integers(1, 6))):
        changed[place] = int(rng.choice([0, 1, 127, 128, 255, int(rng.integers(256))]))
    return bytes(changed)


def _places(data: bytes, rng: np.random.Generator, count: int) -> list[int]:
    """Indices of bytes; in HDF5 most of them near the marks of its structure."""
    marks = [place for mark in HDF5_MARKS for place in _found(data, mark)] if data[:4] == HDF5_MARKS[0] else []
    starts = [int(rng.choice(marks)) if marks and rng.random() < 0.8 else None for _ in range(count)]
    return [
        min(start + int(rng.integers(200)), len(data) - 1) if start is not None else int(rng.integers(len(data)))
        for start in starts
    ]


def _found(data: bytes, mark: bytes) -> list[int]:
    places, place = [], data.find(mark)
    while place >= 0:
        places.append(place)
        place = data.find(mark, place + 1)
    return places


def _block_zeroed(data: bytes, rng: np.random.Generator) -> bytes:
    start, length = int(rng.integers(len(data))), int(rng.integers(1, 2000))
    return data[:start] + b"\0" * min(length, len(data) - start) + data[start + length :]


def _block_lost(data: bytes, rng: np.random.Generator) -> bytes:
    start = int(rng.integers(len(data)))
    return data[:start] + data[start + int(rng.integers(1, 600)) :]


def _block_doubled(data: bytes, rng: np.random.Generator) -> bytes:
    start, length = int(rng.integers(len(data))), int(rng.integers(1, 600))
    return data[: start + length] + data[start:]


def _emptied(data: bytes, rng: np.random.Generator) -> bytes:
    return b""


def _noise(data: bytes, rng: np.random.Generator) -> bytes:
    return rng.bytes(int(rng.integers(1, 3000)))


def _another_kind(data: bytes, rng: np.random.Generator) -> bytes:
    others = (_image("png", rng), b"file,x,z\na,1,2\n", b'{"a": 1}', b"\x89HDF\r\n\x1a\n")
    return others[int(rng.integers(len(others)))]


ANY_FILE: tuple[Breaker, ...] = (
    _truncated, _truncated, _bits_flipped, _bits_flipped, _bytes_changed, _block_zeroed, _block_lost, _block_doubled,
    _emptied, _noise, _another_kind,
)  # fmt: skip


def _encoded_otherwise(data: bytes, rng: np.random.Generator) -> bytes:
    return data.decode().encode(str(rng.choice(["utf-8-sig", "utf-16", "utf-32-le", "cp037"])))


def _bad_utf8(data: bytes, rng: np.random.Generator) -> bytes:
    start = int(rng.integers(len(data)))
    return data[:start] + b"\xff\xc3" + data[start:]


def _odd_cells(data: bytes, rng: np.random.Generator) -> bytes:
    rows = _table(data)
    for _ in range(int(rng.integers(1, 4))):
        row = rows[int(rng.integers(len(rows)))]
        row[int(rng.integers(len(row)))] = str(rng.choice(np.array(ODD_TEXTS, object)))
    return _as_csv(rows)


def _odd_column(data: bytes, rng: np.random.Generator) -> bytes:
    """All of a column the same, or very large, or gone, or in the place of another one."""
    rows = _table(data)
    column, other, way = (int(rng.integers(limit)) for limit in (len(rows[0]), len(rows[0]), 4))
    odd = str(rng.choice(np.array(ODD_TEXTS, object)))
    for number, row in enumerate(rows):
        if way == 0 and number:
            row[column] = odd
        elif way == 1 and number:
            row[column] = str(rng.uniform(-9999, 9999))
        elif way == 2:
            del row[column]
        elif way == 3 and number:
            row[column], row[other] = row[other], row[column]
    return _as_csv(rows)


def _lines_mixed(data: bytes, rng: np.random.Generator) -> bytes:
    """A line twice, a line lost, the head lost, a line too long, or only one line left."""
    rows = _table(data)
    place, way = int(rng.integers(1, len(rows))), int(rng.integers(5))
    return _as_csv(
        (
            [*rows, rows[place]],
            rows[:place] + rows[place + 1 :],
            rows[1:],
            [*rows[:place], [*rows[place], "1"], *rows[place:]],
            [rows[0], rows[place]],
        )[way]
    )


def _other_signs(data: bytes, rng: np.random.Generator) -> bytes:
    before, after = [(b",", b";"), (b",", b"\t"), (b"\n", b"\r"), (b".", b","), (b",", b'"'), (b"file", b"File ")][
        int(rng.integers(6))
    ]
    return data.replace(before, after)


def _table(data: bytes) -> list[list[str]]:
    return list(csv.reader(io.StringIO(data.decode())))


def _as_csv(rows: list[list[str]]) -> bytes:
    text = io.StringIO()
    csv.writer(text).writerows(rows)
    return text.getvalue().encode("utf-8", "surrogatepass")


def _odd_value(data: bytes, rng: np.random.Generator) -> bytes:
    """Some values, or keys, of a JSON document are something else."""
    content = json.loads(data)
    for _ in range(int(rng.integers(1, 4))):
        content = _changed(content, rng, ODD_VALUES[int(rng.integers(len(ODD_VALUES)))])
    return json.dumps(content).encode()


def _changed(value: Any, rng: np.random.Generator, odd: Any) -> Any:
    """A copy with something in it, at any depth, odd, gone or under an odd name."""
    if isinstance(value, dict) and value and rng.random() < 0.93:
        key = list(value)[int(rng.integers(len(value)))]
        way = rng.random()
        if way < 0.06:
            return {other: entry for other, entry in value.items() if other != key}
        if way < 0.12:
            return {str(odd) if other == key else other: entry for other, entry in value.items()}
        return {**value, key: _changed(value[key], rng, odd)}
    if isinstance(value, list) and value and rng.random() < 0.93:
        place = int(rng.integers(len(value)))
        if rng.random() < 0.06:
            return value[:place] + value[place + 1 :]
        return [*value[:place], _changed(value[place], rng, odd), *value[place + 1 :]]
    return odd


def _deep(data: bytes, rng: np.random.Generator) -> bytes:
    depth = int(rng.choice([900, 100_000]))
    start = int(rng.integers(2))
    return (b"[" * depth + b"]" * depth, data.replace(b"[", b"[" * depth, 1))[start]


def _doubled_keys(data: bytes, rng: np.random.Generator) -> bytes:
    place = data.find(b"{", int(rng.integers(len(data))))
    return data[: place + 1] + data[place + 1 :].replace(b'"', b'"x": 1, "', 1) if place >= 0 else data + data


def _bare_numbers(data: bytes, rng: np.random.Generator) -> bytes:
    """A number is one that JSON does not have, or that no float holds."""
    digits = [place for place, byte in enumerate(data) if 48 <= byte < 58]
    if not digits:
        return data + b"1"
    place = digits[int(rng.integers(len(digits)))]
    odd = (b"NaN", b"-Infinity", b"1e999", b"9" * 5000, b"00", b"1e", b"-")[int(rng.integers(7))]
    return data[:place] + odd + data[place + 1 :]


def _mistyped(data: bytes, rng: np.random.Generator) -> bytes:
    """A dataset of an HDF5 file has another type or shape, or is something else."""
    buffer = io.BytesIO(data)
    with h5py.File(buffer, "r+") as file:
        names: list[str] = []
        file.visititems(lambda name, found: names.append(name) if isinstance(found, h5py.Dataset) else None)
        for name in rng.choice(names, min(len(names), int(rng.integers(1, 3))), replace=False).tolist():
            _replace(file, name, file[name][()], rng)
    return buffer.getvalue()


def _replace(file: h5py.File, name: str, values: Any, rng: np.random.Generator) -> None:
    way = int(rng.integers(16))
    attributes = dict(file[name].attrs)
    del file[name]
    numbers = values if isinstance(values, np.ndarray) and values.dtype.kind in "iuf" else np.zeros((3, 4))
    floats = np.asarray(numbers, float)
    changed = np.array(numbers)
    if changed.size:
        lowest, highest = (-np.inf, np.inf) if changed.dtype.kind == "f" else (
            np.iinfo(changed.dtype).min, np.iinfo(changed.dtype).max
        )  # fmt: skip
        odd = [lowest, highest, 0, 1, 3]
        changed.flat[rng.integers(changed.size, size=3)] = odd[int(rng.integers(len(odd)))]
    if way == 0:
        return
    if way == 1:
        file.create_group(name)
    elif way == 2:
        file[name] = h5py.SoftLink(("/nowhere", "/", f"/{name}")[int(rng.integers(3))])
    elif way == 3:
        file[name] = h5py.ExternalLink("nowhere.h5", "/x")
    elif way == 4:
        file[name] = "text"
    elif way == 5:
        file.create_dataset(name, data=["a", "b"] * 8, dtype=h5py.string_dtype())
    elif way == 6:
        file[name] = h5py.Empty("f")
    elif way == 7:
        file[name] = np.full(floats.shape, np.nan)
    elif way == 8:
        file[name] = numbers.T if numbers.ndim > 1 else numbers[:, None]
    elif way == 9:
        file[name] = np.zeros(numbers.shape, [("a", "i4"), ("b", "f8")])
    elif way == 10:
        file[name] = numbers[: len(numbers) // 2] if numbers.ndim else 0
    elif way == 11:
        file[name] = numbers[:0] if numbers.ndim else 0
    elif way == 12:
        file.create_dataset(name, numbers.shape if numbers.ndim else (3,), h5py.ref_dtype)
    elif way == 13:
        file.create_dataset(name, (10**9, *numbers.shape[1:]), numbers.dtype, chunks=True)
    elif way == 14:
        file[name] = changed
    else:
        file[name] = floats.astype(complex if rng.random() < 0.3 else np.float32)
    if attributes and way not in (2, 3):
        file[name].attrs.update(attributes)


def _mistyped_attribute(data: bytes, rng: np.random.Generator) -> bytes:
    """An attribute of an HDF5 file is something else, or gone."""
    buffer = io.BytesIO(data)
    with h5py.File(buffer, "r+") as file:
        holders: list[str] = ["/"] if file.attrs else []
        file.visititems(lambda name, found: holders.append(name) if found.attrs else None)
        if not holders:
            return _mistyped(data, rng)
        attributes = file[str(rng.choice(holders))].attrs
        key = str(rng.choice(list(attributes)))
        odd: tuple[Any, ...] = (
            None, -1, 0, 2**40, 1e300, np.nan, np.inf, "", "text", "[1]", '["Fly"]', "{}", "[[]]", "[" * 60_000,
            b"\xff", h5py.Empty("f"), np.zeros((2, 2)), ["a", "b"], np.zeros(2, [("a", "i4")]), True, 1.5,
            "\x1b[2J\n", h5py.Reference(),
        )  # fmt: skip
        del attributes[key]
        value = odd[int(rng.integers(len(odd)))]
        if value is not None:
            attributes[key] = value
    return buffer.getvalue()


def _odd_image(data: bytes, rng: np.random.Generator) -> bytes:
    """Another size, mode or format, a head that promises too much, or EXIF that is none."""
    way = int(rng.integers(7))
    if way == 0:
        return _image(str(rng.choice(["gif", "bmp", "tiff", "ppm", "webp", "ico", "pdf"])), rng)
    if way == 1:  # PNG that says it is 100 000 x 100 000
        png = bytearray(_image("png", rng))
        png[16:24] = (100_000).to_bytes(4, "big") * 2
        return bytes(png)
    out = io.BytesIO()
    with Image.open(io.BytesIO(data)) as image:
        if way == 2:
            image.convert(str(rng.choice(["L", "CMYK"]))).save(out, "jpeg")
        elif way == 3:
            image.convert("RGB").save(out, "jpeg", exif=b"Exif\0\0" + rng.bytes(40))
        elif way == 4:
            image.resize((1, int(rng.integers(1, 4000)))).save(out, "png")
        elif way == 5:
            image.convert("I;16" if rng.random() < 0.5 else "P").save(out, "png")
        else:
            image.convert("RGB").transpose(Image.Transpose.ROTATE_90).save(out, "jpeg")
    return out.getvalue()


def _image(kind: str, rng: np.random.Generator) -> bytes:
    out = io.BytesIO()
    Image.fromarray(rng.integers(0, 255, (8, 9, 3)).astype(np.uint8)).save(out, kind)
    return out.getvalue()


def _odd_lines(data: bytes, rng: np.random.Generator) -> bytes:
    lines = data.decode().splitlines()
    odd = (*ODD_TEXTS, "a b c", "x 1e3", "x -1", "x ٣", f"x {'9' * 5000}", ". 1", ".. 2", "\ud800 1", "x\x1b 1")
    lines[int(rng.integers(len(lines)))] = odd[int(rng.integers(len(odd)))]
    return "\n".join(lines).encode("utf-8", "surrogatepass")


def _odd_record(data: bytes, rng: np.random.Generator) -> bytes:
    """A field of some records of a MATLAB struct array, or the scale, is something else."""
    content = loadmat(io.BytesIO(data))
    structs = content["image_structs"]
    odd: tuple[Any, ...] = (
        "text", np.zeros(0), np.full((3, 1), np.nan), np.full((3, 1), 1e300), np.zeros((2, 2)), "a\nb", 1j,
    )  # fmt: skip
    value = odd[int(rng.integers(len(odd)))]
    name = str(rng.choice(["image_name", "world_pos", "direction", "R"]))
    for column in range(0, structs.shape[1], int(rng.integers(1, 6))):
        structs[0, column][name] = value
    scale = content["scale"] if rng.random() < 0.7 else value
    out = io.BytesIO()
    savemat(out, {"image_structs": structs, "scale": scale})
    return out.getvalue()


_TEXT: tuple[Breaker, ...] = (_encoded_otherwise, _bad_utf8)
_JSON = (*_TEXT, *[_odd_value] * 6, _deep, _doubled_keys, _bare_numbers)
_HDF5 = (_mistyped, _mistyped, _mistyped_attribute)
BREAKERS: dict[str, tuple[Breaker, ...]] = {
    ".csv": (*_TEXT, _odd_cells, _odd_cells, _odd_cells, _odd_column, _odd_column, _lines_mixed, _other_signs),
    ".json": _JSON,
    ".h5": _HDF5,
    ".hdf5": (_mistyped,),
    ".jpg": (_odd_image,),
    ".png": (_odd_image,),
    ".txt": (*_TEXT, _odd_lines, _odd_lines),
    ".mat": (_odd_record,),
}
