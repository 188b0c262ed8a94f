"""``roadmend demo``: what it says at its end, without driving."""

import shlex
from pathlib import Path

import pytest

from roadmend.cli import demo
from roadmend.cli.command import called_as
from roadmend.cli.main import main
from roadmend.nodes.run_result import RunResult
from tests.measures.results import episode


@pytest.mark.parametrize("folder", ["bags", "my bags [old]", "a" * 240, "[/bold]"])
def test_the_command_for_a_picture_can_be_pasted(folder, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)

    def drive(options):
        repaired = options.method != "none"
        drove = episode("GOAL" if repaired else "COLLISION", interventions=13 if repaired else 0, change=2.0)
        return RunResult(drove, "lockstep", 0, 0, 9.0, str(options.bags / options.name))

    monkeypatch.setattr(demo, "run_with_status", drive)
    assert main(["demo", "--out", folder]) == 0
    (line,) = (line for line in capsys.readouterr().out.splitlines() if "bag plot" in line)
    *words, bag = shlex.split(line.removeprefix("A picture of the moment: "))
    assert words == [*shlex.split(called_as()), "bag", "plot"]
    assert Path(bag).parent == Path(folder)
