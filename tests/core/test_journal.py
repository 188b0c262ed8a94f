"""Kept work: what an interruption leaves, what is refused, and that nothing stale is taken for fresh."""

import json
import os

import pytest

from roadmend.core.errors import InputError
from roadmend.core.journal import InUseError, Journal, entry_key, file_of

FORM = "roadmend-test/1"
SETTINGS = {"family": "S3", "seed": 1}
KEYS = [entry_key(["roadmend.core.errors"], number) for number in range(4)]


def entry(number):
    return {"value": 0.1 + 0.2 * number, "none": None, "text": 'ü "\n'}


@pytest.fixture
def path(tmp_path):
    with Journal(tmp_path / "work" / "kept.jsonl", FORM, SETTINGS) as journal:
        for number in range(3):
            journal.add(KEYS[number], entry(number))
    return tmp_path / "work" / "kept.jsonl"


def refusal(path, form=FORM, settings=SETTINGS, **options):
    with pytest.raises(InputError) as caught:
        Journal(path, form, settings, **options)
    assert "\n" not in str(caught.value)
    return str(caught.value)


def test_entries_come_back_to_the_bit_and_in_order(path):
    with Journal(path, FORM, SETTINGS) as journal:
        assert [*journal] == [(KEYS[number], entry(number)) for number in range(3)]
        assert len(journal) == 3
        assert journal.get(KEYS[1]) == entry(1)
        assert journal.get(KEYS[3]) is None
        journal.add(KEYS[1], entry(7))
    with Journal(path, FORM, SETTINGS) as journal:
        assert journal.get(KEYS[1]) == entry(7)


def test_every_line_is_json_and_the_first_says_what_the_file_is(path):
    lines = [json.loads(line) for line in path.read_text().splitlines()]
    assert lines == [{"format": FORM, **SETTINGS}, *({"key": KEYS[number], **entry(number)} for number in range(3))]


def test_a_line_cut_short_anywhere_is_dropped(path):
    whole = path.read_bytes()
    last = len(whole.splitlines(keepends=True)[-1])
    for cut in range(1, last + 1):
        path.write_bytes(whole[:-cut])
        with Journal(path, FORM, SETTINGS) as journal:
            assert len(journal) == 2
            journal.add(KEYS[2], entry(2))
        assert path.read_bytes() == whole
    path.write_bytes(whole[:5])  # not even the first line is whole
    with Journal(path, FORM, SETTINGS) as journal:
        assert len(journal) == 0


def test_one_process_at_a_time(path):
    with Journal(path, FORM, SETTINGS), pytest.raises(InUseError, match="another process is at work here"):
        Journal(path, FORM, SETTINGS)


@pytest.mark.parametrize("settings", [{**SETTINGS, "seed": 2}, {"family": "S3"}, {**SETTINGS, "policy": "modular"}])
def test_other_settings_are_refused(path, settings):
    assert "choose another folder or the same settings" in refusal(path, settings=settings)


def test_other_code_and_other_formats_are_refused(path):
    assert "is not of the format other/1" in refusal(path, "other/1")
    new = path.with_name("new.jsonl")
    with Journal(new, FORM, {"code": "abc"}):
        pass
    assert "holds work of other code, or of another model" in refusal(new, settings={"code": "abd"})


@pytest.mark.parametrize(
    "text",
    [
        '{"run": 1, "score": 0.93}',
        '{"run": 1}\n{"run": 2}\n{"run": 3}',
        '{"format": "other/1"}\n{"key": "a"}\n{"key"',
        '{"format": "roadmend-test/1", "family": "S4"',
        "a,b\n1,2\n3,4",
        "x",
    ],
)
def test_a_file_of_somebody_else_stays_as_it_is_to_the_last_letter(path, text):
    path.write_text(text)
    refusal(path)
    assert path.read_text() == text


def test_a_damaged_file_keeps_its_last_line(path):
    with path.open("a") as file:
        file.write("nonsense\n{")
    before = path.read_bytes()
    assert "line 5: is damaged" in refusal(path)
    assert path.read_bytes() == before


@pytest.mark.parametrize("line", ["{}", "[]", "7", "nonsense", '{"kex": "a"}', '{"key": ["a"]}'])
def test_a_damaged_line_is_named(path, line):
    with path.open("a") as file:
        file.write(line + "\n")
    assert "line 5: is damaged" in refusal(path)


@pytest.mark.parametrize("line", ["", "[]", "7", "nonsense"])
def test_a_damaged_head_is_named(path, line):
    path.write_text(line + "\n")
    assert "line 1: is damaged" in refusal(path)


def test_a_folder_with_something_else_is_left_alone(tmp_path):
    (tmp_path / "thesis.tex").write_text("do not touch")
    assert "is not empty and holds no kept.jsonl" in refusal(tmp_path / "kept.jsonl", owns_folder=True)
    assert [path.name for path in tmp_path.iterdir()] == ["thesis.tex"]
    assert "cannot be written" in refusal(tmp_path / "thesis.tex" / "kept.jsonl")


def test_a_full_disk_is_said_in_one_line():
    with Journal.__new__(Journal) as journal:
        journal.path, journal._entries = "full", {}
        journal._file = os.fdopen(os.open("/dev/full", os.O_WRONLY), "wb", buffering=0)
        with pytest.raises(InputError, match="full: cannot be written \\(No space left on device\\); make room"):
            journal.add(KEYS[0], {})
        assert journal.get(KEYS[0]) is None


def test_a_key_says_code_and_inputs():
    code = ["roadmend.core.errors"]
    keys = [entry_key(code), entry_key(code, "a", 1), entry_key(code, ["a", 1]), entry_key(["roadmend.core.scene"])]
    assert len({*keys}) == 4
    assert entry_key(code, {"b": 1, "a": 2}) == entry_key(code, {"a": 2, "b": 1})
    with pytest.raises(TypeError):
        entry_key(code, object())  # its text would be its place in memory


def test_a_file_is_named_after_its_key(tmp_path):
    places = {file_of(tmp_path, key, ".npz") for key in KEYS}
    assert len(places) == len(KEYS)
    assert all(place.parent == tmp_path and place.suffix == ".npz" for place in places)
