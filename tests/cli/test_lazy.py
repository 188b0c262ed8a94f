"""Groups that load a command only when it is called."""

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
