"""The command line without starting nodes: what it prints, what it refuses, and what it does not load."""

import json
import subprocess
import sys
from pathlib import Path

import pytest
import yaml

from roadmend.cli.main import main
from roadmend.world.families import FAMILIES, sample_scenario
from roadmend.world.scenario import Scenario
from roadmend.world.scenario_file import load_scenario, save_scenario


@pytest.fixture
def scenario(tmp_path):
    path = tmp_path / "fine.yaml"
    save_scenario(sample_scenario("S3", 7), path)
    return path


@pytest.fixture
def complaint(capfd, monkeypatch):
    """Runs a command that must be refused with one line, and before any node starts; returns the line."""
    monkeypatch.setattr("roadmend.nodes.launcher._GraphRun", lambda *_: pytest.fail("started the graph"))

    def run(*arguments, code=2):
        assert main([str(argument) for argument in arguments]) == code
        printed = capfd.readouterr()
        assert printed.out == ""
        lines = printed.err.splitlines()
        assert len(lines) == 1, printed.err
        assert lines[0].startswith("roadmend: ")
        return lines[0]

    return run


def entries(folder):
    return sorted(str(path.relative_to(folder)) for path in folder.rglob("*"))


def test_starting_the_command_line_loads_neither_sumo_nor_ros_nor_numba():
    heavy = "libsumo", "sumolib", "rclpy", "numba", "numpy", "roadmend_msgs", "matplotlib", "pydantic"
    code = f"import sys, roadmend.cli.main; print(*(name for name in {heavy} if name in sys.modules))"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.split() == []


def test_help_lists_every_command_without_loading_one():
    code = "import sys; from roadmend.cli.main import main; main(['--help']); print(*sys.modules, file=sys.stderr)"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    for command in ("run", "demo", "sample", "schema", "bench", "bag", "replay", "test"):
        assert f"\n  {command} " in done.stdout
    assert "numpy" not in done.stderr.split()
    assert "roadmend.cli.run" not in done.stderr.split()


@pytest.mark.parametrize("command", ["run", "demo", "sample", "schema", "bag", "replay"])
def test_every_command_has_a_help_page(command, capsys):
    assert main([command, "--help"]) == 0
    assert f"Usage: roadmend {command} " in capsys.readouterr().out


# -- what is refused ---------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("name: x\nego: [1, 2\nactors: }", ("broken YAML at line 3", "mend the line")),
        ("", ("holds no fields", "roadmend schema")),
        ("- 1\n- 2\n", ("holds no fields", "roadmend schema")),
        ("\tname: x", ("broken YAML at line 1", "mend the line")),
    ],
)
def test_a_file_that_is_no_scenario(tmp_path, complaint, text, words):
    path = tmp_path / "s.yaml"
    path.write_text(text)
    line = complaint("run", "--scenario", path, "--out", tmp_path / "bags")
    assert str(path) in line
    assert all(word in line for word in words), line
    assert entries(tmp_path) == ["s.yaml"]


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"weather_today": "fine"}, "field weather_today is unknown"),
        ({"seed": "seven"}, 'field seed: input should be a valid integer (got "seven")'),
        ({"seed": "7"}, "field seed"),
        ({"seed": -1}, "field seed"),
        ({"time_limit": 0}, "field time_limit"),
        ({"network": {"kind": "tunnel"}}, "field network"),
        ({"ego": {"rout": ["south_in"]}}, "field ego.rout is unknown"),
        ({"format": "roadmend-scenario/9"}, "field format"),
        ({"name": "a/b"}, "field name"),
    ],
)
def test_a_field_that_is_wrong(scenario, tmp_path, complaint, change, words):
    scenario.write_text(yaml.safe_dump(yaml.safe_load(scenario.read_text()) | change))
    line = complaint("run", "--scenario", scenario, "--out", tmp_path / "bags")
    assert f"{scenario}: {words}" in line
    assert "see 'roadmend schema'" in line
    assert entries(tmp_path) == ["fine.yaml"]


def test_a_file_that_is_not_there(tmp_path, complaint):
    path = tmp_path / "none.yaml"
    assert complaint("run", "--scenario", path) == (
        f"roadmend: {path}: no such file; give the path of a scenario; 'roadmend sample' makes one"
    )


def test_a_folder_is_no_scenario(tmp_path, complaint):
    assert "cannot be read" in complaint("run", "--scenario", tmp_path)


