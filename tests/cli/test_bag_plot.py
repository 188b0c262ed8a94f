"""``roadmend bag plot`` on a bag that the project ships."""

from pathlib import Path

import pytest

from roadmend.cli.main import main

BAG = Path(__file__).parents[2] / "bags" / "samples" / "collision"


@pytest.mark.parametrize("name", ["a.png", "a.html"])
def test_a_bag_is_drawn_at_the_moment_asked_for(tmp_path, capsys, name):
    assert main(["bag", "plot", str(BAG), "--at", "12.01", "--out", str(tmp_path / name)]) == 0
    assert capsys.readouterr().out == f"{tmp_path / name}: 12.00 s\n"
    assert (tmp_path / name).stat().st_size > 20_000


@pytest.mark.parametrize(
    ("arguments", "complaint"),
    [
        ([BAG / "none"], "there is no such bag"),
        ([BAG, "--at", "900"], "outside the recording"),
        ([BAG, "--out", "a.gif"], ".gif is no format"),
        ([BAG, "--at", "-1"], "--at"),
        ([BAG, "--out", BAG / "metadata.yaml" / "a.png"], "cannot be written"),
    ],
)
def test_what_cannot_be_drawn_is_one_line(tmp_path, monkeypatch, capsys, arguments, complaint):
    monkeypatch.chdir(tmp_path)
    assert main(["bag", "plot", *map(str, arguments)]) == 2
    said = capsys.readouterr()
    assert len(said.err.splitlines()) == 1
    assert complaint in said.err
    assert said.out == ""
    assert not list(tmp_path.iterdir())
