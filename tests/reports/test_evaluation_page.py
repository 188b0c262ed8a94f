"""The page of an evaluation: all that is told is on it, as text."""

from xml.etree import ElementTree as ET

import pytest

from roadmend.core.errors import InputError
from roadmend.reports.evaluation_page import write_page

MADE = {
    "command": "python x.py",
    "commit": "0" * 40,
    "dirty": False,
    "machine": {"processor": "p", "cores": 2, "python": "3"},
}
EPISODE = {
    "policy": "mine:A<b>",
    "method": "rss",
    "scenario": "S3-1",
    "outcome": "GOAL",
    "text": "route completed",
    "duration": 12.345,
    "min_distance": None,
    "dose": 0.5,
}


def test_it_shows_table_meanings_episodes_and_faults(tmp_path):
    rows = [["policy", "goal"], ["mine:A<b>", "50.0"]]
    path = write_page(tmp_path / "new", "Title", rows, ["goal: reached"], [EPISODE], ["S3-2: failed"], MADE)
    assert path == tmp_path / "new" / "evaluation.html"
    tree = ET.fromstring(path.read_text().replace("<!DOCTYPE html>", "").replace('<meta charset="utf-8">', "").replace('<meta name="viewport" content="width=device-width, initial-scale=1">', ""))  # fmt: skip
    measures, episodes = ([[cell.text for cell in row] for row in table.iter("tr")] for table in tree.iter("table"))
    assert measures == rows
    assert episodes[1] == ["mine:A<b>", "rss", "S3-1", "GOAL", "route completed", "12.35", "\N{EN DASH}", "0.50"]
    assert [item.text for item in tree.iter("li")] == ["S3-2: failed", "goal: reached"]
    assert "python x.py" in tree.find(".//footer").text


def test_a_place_that_cannot_be_written_is_named(tmp_path):
    (tmp_path / "file").write_text("")
    with pytest.raises(InputError):
        write_page(tmp_path / "file", "T", [["a"]], [], [], [], MADE)
