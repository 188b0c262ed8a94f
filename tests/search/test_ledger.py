"""A search on disk: what an interruption leaves, and what is refused."""

import json

import pytest

from roadmend.core.errors import InputError
from roadmend.core.outcome import Blame
from roadmend.search.evaluation import Evaluation
from roadmend.search.ledger import Entry, Ledger, Reproduction

SETTINGS = {"family": "S3", "seed": 1}


def entry(index):
    evaluation = Evaluation(
        "GOAL", "route completed", "abc", -1.0 / 3.0, None if index else 0.1, Blame.SIDE, (0.1, 2.0 / 3.0)
    )
    return Entry(index, f"point-{index}", evaluation, Reproduction("a", "b", "c", "d") if index == 1 else None)


@pytest.fixture
def folder(tmp_path):
    with Ledger(tmp_path / "search", SETTINGS) as ledger:
        for index in range(3):
            ledger.add(entry(index))
    return tmp_path / "search"


def refusal(folder, settings=SETTINGS):
    with pytest.raises(InputError) as caught:
        Ledger(folder, settings)
    assert "\n" not in str(caught.value)
    return str(caught.value)


def test_entries_come_back_to_the_bit(folder):
    with Ledger(folder, SETTINGS) as ledger:
        assert ledger.entries == [entry(index) for index in range(3)]


def test_every_line_is_json(folder):
    lines = [json.loads(line) for line in (folder / "ledger.jsonl").read_text().splitlines()]
    assert [line["index"] for line in lines] == [0, 1, 2]
    assert json.loads((folder / "settings.json").read_text()) == {"format": "roadmend-search/2", **SETTINGS}
    assert sorted(path.name for path in folder.iterdir()) == ["ledger.jsonl", "settings.json"]


def test_a_line_cut_short_is_dropped(folder):
    path = folder / "ledger.jsonl"
    whole = path.read_bytes()
    for cut in range(1, len(entry(2).dump()) + 1):
        path.write_bytes(whole[:-cut])
        with Ledger(folder, SETTINGS) as ledger:
            assert len(ledger.entries) == 2
            ledger.add(entry(2))
        assert path.read_bytes() == whole


@pytest.mark.parametrize("settings", [{**SETTINGS, "seed": 2}, {"family": "S3"}, {**SETTINGS, "policy": "modular"}])
def test_other_settings_are_refused(folder, settings):
    assert "choose another folder or the same settings" in refusal(folder, settings)


def test_a_folder_with_something_else_is_left_alone(tmp_path):
    (tmp_path / "thesis.tex").write_text("do not touch")
    assert "is not empty" in refusal(tmp_path)
    assert [path.name for path in tmp_path.iterdir()] == ["thesis.tex"]


def test_a_folder_in_use_is_refused(folder):
    with Ledger(folder, SETTINGS):
        assert "another search is at work here" in refusal(folder)


@pytest.mark.parametrize("line", ["{}", "[]", "7", "nonsense", '{"index": 1, "parameters": "x", "features": 3}'])
def test_a_damaged_line_is_named(folder, line):
    with (folder / "ledger.jsonl").open("a") as file:
        file.write(line + "\n")
    assert "line 4: is damaged" in refusal(folder)


def test_a_line_out_of_order_is_named(folder):
    with (folder / "ledger.jsonl").open("a") as file:
        file.write(entry(7).dump())
    assert "line 4: is out of order" in refusal(folder)


@pytest.mark.parametrize("text", ["", "[]", "nonsense"])
def test_damaged_settings_are_named(folder, text):
    (folder / "settings.json").write_text(text)
    assert "is damaged" in refusal(folder)


def test_a_file_in_place_of_the_folder_is_refused(tmp_path):
    (tmp_path / "file").write_text("")
    assert "cannot be written" in refusal(tmp_path / "file")
