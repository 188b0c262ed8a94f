"""Every option with a range, swept from below its least to above its greatest value: refused in a line, code 2."""

import os
import runpy

import click
import pytest
from click.testing import CliRunner

from roadmend.cli import options
from roadmend.cli.main import cli, main


def commands(group, path=()):
    """Words and command of every command."""
    context = click.Context(group)
    for name in group.list_commands(context):
        command = group.get_command(context, name)
        if isinstance(command, click.Group):
            yield from commands(command, (*path, name))
        else:
            yield (*path, name), command


def beyond(kind):
    """Texts that are outside a range, or no number."""
    texts = ["nan", "-nan", "", "x", "1,5", "0x10", "1e400", "9" * 400]
    texts += ["-inf"] if kind.min is not None else []
    texts += ["inf"] if kind.max is not None else []
    if isinstance(kind, click.IntRange):
        texts += ["0.5", "1e3", "inf", "-inf"]
    if kind.min is not None:
        texts.append(str(kind.min if kind.min_open else kind.min - 1))
    if kind.max is not None:
        texts.append(str(kind.max if kind.max_open else kind.max + 1))
    if kind.max is None:
        texts = [text for text in texts if not (isinstance(kind, click.IntRange) and text == "9" * 400)]
    return sorted({*texts})


RANGED = [
    (path, option)
    for path, command in commands(cli)
    for option in command.params
    if isinstance(option, click.Option) and isinstance(option.type, click.IntRange | click.FloatRange)
]


@pytest.mark.parametrize(("cores", "workers"), [(2, 2), (256, 256), (512, 256)])
def test_there_are_as_many_workers_as_cores_and_never_more_than_can_be(cores, workers, monkeypatch):
    monkeypatch.setattr(os, "cpu_count", lambda: 512)
    monkeypatch.setattr(os, "sched_getaffinity", lambda _: {*range(cores)})

    @click.command()
    @runpy.run_path(options.__file__)["WORKERS"]
    def work(workers):
        click.echo(workers)

    result = CliRunner().invoke(work, [])
    assert (result.exit_code, result.output) == (0, f"{workers}\n")


def test_there_are_such_options():
    assert len(RANGED) > 40


@pytest.mark.parametrize(
    ("path", "option"), RANGED, ids=lambda part: " ".join(part) if isinstance(part, tuple) else part.name
)
def test_what_is_outside_the_range_is_refused_in_a_line(path, option, capsys, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    spelling = max(option.opts, key=len)
    for text in beyond(option.type):
        code = main([*path, f"{spelling}={text}"])
        printed = capsys.readouterr()
        assert code == 2, (text, printed)
        assert len(printed.err.splitlines()) == 1, (text, printed.err)
        assert spelling in printed.err or f"{text!r}" in printed.err, (text, printed.err)
        assert "Traceback" not in printed.err
    assert [*tmp_path.iterdir()] == []