def test_a_sumo_configuration_that_is_not_there(tmp_path, complaint):
    line = complaint("run", "--sumocfg", tmp_path / "none.sumocfg", "--out", tmp_path / "bags")
    assert (
        line
        == f"roadmend: {tmp_path / 'none.sumocfg'}: no such file; give the path of a SUMO configuration (.sumocfg) or network "
        "(.net.xml, .net.xml.gz), or of a folder"
    )
    assert entries(tmp_path) == []


@pytest.fixture
def town(tmp_path):
    """A configuration whose files are there; nobody looks into them before a node starts."""

    def write(folder):
        folder.mkdir(exist_ok=True)
        (folder / "town.net.xml").write_text("<net/>")
        (folder / "town.sumocfg").write_text('<configuration><net-file value="town.net.xml"/></configuration>')
        return folder / "town.sumocfg"

    return write


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["--warm-up", "1e9"], "--warm-up"),
        (["--time-limit", "1e9"], "--time-limit"),
        (["--time-limit", "nan"], "nan is not a finite number"),
        (["--egos", "0"], "--egos"),
    ],
)
def test_figures_for_a_sumo_configuration_have_bounds(tmp_path, town, complaint, arguments, words):
    line = complaint("run", "--sumocfg", town(tmp_path / "town"), *arguments)
    assert words in line
    assert "not in the range" in line or "finite" in line


@pytest.mark.parametrize("option", ["--egos", "--ego-route", "--warm-up", "--time-limit"])
def test_what_is_of_a_sumo_configuration_is_refused_for_a_scenario(scenario, complaint, option):
    assert f"{option}: is of a SUMO configuration" in complaint("run", "--scenario", scenario, option, "3")


@pytest.mark.parametrize("route", ["", "  "])
def test_a_route_without_an_edge_is_none_that_may_be_drawn(tmp_path, town, complaint, route):
    line = complaint("run", "--sumocfg", town(tmp_path / "town"), "--ego-route", route)
    assert line.startswith("roadmend: --ego-route: names no edge; ")


def test_the_name_of_a_folder_in_any_script_makes_a_scenario_name(tmp_path, town, complaint):
    path = town(tmp_path / "Zürich Süd")
    (tmp_path / "bags" / "mine").mkdir(parents=True)
    arguments = ("--out", tmp_path / "bags", "--name", "mine")
    assert "exists already" in complaint("run", "--sumocfg", path, *arguments)  # so it got that far


