"""Code of one's own by the real commands: it drives in workers and in the graph, and what is wrong is one line."""

import json
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from roadmend.cli.main import main
from roadmend.world.families import sample_scenario
from roadmend.world.scenario_file import save_scenario
from tests.core.own_code import METHOD, POLICY

EXAMPLES = Path(__file__).parents[2] / "src" / "examples"


@pytest.fixture
def here(own, tmp_path):
    """The folder that the user is in, with code of his."""
    own(POLICY, "their_policies")
    own(METHOD, "their_repairs")
    scenario = sample_scenario("S3", 3).model_copy(update={"time_limit": 4.0})
    save_scenario(scenario, tmp_path / "theirs" / "s.yaml")
    return tmp_path / "theirs"


@pytest.fixture
def roadmend(here, tmp_path):
    """Runs the command in a process of its own, from that folder; -P as ./roadmend has it."""

    def run(*arguments, code=0):
        command = [sys.executable, "-P", "-m", "roadmend.cli", *map(str, arguments)]
        done = subprocess.run(command, cwd=here, capture_output=True, text=True, timeout=200, check=False)
        assert done.returncode == code, done.stderr
        return done

    return run


@pytest.mark.slow
def test_evaluate_drives_it_in_worker_processes(roadmend, here):
    arguments = ["evaluate", "--family", "S3", "--count", "2", "--policy", "their_policies:Careful"]
    arguments += ["--repair", "their_repairs:Near", "--workers", "2", "--json", "--out"]
    told = json.loads(roadmend(*arguments, "two").stdout)
    assert [*told["policies"]["their_policies:Careful"]] == ["none", "random", "their_repairs:Near"]
    assert len(told["episodes"]) == 6
    kept = (here / "two" / "results.jsonl").read_text().splitlines()
    roadmend(*arguments, "two")
    assert (here / "two" / "results.jsonl").read_text().splitlines() == kept  # nothing is driven again
    file = here / "their_policies.py"
    file.write_text(file.read_text().replace("8.0", "9.0"))
    roadmend(*arguments, "two")
    assert len((here / "two" / "results.jsonl").read_text().splitlines()) == 2 * len(kept) - 1  # all of it is


@pytest.mark.slow
def test_one_that_fails_on_the_way_is_a_line_for_every_episode(roadmend):
    for option, name, code in (("--policy", "their_policies:Late", 2), ("--repair", "their_repairs:Late", 1)):
        done = roadmend("evaluate", "s.yaml", option, name, "--workers", "1", "--out", name, code=code)
        faults = [line for line in done.stderr.splitlines() if line.startswith("S3-3, ")]
        assert len(faults) == (3 if option == "--policy" else 1)
        assert all("(" in line and "line " in line and "Error: " in line for line in faults)
        assert "Traceback" not in done.stderr


@pytest.mark.slow
def test_search_finds_with_a_policy_and_a_technique_of_ones_own(roadmend, here):
    arguments = ["search", "--family", "S3", "--policy", "their_policies:Careful", "--repair", "their_repairs:Near"]
    told = json.loads(roadmend(*arguments, "--budget", "2", "--workers", "2", "--out", "found", "--json").stdout)
    assert (told["policy"], told["repair"], told["evaluated"]) == ("their_policies:Careful", "their_repairs:Near", 2)
    done = roadmend("search", "--family", "S3", "--technique", "their_policies:Careful", "--out", "more", code=2)
    assert done.stderr == (
        "roadmend: Invalid value for '--technique': technique their_policies:Careful: has no method propose(); "
        "add it, see roadmend.search.technique.Technique (see 'roadmend search --help')\n"
    )


@pytest.mark.graph
@pytest.mark.slow
def test_the_graph_of_the_example_drives_as_this_process_does_and_the_bag_says_who(tmp_path, own, capfd):
    shutil.copy(EXAMPLES / "cruise.py", tmp_path / "theirs" / "own_cruise.py")
    shutil.copy(EXAMPLES / "late_brake.py", tmp_path / "theirs" / "own_brake.py")
    who = ["--policy", "own_cruise:Cruise", "--repair", "own_brake:LateBrake"]
    save_scenario(sample_scenario("S3", 3).model_copy(update={"time_limit": 6.0}), Path("s.yaml"))
    setting = ["--ros-args", "-p", "LateBrake.time:=3.0"]
    assert main(["run", "--scenario", "s.yaml", *who, "--no-viz", "--name", "bag", "--json", *setting]) == 0
    (told,) = json.loads(capfd.readouterr().out)
    assert (told["policy"], told["method"]) == ("own_cruise:Cruise", "own_brake:LateBrake")
    assert main(["bag", "info", "bags/bag", "--json"]) == 0
    record = json.loads(capfd.readouterr().out)["metadata"]["roadmend"]
    assert record["policy"] == "own_cruise:Cruise"
    assert record["policy_origin"] == str(tmp_path / "theirs" / "own_cruise.py")
    assert len(record["method_code_sha256"]) == 64
    again = ["bag", "resimulate", "bags/bag", "--repair", "own_brake:LateBrake", "--set", "time=3.0"]
    assert main([*again, "--out", "again"]) == 2
    assert "code from outside that a bag makes nobody run; name it yourself: " in capfd.readouterr().err
    assert main([*again, "--policy", "own_cruise:Cruise", "--out", "again", "--json"]) == 0
    now = json.loads(capfd.readouterr().out)["now"]
    assert {name: told[name] for name in now} == now
    for command in (["info"], ["plot", "--out", "a.html"]):
        assert main(["bag", *command, "bags/bag", "--futures", "1"]) == 2
        assert "name it yourself: --policy own_cruise:Cruise" in capfd.readouterr().err
        assert main(["bag", *command, "bags/bag", "--futures", "1", "--policy", "own_cruise:Cruise", "--json"]) == 0
        json.loads(capfd.readouterr().out)


