"""Bad input that only a node can find: still one line, code 2, and nothing half written."""

import pytest
import yaml

from roadmend.cli.main import main
from roadmend.world.families import sample_scenario
from roadmend.world.scenario_file import save_scenario

pytestmark = pytest.mark.graph


@pytest.fixture
def scenario(tmp_path):
    path = tmp_path / "fine.yaml"
    save_scenario(sample_scenario("S3", 7), path)
    return path


@pytest.fixture
def complaint(capfd, tmp_path, monkeypatch):
    """Runs 'roadmend run' with an argument that a node refuses; returns the one line that it prints."""
    monkeypatch.setenv("ROS_LOG_DIR", str(tmp_path.with_name("log")))

    def run(*arguments):
        before = sorted(tmp_path.rglob("*"))
        assert main(["run", "--no-viz", *map(str, arguments)]) == 2
        lines = capfd.readouterr().err.splitlines()
        assert len(lines) == 1, lines
        left = [path for path in sorted(tmp_path.rglob("*")) if path not in before]
        assert [path for path in left if path != tmp_path / "bags"] == []
        return lines[0]

    return run


def changed(path, **changes):
    path.write_text(yaml.safe_dump(yaml.safe_load(path.read_text()) | changes))
    return path


def test_a_route_that_does_not_exist_names_file_field_and_choices(scenario, complaint, tmp_path):
    ego = yaml.safe_load(scenario.read_text())["ego"] | {"route": ["south_in", "nowhere"]}
    line = complaint("--scenario", changed(scenario, ego=ego), "--out", tmp_path / "bags")
    assert line.startswith(
        f"roadmend: {scenario}: ego.route[1]: there is no edge 'nowhere' in the network; choose from "
    )


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (["--rate", "3"], "--rate is of --clock realtime"),
        (["--name", "mine", "--no-record"], "--name is of a bag"),
    ],
)
def test_options_that_nobody_would_obey_are_refused(scenario, complaint, options, words):
    assert words in complaint("--scenario", scenario, *options)


def test_a_network_whose_name_is_too_long_for_any_file_is_named(scenario, capfd):
    path = changed(scenario, network={"kind": "file", "path": "n" * 300})
    assert main(["evaluate", str(path), "--out", str(path.parent / "out")]) == 2
    said = capfd.readouterr().err
    assert "File name too long" in said
    assert "Traceback" not in said


def test_a_network_without_lanes_for_cars_names_its_file(scenario, complaint, tmp_path):
    network = tmp_path / "bare.net.xml"
    network.write_text('<net version="1.20"/>')
    path = changed(scenario, network={"kind": "file", "path": "bare.net.xml"}, actors=[])
    line = complaint("--scenario", path, "--out", tmp_path / "bags")
    assert line == (
        f"roadmend: {network}: the network has no lane for cars; add roads and build it again with netconvert"
    )


def test_a_sumo_configuration_without_its_network_names_both(complaint, tmp_path):
    path = tmp_path / "town.sumocfg"
    path.write_text('<configuration><input><net-file value="town.net.xml"/></input></configuration>')
    line = complaint("--sumocfg", path, "--out", tmp_path / "bags")
    assert line == f"roadmend: {path}: net-file town.net.xml does not exist; mend the path in the configuration"


def test_an_output_folder_that_cannot_be_written_is_named(scenario, complaint, tmp_path):
    (tmp_path / "file").write_text("")
    line = complaint("--scenario", scenario, "--out", tmp_path / "file" / "bags", "--name", "mine")
    assert line.startswith(f"roadmend: {tmp_path / 'file' / 'bags' / 'mine'}: cannot be made (")
    assert "; choose" in line


def test_a_ros_parameter_out_of_range_is_named(scenario, complaint):
    line = complaint("--scenario", scenario, "--no-record", "--ros-args", "-p", "rss.rho:=-1.0")
    assert line.startswith("roadmend: parameter rss.rho: ")
    assert "Min: 0.0, Max: 3.0" in line