def test_both_or_neither_of_scenario_and_sumo_configuration(scenario, complaint):
    for arguments in ((), ("--scenario", scenario, "--sumocfg", scenario)):
        assert "give either --scenario or --sumocfg" in complaint("run", *arguments)


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["fly"], "No such command 'fly'"),
        (["--fast"], "--fast"),
        (["sample", "--family", "S9"], "there is no 'S9'; choose one of S1, S2, S3, S4, S5, or"),
        (["sample"], "Missing option '--family'"),
        (["sample", "--family", "S1", "--seed", "seven"], "'seven' is not a valid integer"),
        (["sample", "--family", "S1", "--seed", "-1"], "-1 is not in the range"),
        (["sample", "--family", "S1", "--sead", "1"], "--sead"),
        (["schema", "extra"], "extra"),
        (["run", "--scenario", "s.yaml", "--repair", "prayer"], "there is no 'prayer'; choose one of"),
        (["run", "--scenario", "s.yaml", "--policy", "autopilot"], "there is no 'autopilot'; choose one of"),
        (["run", "--scenario", "s.yaml", "--clock", "sundial"], "'sundial' is not one of"),
        (["run", "--scenario", "s.yaml", "--rate", "0"], "0"),
        (["run", "--scenario", "s.yaml", "--seed", "seven"], "'seven' is not a valid integer"),
        (["run", "--scenario", "s.yaml", "--quick"], "--quick"),
        (["run", "--scenario", "s.yaml", "surplus"], "surplus"),
        (["bag", "sleep"], "No such command 'sleep'"),
    ],
)
def test_an_unknown_command_option_or_value(arguments, words, complaint, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    line = complaint(*arguments)
    assert words in line
    assert "--help'" in line  # where to look
    assert entries(tmp_path) == []


def test_a_bag_that_is_there_already(scenario, tmp_path, complaint):
    (tmp_path / "bags" / "mine").mkdir(parents=True)
    (tmp_path / "bags" / "mine" / "precious").write_text("data")
    line = complaint("run", "--scenario", scenario, "--out", tmp_path / "bags", "--name", "mine")
    assert f"{tmp_path / 'bags' / 'mine'}: exists already; choose another --name or remove it" in line
    assert (tmp_path / "bags" / "mine" / "precious").read_text() == "data"


# -- scenarios ---------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("family", FAMILIES)
def test_sample_writes_a_file_that_loads_back(family, tmp_path, capsys):
    path = tmp_path / "deep" / "s.yaml"
    assert main(["sample", "--family", family, "--seed", "5", "--out", str(path)]) == 0
    assert load_scenario(path) == sample_scenario(family, 5)
    assert f"{path}: {family}-5, " in capsys.readouterr().out
    assert entries(tmp_path) == ["deep", "deep/s.yaml"]


def test_sample_prints_what_it_would_write(tmp_path, capsys):
    assert main(["sample", "--family", "S1", "--seed", "5"]) == 0
    (tmp_path / "s.yaml").write_text(capsys.readouterr().out)
    assert load_scenario(tmp_path / "s.yaml") == sample_scenario("S1", 5)


def test_sample_into_a_place_that_cannot_be_written(tmp_path, complaint):
    (tmp_path / "file").write_text("mine")
    path = tmp_path / "file" / "s.yaml"
    line = complaint("sample", "--family", "S1", "--out", path)
    assert f"{path}: cannot be written (" in line
    assert "choose a writable folder" in line
    assert entries(tmp_path) == ["file"]
    assert (tmp_path / "file").read_text() == "mine"


def test_schema_describes_what_sample_writes(capsys):
    assert main(["schema"]) == 0
    schema = json.loads(capsys.readouterr().out)
    for family in FAMILIES:
        content = sample_scenario(family, 1).model_dump(mode="json", exclude_none=True)
        try:
            import jsonschema
        except ImportError:
            check(schema, schema, content, family)
        else:
            jsonschema.validate(content, schema)
    assert set(schema["required"]) == {"name", "network", "ego"}
    assert set(Scenario.model_fields) == set(schema["properties"])


def check(whole, schema, value, place):
    """As much of JSON schema as the scenario's uses."""
    if "$ref" in schema:
        return check(whole, whole["$defs"][schema["$ref"].rpartition("/")[2]], value, place)
    if "oneOf" in schema:
        name = schema["discriminator"]["propertyName"]
        target = schema["discriminator"]["mapping"][value[name]]
        return check(whole, {"$ref": target}, value, place)
    if "anyOf" in schema:
        kinds = {"null": type(None), "number": int | float, "string": str}
        return next(part for part in schema["anyOf"] if isinstance(value, kinds[part.get("type", "string")]))
    kinds = {"object": dict, "array": list, "string": str, "integer": int, "number": int | float, "boolean": bool}
    assert isinstance(value, kinds[schema["type"]]), place
    assert value in schema.get("enum", [value]), place
    assert value == schema.get("const", value), place
    if schema["type"] == "object":
        assert schema["additionalProperties"] is False
        assert set(schema.get("required", [])) <= set(value) <= set(schema["properties"]), place
        for name, part in value.items():
            check(whole, schema["properties"][name], part, f"{place}.{name}")
    elif schema["type"] == "array":
        for number, part in enumerate(value):
            check(whole, schema["items"], part, f"{place}[{number}]")
    elif schema["type"] in ("integer", "number"):
        assert schema.get("minimum", value) <= value <= schema.get("maximum", value), place
    return schema


def test_the_scenarios_that_come_along_are_sound():
    folder = Path(__file__).parents[2] / "config" / "scenarios"
    for path in folder.glob("*.yaml"):
        assert load_scenario(path).name


def test_sample_prints_json_that_is_a_scenario_file_too(tmp_path, capsys):
    assert main(["sample", "--family", "S1", "--seed", "5", "--json"]) == 0
    (tmp_path / "s.yaml").write_text(capsys.readouterr().out)
    assert json.loads((tmp_path / "s.yaml").read_text())["name"] == "S1-5"
    assert load_scenario(tmp_path / "s.yaml") == sample_scenario("S1", 5)


def test_a_conversion_is_told_as_json(tmp_path, capsys):
    bag = Path(__file__).parents[2] / "bags" / "samples" / "repaired"
    out = tmp_path / "converted"
    assert main(["bag", "convert", str(bag), "--to", "sqlite3", "--out", str(out), "--json"]) == 0
    told = json.loads(capsys.readouterr().out)
    assert (told["bag"], told["storage"]) == (str(out), "sqlite3")
    assert told["messages"] > 100


def test_what_is_made_of_networks_is_told_as_json(tmp_path, capsys):
    arguments = ["networks", "--kind", "rural", "--count", "1", "--workers", "1", "--out", str(tmp_path), "--json"]
    assert main(arguments) == 0
    assert json.loads(capsys.readouterr().out) == [str(tmp_path / "rural-0" / "rural-0.sumocfg")]