@pytest.mark.graph
@pytest.mark.slow
@pytest.mark.parametrize(
    ("who", "said"),
    [
        (
            ["--policy", "their_policies:Late"],
            "policy their_policies:Late: failed in step at 1.05 s: ZeroDivisionError",
        ),
        (
            ["--repair", "their_repairs:Late"],
            "their_repairs:Late failed: ForeignError(\"propose at 1.05 s: KeyError: 'lost' (",
        ),
    ],
)
def test_the_graph_ends_with_what_failed(roadmend, who, said):
    done = roadmend("run", "--scenario", "s.yaml", *who, "--no-viz", "--no-record", code=1)
    assert done.stderr.splitlines()[-1].startswith(f"roadmend: {said}")
    assert "line " in done.stderr
    assert "Traceback" not in done.stderr


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (
            ["run", "--scenario", "s.yaml", "--policy", "modulr"],
            "'--policy': there is no 'modulr', did you mean modular?",
        ),
        (["search", "--family", "S3", "--out", "x", "--repair", "adrft"], "no 'adrft', did you mean adreft?"),
        (["search", "--family", "S33", "--out", "x"], "'--family': there is no 'S33', did you mean S3?"),
        (["search", "--family", "S3", "--technique", "avfuzer", "--out", "x"], "did you mean avfuzzer?"),
        (["evaluate", "s.yaml", "--policy", "their_policies:Carefull", "--out", "x"], "did you mean Careful?"),
        (["evaluate", "s.yaml", "--policy", "their_polices:Careful", "--out", "x"], "there is no module 'their_pol"),
        (["evaluate", "s.yaml", "--policy", "their_policies:Never", "--out", "x"], "cannot answer a plain scene"),
        (["evaluate", "s.yaml", "--policy", "their_repairs:Near", "--out", "x"], "has no method step(scene)"),
        (["safe", "test", "x", "--policy", "gone.safetensors", "--out", "x"], "gone.safetensors: no such model file"),
        (["safe", "extract", "x", "--backend", "openia", "--out", "x"], "did you mean openai?"),
        (["bag", "shadow", "x", "--repair", "adrft", "--out", "y"], "did you mean adreft?"),
        (["corpus", "build", "--families", "S3,S7", "--searches", "x", "--out", "y"], "there is no 'S7'"),
        (["corpus", "build", "--families", "a:B", "--searches", "x", "--out", "y"], "runs only where the user names"),
        (["list", "methods", "adrft"], "did you mean adreft?"),
    ],
)
def test_what_names_nothing_or_cannot_be_used_is_one_line_and_leaves_nothing(here, arguments, said, capsys):
    before = {path for path in here.iterdir() if path.suffix != ".pyc" and path.name != "__pycache__"}
    assert main(arguments) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert said in line
    assert {path for path in here.iterdir() if path.name != "__pycache__"} == before


def test_list_shows_origin_and_parameters(here, capsys):
    assert main(["list", "methods", "--json"]) == 0
    rows = {row["name"]: row for row in json.loads(capsys.readouterr().out)}
    assert rows["rss"]["origin"] == "roadmend"
    assert {"name": "rho", "default": 0.5, "meaning": "response time of every road user [s]"} in rows["rss"][
        "parameters"
    ]
    assert main(["list", "methods", "their_repairs:Near"]) == 0
    shown = capsys.readouterr().out
    assert "their_repairs.py" in shown
    assert "distance=8.0" in shown


@pytest.mark.parametrize("kind", ["policies", "techniques", "families", "backends", "models"])
def test_every_kind_is_listed(kind, capsys):
    assert main(["list", kind]) == 0
    shown = capsys.readouterr().out
    expected = {"policies": "modular", "techniques": "avfuzzer", "families": "left turn", "backends": "replay"}
    assert expected.get(kind, "self_oracle-modular") in shown


@pytest.mark.parametrize(
    ("arguments", "shown"),
    [
        (["run"], "[none|random|governor|rule|rss|predictive|model|adreft|gated|MODULE:CLASS|FILE]"),
        (["search"], "[random|avfuzzer|behavexplor|MODULE:CLASS]"),
        (["evaluate"], "[S1|S2|S3|S4|S5|MODULE:CLASS]"),
        (["safe", "extract"], "[embedded|openai|replay|MODULE:CLASS]"),
        (["corpus", "verify"], "[modular|neural|ego_mlp|deep_sets|MODULE:CLASS|FILE]"),
    ],
)
def test_help_shows_the_ways_to_name(arguments, shown, capsys):
    assert main([*arguments, "--help"]) == 0
    assert shown in "".join(capsys.readouterr().out.split())
