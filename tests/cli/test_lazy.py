"""Groups that load a command only when it is called."""

import sys

import click
import pytest
from click.testing import CliRunner

from roadmend.cli import main
from roadmend.cli.lazy import LazyGroup

TABLE = {"there": ("roadmend.cli.scenario", "schema", "Is there."), "gone": ("roadmend.no_such_module", "x", "Is not.")}


@pytest.fixture
def group():
    @click.group(cls=LazyGroup, table=TABLE, also=[("more", "Not of this group.")])
    def root():
        """Root."""

    return root


def test_help_loads_no_command(group):
    done = CliRunner().invoke(group, ["--help"])
    assert done.exit_code == 0
    for line in ("there  Is there.", "gone   Is not.", "more   Not of this group."):
        assert line in done.output


def test_a_command_is_loaded_when_it_is_called(group):
    assert CliRunner().invoke(group, ["there", "--help"]).exit_code == 0
    assert isinstance(CliRunner().invoke(group, ["gone"]).exception, ModuleNotFoundError)


@pytest.mark.parametrize("name", ["missing", "more"])
def test_what_is_not_in_the_table_is_no_command(group, name):
    assert "No such command" in CliRunner().invoke(group, [name]).output


@pytest.mark.parametrize("group", [main.cli, main.bag, main.safe, main.sera, main.train])
def test_every_entry_of_a_group_leads_to_a_command(group):
    context = click.Context(group)
    for name in group.list_commands(context):
        assert isinstance(group.get_command(context, name), click.Command)


def test_the_help_of_a_command_whose_extra_is_missing_says_what_it_does_and_how_to_get_the_rest(monkeypatch, capsys):
    for module in ("roadmend.cli.bag_plot", "roadmend.reports.bag_picture"):
        monkeypatch.delitem(sys.modules, module, raising=False)
    monkeypatch.setitem(sys.modules, "matplotlib", None)
    for name in [*sys.modules]:
        if name.startswith(("matplotlib.", "roadmend.reports.")):
            monkeypatch.delitem(sys.modules, name)
    for word in ("--help", "-h"):
        assert main.main(["bag", "plot", word]) == 0
        told = " ".join(capsys.readouterr().out.split())
        assert "Draw its time line, with the scene at one moment." in told
        assert "./roadmend set-up reports" in told
    assert main.main(["bag", "plot", "some-bag", "--at", "3"]) == 2
    assert capsys.readouterr().err.startswith("roadmend: matplotlib: needed here and not installed; install it with: ")
