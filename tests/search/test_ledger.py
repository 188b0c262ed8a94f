"""A search on disk: what comes back, and what is refused; how lines are kept is tests/core/test_journal.py's."""

import json
from dataclasses import asdict

import pytest

from roadmend.core.errors import InputError
from roadmend.core.outcome import Blame
from roadmend.search.evaluation import Evaluation
from roadmend.search.ledger import FORMAT, Ledger, LedgerEntry, RerunCommand
from tests.measures.results import episode

SETTINGS = {"family": "S3", "seed": 1}


def entry(index):
    result = None if index == 2 else episode("COLLISION", change=0.1, digest="abc", blame=Blame.SIDE)
    evaluation = Evaluation(result, "" if result else "broken", -1.0 / 3.0, (0.1, 2.0 / 3.0))
    return LedgerEntry(index, f"point-{index}", evaluation, RerunCommand("a", "b", "c", "d") if index == 1 else None)


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
    head, *lines = (json.loads(line) for line in (folder / "ledger.jsonl").read_text().splitlines())
    assert head == {"format": FORMAT, **SETTINGS}
    assert [line["index"] for line in lines] == [0, 1, 2]
    assert [path.name for path in folder.iterdir()] == ["ledger.jsonl"]


def test_other_settings_are_refused(folder):
    assert "holds work with seed 1, not 2" in refusal(folder, {**SETTINGS, "seed": 2})


def test_a_folder_with_something_else_is_left_alone(tmp_path):
    (tmp_path / "thesis.tex").write_text("do not touch")
    assert "is not empty" in refusal(tmp_path)
    assert [path.name for path in tmp_path.iterdir()] == ["thesis.tex"]


def test_a_search_of_an_earlier_format_is_refused(tmp_path):
    (tmp_path / "settings.json").write_text(json.dumps({"format": "roadmend-search/1", **SETTINGS}))
    assert "is not empty" in refusal(tmp_path)
    (tmp_path / "ledger.jsonl").write_text(json.dumps({"parameters": "abc", "index": 0}) + "\n")
    assert f"is not of the format {FORMAT}" in refusal(tmp_path)


@pytest.mark.parametrize("line", ['{"key": "a"}', '{"key": "a", "index": 3, "features": 3}'])
def test_a_damaged_line_is_named(folder, line):
    with (folder / "ledger.jsonl").open("a") as file:
        file.write(line + "\n")
    assert "line 5: is damaged" in refusal(folder)
    with pytest.raises(InputError, match="is damaged"):  # and the folder is free again
        Ledger(folder, SETTINGS)


def test_a_line_out_of_order_is_named(folder):
    with (folder / "ledger.jsonl").open("a") as file:
        file.write(json.dumps(asdict(entry(7))) + "\n")
    assert "line 5: is out of order" in refusal(folder)
