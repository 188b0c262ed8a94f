"""``roadmend run``: what its options make of a run, without starting one."""

import io
from dataclasses import replace
from types import SimpleNamespace

import pytest
from rich.console import Console

from roadmend.cli import run
from roadmend.cli.main import main
from roadmend.core.errors import InputError, RoadmendError
from roadmend.nodes.run_result import RunResult
from roadmend.world.families import sample_scenario
from roadmend.world.scenario_file import load_scenario, save_scenario
from tests.measures.results import episode


def came(**changes):
    """A result as far as the exit code goes."""
    nothing = {"policy_error": "", "method_error": "", "recording_error": "", "faults": (), "lost_messages": 0}
    nothing |= {"answers": {"PASS": 9, "RESET": 1}, "repair_restarts": 0, "watchdog_ticks": 0, "foreign_frames": ""}
    return SimpleNamespace(**nothing | {"bag": "bags/bag", "episode": SimpleNamespace(scenario="town")} | changes)


@pytest.fixture
def options(tmp_path, monkeypatch):
    """The options of the run that a command would start; None where it is refused."""
    started = []

    def start(options):
        started.append(options)
        return came()

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


@pytest.mark.parametrize(
    ("changes", "code", "words"),
    [
        (
            {"faults": ("policy_node hung, restarted", "repair_node ended (-9), restarted")},
            1,
            "policy_node hung, restarted; ",
        ),
        (
            {"answers": {"PASS": 7, "STALE_COMMAND": 2, "RESET": 1}},
            0,
            "roadmend: of 10 answers repair_node gave 2 as STALE_COMMAND",
        ),
        ({"answers": {"PASS": 8, "RESET": 2}}, 0, "roadmend: of 10 answers repair_node gave 1 as RESET"),
        ({"answers": {"PASS": 8, "RESET": 2}, "restarts": 1}, 0, "repair_node gave 1 as RESET"),
        ({"answers": {"PASS": 8, "RESET": 2}, "restarts": 1, "repair_restarts": 1}, 0, ""),
        ({"watchdog_ticks": 3}, 0, "roadmend: the simulator braked by itself at 3 ticks (WATCHDOG)"),
        ({"foreign_frames": "not used: ego in 'odom'"}, 0, "roadmend: not used: ego in 'odom'"),
        ({"lost_messages": 658}, 0, "roadmend: bags/bag: 658 messages were lost on their way to the recorder"),
        ({"method_error": "rss failed"}, 1, "rss failed"),
        ({}, 0, ""),
    ],
)
def test_what_went_wrong_on_the_way_is_a_line_and_an_exit_code(tmp_path, monkeypatch, capsys, changes, code, words):
    monkeypatch.setattr(run, "run_with_status", lambda _: came(**changes))
    monkeypatch.setattr(run, "show_results", lambda *_: None)
    path = tmp_path / "s.yaml"
    save_scenario(sample_scenario("S1", 0), path)
    assert main(["run", "--scenario", str(path)]) == code
    said = capsys.readouterr().err
    assert words in said
    assert bool(said) == bool(words)


def test_a_bag_that_is_not_complete_is_an_error_after_the_result(tmp_path, monkeypatch, capsys):
    shown = []
    result = came(recording_error="bag_0.mcap: disk full")
    monkeypatch.setattr(run, "run_with_status", lambda _: result)
    monkeypatch.setattr(run, "show_results", lambda *given: shown.append(given))
    path = tmp_path / "s.yaml"
    save_scenario(sample_scenario("S3", 7), path)
    assert main(["run", "--scenario", str(path)]) == 1
    assert len(shown) == 1
    assert capsys.readouterr().err == "roadmend: bag_0.mcap: disk full\n"


def test_names_and_paths_in_the_table_are_texts_and_no_markup():
    drive = replace(episode("GOAL"), scenario="[bold]s", policy="own[red]:P", method="[/]")
    console = Console(file=io.StringIO(), width=200)
    run.show_results([RunResult(drive, "lockstep", 0, 0, 9.0, "bags [old]/x [/bold]", lost_messages=3)], console)
    told = console.file.getvalue()
    for text in ("[bold]s", "own[red]:P", " [/] ", "bags [old]/x [/bold] (3 messages lost)"):
        assert text in told, text


