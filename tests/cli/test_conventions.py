"""What holds for every command: examples that are right, --json, and one spelling for one thing."""

import re
import shlex
from collections import defaultdict
from pathlib import Path

import click
import pytest

from roadmend.cli.driver_options import METHOD_NAME, POLICY_NAME
from roadmend.cli.main import cli, main
from roadmend.cli.scenario import FAMILY_NAME

NOTHING_TO_SHOW = {
    "schema",  # prints JSON and nothing else
    "completion",  # prints a script for a shell
    "replay",  # publishes
}
ONE_THING = {  # whatever is of such a type, or stored under such a name, has this spelling
    POLICY_NAME: {"--policy", "--also"},  # the other is whom a training practises on besides
    METHOD_NAME: {"--repair"},
    FAMILY_NAME: {"--family"},
}
ONE_NAME = {
    "as_json": "--json",
    "method": "--repair",
    "methods": "--repair",
    "policy": "--policy",
    "policies": "--policy",
    "families": "--family",
    "out": "--out",
    "workers": "--workers",
    "device": "--device",
    "seed": "--seed",
    "futures": "--futures",
    "embedder": "--embedder",
    "sumocfg": "--sumocfg",
    "settings": {"--set", "--settings"},  # name by name, or the file of a language model's endpoint
}


def walk(command, path=()):
    yield path, command
    if isinstance(command, click.Group):
        context = click.Context(command)
        for name in command.list_commands(context):
            yield from walk(command.get_command(context, name), (*path, name))


@pytest.fixture(scope="module")
def every():
    """Every command and group by its words; loading all of them takes seconds, so that nothing is parametrised by it."""
    return dict(walk(cli))


@pytest.fixture(scope="module")
def commands(every):
    return {path: each for path, each in every.items() if not isinstance(each, click.Group)}


def options(command):
    return [each for each in command.params if isinstance(each, click.Option) and not each.hidden]


def parsed(example):
    """The context of the command that an example calls, with everything in it converted; nothing is run."""
    words = shlex.split(example.split(" > ")[0], comments=True)
    assert words[0] == "roadmend"
    command, context, rest = cli, cli.make_context("roadmend", words[1:2]), words[1:]
    while isinstance(command, click.Group):
        name, command, rest = command.resolve_command(context, rest)
        is_group = isinstance(command, click.Group)
        context = command.make_context(name, rest[:1] if is_group else rest, parent=context)
    return context


def test_there_is_something_to_look_at(commands):
    assert len(commands) > 40
    assert ("sera", "bank", "import") in commands


def test_every_help_has_examples(every, capsys):
    for path, command in every.items():
        assert main([*path, "--help"]) == 0
        page = capsys.readouterr().out
        shown = page.partition("\nExamples:\n")[2]
        assert command.examples, path
        for example in command.examples:
            assert f"  {example}\n" in shown, page


def test_every_example_is_a_command_line_that_is_understood(every, commands):
    for path, command in every.items():
        for example in command.examples:
            if not example.startswith("eval "):
                called = parsed(example).command
                assert called is command or (path not in commands and called in commands.values()), example


def test_an_example_that_is_wrong_would_be_found():
    for wrong in ("roadmend run --scenario", "roadmend evaluate --policy autopilot --out x", "roadmend bag inof x"):
        with pytest.raises(click.UsageError):
            parsed(wrong)


def test_every_command_that_shows_something_shows_it_as_json(commands):
    without = {
        path[-1]
        for path, command in commands.items()
        if [each.help for each in options(command) if each.opts == ["--json"]] != ["Print JSON."]
    }
    assert without == NOTHING_TO_SHOW


def test_one_thing_has_one_spelling(commands):
    for path, command in commands.items():
        for option in options(command):
            for kind, spellings in ONE_THING.items():
                assert option.type is not kind or set(option.opts) <= spellings, (path, option.opts)
            spelling = ONE_NAME.get(option.name, set(option.opts))
            allowed = {spelling} if isinstance(spelling, str) else spelling
            assert set(option.opts) & allowed, (path, option.name, option.opts)


def test_no_option_goes_by_the_plural_of_another(commands):
    names = {name for each in commands.values() for option in options(each) for name in option.opts}
    plurals = {f"{name}s" for name in names} | {f"{name[:-1]}ies" for name in names if name.endswith("y")}
    # One expression of 'bag diff', numbers of scenarios and of egos; --ego is a topic.
    assert names & plurals <= {"--topics", "--scenarios", "--samples", "--egos"}


def test_an_option_that_may_be_repeated_says_so(commands):
    for path, command in commands.items():
        for option in options(command):
            assert not option.multiple or "epeat" in (option.help or ""), (path, option.opts)


def test_one_spelling_has_one_kind_of_value(commands):
    kinds = defaultdict(set)
    for command in commands.values():
        for option in options(command):
            for name in option.opts:
                kinds[name].add(type(option.type).__name__ if not option.is_flag else "flag")
    for name in (
        "--policy",
        "--repair",
        "--family",
        "--seed",
        "--workers",
        "--out",
        "--json",
        "--sumocfg",
        "--futures",
    ):
        # A neural policy is a name or a file, and a corpus knows installed families only: both are looked up later.
        is_name = name in {"--policy", "--family"}
        assert len(kinds[name] - ({"StringParamType", "ModelType"} if is_name else set())) == 1, (name, kinds[name])


def test_what_needs_a_policy_for_futures_takes_it(commands):
    for path, command in commands.items():
        names = {name for option in options(command) for name in option.opts}
        assert "--futures" not in names or "--policy" in names, path


def test_the_page_names_every_command_that_goes_on_after_an_interrupt(commands):
    page = (Path(__file__).parents[2] / "src" / "doc" / "command-line.md").read_text(encoding="utf-8")
    told = page.partition("## Ctrl-C, and how to go on\n")[2].partition(" keep what is finished")[0]
    resuming = {" ".join(path) for path, each in commands.items() if getattr(each, "resumes", None) is not None}
    assert {" ".join(name.split()) for name in re.findall(r"`([^`]+)`", told)} == resuming
