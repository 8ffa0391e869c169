"""JSON from anybody: what `json` reads, unless a key is there twice or it is nested or long enough to do harm."""

import json

import pytest

from active_perceiver.utils.json_reader import MAX_DIGITS, MAX_NESTING, DuplicateKeyError, parse_json

SOUND = {
    "images": [{"id": 2**63, "name": 'a "quoted" \\ name [{', "size": [-1.5e-300, 0, True, None, float("inf")]}],
    "": {"ä\u2028": [[], {}, "\ud800"]},
    "long": 0.12345678901234567890123456789012345678901234567890,
}


@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "utf-16", "utf-32-le"])
@pytest.mark.parametrize("ascii_only", [True, False])
def test_what_is_sound_is_read_as_ever(encoding, ascii_only):
    text = json.dumps(SOUND, ensure_ascii=ascii_only)
    assert parse_json(text.encode(encoding, "surrogatepass")) == SOUND
    assert parse_json(text) == SOUND
    digits = "0." + "1" * 100 + "e-0005"
    assert parse_json(f"[{digits}, {digits}]") == [float(digits)] * 2


@pytest.mark.parametrize(
    ("text", "key"),
    [('{"limits": 1, "other": 2, "limits": 1}', "limits"), ('[{"a": {"b": 1, "\\u0062": 2}}]', "b")],
)
def test_a_key_that_is_there_twice_is_named(text, key):
    with pytest.raises(DuplicateKeyError, match=f"key '{key}' is there twice"):
        parse_json(text)


def test_the_same_key_in_two_objects_is_fine():
    assert parse_json('[{"a": {"a": 1}}, {"a": 2}]') == [{"a": {"a": 1}}, {"a": 2}]


@pytest.mark.parametrize("opening", ["[", '{"a":', '[{"a":'])
def test_nesting_has_an_end(opening):
    closing = opening.translate(str.maketrans("[{", "]}", '"a:'))[::-1]
    deepest = MAX_NESTING // len(closing)
    assert parse_json(opening * deepest + "1" + closing * deepest)
    for text in (opening * (deepest + 1) + "1" + closing * (deepest + 1), opening * 200_000):
        with pytest.raises(ValueError, match=f"deep, more than {MAX_NESTING}"):
            parse_json(text)


def test_whole_numbers_have_an_end():
    assert parse_json("9" * MAX_DIGITS) == 10**MAX_DIGITS - 1
    for text in ("9" * (MAX_DIGITS + 1), '{"a": [1, -' + "9" * 5000 + "]}"):
        with pytest.raises(ValueError, match=r"a whole number of \d+ digits"):
            parse_json(text)
    assert parse_json('"' + "9" * 5000 + '"')


@pytest.mark.parametrize("text", ["", "{", '"' * 3, '"\\', "[1,]", "nonsense", "]" * 100, '"' + '\\"' * 300_000])
def test_what_is_no_json_is_an_error_at_once(text):
    with pytest.raises(ValueError):  # noqa: PT011 - as `json` says it
        parse_json(text)
    with pytest.raises(UnicodeDecodeError):
        parse_json(b'"\xff\xff"')
