"""YAML from people: plain data, and no key twice."""

import pytest
import yaml

from active_perceiver.utils.yaml_reader import parse_yaml


def test_plain_data_is_read_as_ever():
    text = "limits: {speed: 0.3, turn: 45}\ntopics:\n  image: /camera\n  list: [1, two, null]\n"
    assert parse_yaml(text) == yaml.safe_load(text)


def test_what_is_merged_may_be_replaced():
    assert parse_yaml("a: &x {b: 1, c: 2}\nd:\n  <<: *x\n  b: 3\n")["d"] == {"b": 3, "c": 2}


@pytest.mark.parametrize(
    ("text", "key", "line"),
    [
        ("limits: {speed: 0.3}\nother: 1\nlimits: {turn: 1}\n", "'limits'", 3),
        ("a:\n  b: 1\n  'b': 2\n", "'b'", 3),
        ("1: a\n0x1: b\n", "1", 2),
    ],
)
def test_a_key_that_is_there_twice_is_named_with_its_line(text, key, line):
    with pytest.raises(yaml.YAMLError, match=rf"(?s)key {key} is there twice.*line {line}"):
        parse_yaml(text)


@pytest.mark.parametrize("text", ["!!python/object/apply:os.system ['ls']", "? [1, 2]\n: 3", "a: [", "a: b: c"])
def test_what_is_no_plain_data_is_refused(text):
    with pytest.raises(yaml.YAMLError):
        parse_yaml(text)
