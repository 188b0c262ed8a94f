"""Commands as people expect them: help without arguments, the nearest name, and word on how to go on after Ctrl-C."""

import shlex

import click
import pytest

from roadmend.cli.command import ExampleCommand, called_as
from roadmend.cli.main import main, run_group
from roadmend.core.errors import RoadmendError
from roadmend.core.interrupt import InterruptedWorkError


@pytest.fixture
def group():
    """Commands that are interrupted, each otherwise."""

    @click.group()
    def root():
        """Root."""

    def add(name, resumes, error):
        @root.command(name, cls=ExampleCommand, examples=[f"roadmend {name}"], resumes=resumes)
        @click.option("--resume", is_flag=True)
        @click.option("--out", default="")
        def work(resume, out):
            """Work."""
            raise error

    add("goes-on", "", KeyboardInterrupt())
    add("wants-a-word", "--resume", KeyboardInterrupt())
    add("keeps-nothing", None, KeyboardInterrupt())
    add("asks", "", click.Abort())
    add("stops-by-itself", None, InterruptedWorkError())
    add("says-so", "", RoadmendError("interrupted"))
    return root


@pytest.mark.parametrize(
    ("words", "way_on"),
    [
        (["goes-on"], "roadmend goes-on"),
        (["goes-on", "--out", "a folder"], "roadmend goes-on --out 'a folder'"),
        (["wants-a-word", "--out", "x"], "roadmend wants-a-word --out x --resume"),
        (["wants-a-word", "--resume"], "roadmend wants-a-word --resume"),
        (["asks"], "roadmend asks"),
    ],
)
def test_an_interrupt_names_the_command_that_goes_on(group, words, way_on, capsys):
    assert run_group(group, "roadmend", words) == 130
    told = capsys.readouterr().err.strip()
    assert told == f"roadmend: interrupted; what is finished is kept, go on with: {way_on}"
    assert shlex.split(told.partition("go on with: ")[2])[1:][: len(words)] == words


@pytest.mark.parametrize("word", ["keeps-nothing", "stops-by-itself"])
def test_where_nothing_is_kept_nothing_is_promised(group, word, capsys):
    assert run_group(group, "roadmend", [word]) == 130
    assert capsys.readouterr().err.strip() == "roadmend: interrupted"


def test_the_sentence_of_an_error_decides_nothing(group):
    assert run_group(group, "roadmend", ["says-so"]) == 1


def test_the_command_is_called_as_the_user_has_called_it(monkeypatch, capsys):
    monkeypatch.setenv("ROADMEND_CALLED_AS", "../my clone/roadmend")
    assert called_as() == "'../my clone/roadmend'"
    assert main(["completion", "--help"]) == 0
    page = capsys.readouterr().out
    assert page.startswith("Usage: '../my clone/roadmend' completion ")
    assert "  '../my clone/roadmend' completion fish > ~/.config/fish/completions/roadmend.fish\n" in page
    assert main(["evalute"]) == 2
    assert "(see ''../my clone/roadmend' --help')" in capsys.readouterr().err


def test_a_name_on_the_path_is_called_by_its_name(monkeypatch, tmp_path):
    (tmp_path / "roadmend").write_text("#!/bin/sh\n")
    (tmp_path / "roadmend").chmod(0o755)
    monkeypatch.setenv("PATH", str(tmp_path))
    monkeypatch.setenv("ROADMEND_CALLED_AS", str(tmp_path / "roadmend"))
    assert called_as() == "roadmend"
    monkeypatch.setenv("ROADMEND_CALLED_AS", "./roadmend")
    assert called_as() == "./roadmend"


@pytest.mark.parametrize("words", [[], ["bag"], ["train"], ["safe"], ["sera"], ["corpus"]])
def test_a_group_alone_prints_its_help(words, capsys):
    assert main(words) == 0
    printed = capsys.readouterr()
    assert printed.out.startswith(f"Usage: {' '.join(['roadmend', *words])} ")
    assert "\nCommands:\n" in printed.out
    assert printed.err == ""


@pytest.mark.parametrize(
    ("words", "meant"),
    [
        (["evalute"], "'evaluate'"),
        (["tset"], "'test'"),
        (["setup"], "'set-up'"),
        (["bag", "inof"], "'info'"),
        (["corpus", "verfy"], "'verify'"),
        (["evaluate", "--polcy", "modular"], "--policy"),
        (["run", "--scenari", "x.yaml"], "--scenario"),
        (["run", "--scenario", "x.yaml", "--repar=rss"], "--repair"),
        (["replay", "bags/x", "--lop"], "--loop"),
    ],
)
def test_what_is_not_there_gets_the_nearest_name(words, meant, capsys):
    assert main(words) == 2
    lines = capsys.readouterr().err.splitlines()
    assert len(lines) == 1
    assert "Did you mean" in lines[0]
    assert meant in lines[0]
    assert "--help'" in lines[0]


def test_what_is_like_nothing_gets_no_name(capsys):
    assert main(["xyzzy"]) == 2
    assert "Did you mean" not in capsys.readouterr().err
