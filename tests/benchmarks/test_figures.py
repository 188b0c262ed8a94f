import json

import pytest

from harness.figures import Figures
from roadmend.core.errors import InputError
from roadmend.reports.result_files import provenance

CONTENT = {"provenance": provenance("./roadmend bench speed"), "speed": 3.5}
FIGURES = Figures("speed", "How fast", CONTENT, [["what", "figure"], ["speed", "3.5 m/s"]])


def test_a_table_for_people(capsys):
    FIGURES.publish(None, as_json=False)
    lines = capsys.readouterr().out.split("\n")
    assert lines[0].split() == ["what", "figure"]
    assert lines[1].split() == ["speed", "3.5", "m/s"]


def test_json_for_programs_and_two_files(tmp_path, capsys):
    FIGURES.publish(tmp_path, as_json=True)
    assert json.loads(capsys.readouterr().out) == CONTENT
    assert json.loads((tmp_path / "speed.json").read_text()) == CONTENT
    text = (tmp_path / "speed.md").read_text()
    assert text.startswith("# How fast\n\n| what | figure |\n| --- | --- |\n| speed | 3.5 m/s |\n")
    assert "Made by `./roadmend bench speed` at commit " in text


def test_a_folder_that_cannot_be_written(tmp_path):
    (tmp_path / "file").write_text("mine")
    with pytest.raises(InputError, match="cannot be written"):
        FIGURES.publish(tmp_path / "file", as_json=False)
