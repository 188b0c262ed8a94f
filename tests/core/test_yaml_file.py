"""YAML files: what is refused, and what the one line says."""

import os

import pytest

from roadmend.core.bounds import SETTINGS
from roadmend.core.errors import InputError
from roadmend.core.yaml_file import parse_yaml, read_fields, read_yaml


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("a: 1\nb: [1, 2\nc: }", r"text: broken YAML at line 3: .+; mend the line"),
        ("a: 1\nb: 2\na: 3", r"text: broken YAML at line 3: field a is there twice; mend the line"),
        ("a: {b: 1, b: 1}", r"text: broken YAML at line 1: field b is there twice; mend the line"),
        ("a: !!python/object:os.system {}", r"text: broken YAML at line 1: could not determine a constructor"),
        (b"\x00\xff", r"text: broken YAML"),
        ("a: 2026-99-99", r"text: broken YAML: month must be in 1\.\.12"),
        ("[" * 5000, r"text: broken YAML"),
    ],
)
def test_what_is_broken_is_refused_with_its_line(text, said):
    with pytest.raises(InputError, match=said) as caught:
        parse_yaml(text, "text")
    assert "\n" not in str(caught.value)


def test_keys_that_only_look_alike_and_merged_ones_are_no_repetition():
    assert parse_yaml('1: a\n"1": b', "text") == {1: "a", "1": "b"}
    assert parse_yaml("a: &a {x: 1}\nb: {<<: *a, x: 2}", "text")["b"] == {"x": 2}


def test_a_file_that_cannot_be_read_is_refused(tmp_path, monkeypatch):
    with pytest.raises(InputError, match=r"gone\.yaml: no such file; write one"):
        read_yaml(tmp_path / "gone.yaml", "write one")
    with pytest.raises(InputError, match=r"cannot be read \(Is a directory\); write one"):
        read_yaml(tmp_path, "write one")
    path = tmp_path / "some.yaml"
    path.write_bytes(b"\xff\xfe\x00\x01")
    with pytest.raises(InputError, match=r"cannot be read \(.+\); give a readable UTF-8 text file"):
        read_yaml(path, "write one")
    os.truncate(path, SETTINGS.size + 1)
    with pytest.raises(InputError, match="is 16 MB large, at most 16 are read"):
        read_yaml(path, "write one")


@pytest.mark.parametrize(("text", "fields"), [("", {}), ("# nothing", {}), ("a: 1", {"a": 1})])
def test_fields(tmp_path, text, fields):
    path = tmp_path / "some.yaml"
    path.write_text(text)
    assert read_fields(path, "mend") == fields


@pytest.mark.parametrize("text", ["[1, 2]", "word", "1: 2"])
def test_what_has_no_fields_is_refused(tmp_path, text):
    path = tmp_path / "some.yaml"
    path.write_text(text)
    with pytest.raises(InputError, match=r"some\.yaml: holds no fields; see elsewhere"):
        read_fields(path, "see elsewhere")
