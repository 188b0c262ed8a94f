"""The group ``roadmend bench``, as the script at the root starts it."""

import subprocess
import sys
from pathlib import Path

import click
import pytest

import bench


def test_every_entry_leads_to_a_command():
    context = click.Context(bench.bench)
    for name in bench.bench.list_commands(context):
        assert isinstance(bench.bench.get_command(context, name), click.Command)


def test_an_unknown_benchmark_is_one_line(capsys):
    assert bench.main(["sleep"]) == 2
    assert capsys.readouterr().err == "roadmend: No such command 'sleep'. (see 'roadmend bench --help')\n"


@pytest.mark.parametrize("arguments", [["--help"], ["loop", "-h"]])
def test_the_file_runs_from_any_folder(arguments, tmp_path):
    command = [sys.executable, str(Path(bench.__file__)), *arguments]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=True)
    assert done.stdout.startswith("Usage: roadmend bench")