@pytest.fixture
def egos(tmp_path, monkeypatch, capsys):
    """Runs with a SUMO configuration whose egos of some seeds cannot be driven; returns code, runs and complaints."""
    (tmp_path / "town.net.xml").write_text("<net/>")
    path = tmp_path / "town.sumocfg"
    path.write_text('<configuration><net-file value="town.net.xml"/></configuration>')

    def of(*arguments, refused=(), failed=(), troubled=()):
        started = []

        def start(options):
            scenario = load_scenario(options.scenario)
            if scenario.seed in refused:
                raise InputError("ego.route", "is of no use", "choose another seed")
            if scenario.seed in failed:
                raise RoadmendError("SUMO ended")
            started.append((options, scenario))
            faults = ("policy_node ended (1)",) if scenario.seed in troubled else ()
            drive = SimpleNamespace(scenario=scenario.name)
            return came(episode=drive, faults=faults, recording_error="disk full" if faults else "")

        monkeypatch.setattr(run, "run_with_status", start)
        monkeypatch.setattr(run, "show_results", lambda *_: None)
        code = main(["run", "--sumocfg", str(path), *map(str, arguments)])
        return code, started, capsys.readouterr().err.splitlines()

    return of


def test_an_ego_without_a_route_gets_start_and_route_by_the_seed(egos):
    code, [(options, scenario)], _ = egos("--seed", 4)
    assert code == 0
    assert (options.seed, scenario.seed, scenario.network.draw, scenario.time_limit) == (4, 4, True, 120.0)
    assert scenario.ego.route == []


def test_several_egos_drive_one_after_the_other(egos):
    code, started, _ = egos("--egos", 3, "--seed", 4, "--name", "mine", "--time-limit", 60)
    assert code == 0
    assert [scenario.seed for _, scenario in started] == [4, 5, 6]
    assert [options.name for options, _ in started] == ["mine-0", "mine-1", "mine-2"]
    assert {scenario.time_limit for _, scenario in started} == {60.0}


@pytest.mark.parametrize(("refused", "expected"), [((), 0), ((0,), 1), ((0, 1), 2)])
def test_the_exit_code_tells_whether_anything_was_driven(egos, refused, expected, tmp_path):
    code, started, said = egos("--egos", 2, refused=refused)
    assert code == expected
    assert len(started) == 2 - len(refused)
    assert said == [f"roadmend: {tmp_path / 'town.sumocfg'}: ego.route: is of no use; choose another seed"] * len(
        refused
    )


def test_an_ego_that_fails_on_the_way_costs_the_others_nothing(egos):
    code, started, said = egos("--egos", 3, failed=(1,))
    assert (code, [scenario.seed for _, scenario in started]) == (1, [0, 2])
    assert len(said) == 1
    assert said[0].endswith("town-1: SUMO ended")


def test_where_the_first_one_fails_the_others_are_not_tried(egos):
    assert egos("--egos", 3, failed=(0,)) == (1, [], ["roadmend: SUMO ended"])


def test_one_that_fails_after_one_that_cannot_be_driven_costs_neither_its_line_nor_the_others(egos):
    code, started, said = egos("--egos", 4, refused=(0,), failed=(1,))
    assert (code, [scenario.seed for _, scenario in started]) == (1, [2, 3])
    assert [line.rpartition(": ")[2] for line in said] == ["is of no use; choose another seed", "SUMO ended"]


def test_all_that_went_wrong_is_said_of_each(egos):
    code, _, said = egos("--egos", 3, troubled=(1, 2))
    assert code == 1
    assert [line.partition("town-")[2] for line in said] == [
        f"{seed}: {what}" for seed in (1, 2) for what in ("policy_node ended (1)", "disk full")
    ]


def test_one_ego_that_cannot_be_driven_is_bad_input(egos):
    code, started, said = egos(refused=(0,))
    assert (code, started, len(said)) == (2, [], 1)
