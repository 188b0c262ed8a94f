"""``roadmend run``: what its options make of a run, without starting one."""

from types import SimpleNamespace

import pytest

from roadmend.cli import run
from roadmend.cli.main import main
from roadmend.world.families import sample_scenario
from roadmend.world.scenario_file import save_scenario


@pytest.fixture
def options(tmp_path, monkeypatch):
    """The options of the run that a command would start; None where it is refused."""
    started = []

    def start(options):
        started.append(options)
        return SimpleNamespace(policy_error="", method_error="", recording_error="")

    monkeypatch.setattr(run, "run_with_status", start)
    monkeypatch.setattr(run, "show_results", lambda *_: None)
    path = tmp_path / "s.yaml"
    save_scenario(sample_scenario("S3", 7), path)

    def of(*arguments):
        code = main(["run", "--scenario", str(path), *arguments])
        return started.pop() if code == 0 else SimpleNamespace(code=code)

    return of


@pytest.mark.parametrize(
    ("arguments", "port"),
    [
        ([], None),
        (["--foxglove"], 8765),
        (["--foxglove", "9000"], 9000),
        (["--foxglove", "--repair", "rule"], 8765),
        (["--foxglove", "--ros-args", "-p", "rate:=2.0"], 8765),
    ],
)
def test_the_live_server_is_there_when_asked_for(options, arguments, port):
    assert options(*arguments).foxglove == port


@pytest.mark.parametrize("port", ["0", "65536", "here"])
def test_a_port_that_is_none_is_refused(options, port, capsys):
    assert options("--foxglove", port).code == 2
    assert len(capsys.readouterr().err.splitlines()) == 1


def test_a_bag_that_is_not_complete_is_an_error_after_the_result(tmp_path, monkeypatch, capsys):
    shown = []
    result = SimpleNamespace(policy_error="", method_error="", recording_error="bag_0.mcap: disk full")
    monkeypatch.setattr(run, "run_with_status", lambda _: result)
    monkeypatch.setattr(run, "show_results", lambda *given: shown.append(given))
    path = tmp_path / "s.yaml"
    save_scenario(sample_scenario("S3", 7), path)
    assert main(["run", "--scenario", str(path)]) == 1
    assert len(shown) == 1
    assert capsys.readouterr().err == "roadmend: bag_0.mcap: disk full\n"
