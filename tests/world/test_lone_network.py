"""A network without traffic gets some: always the same, kept in the cache, and nothing beside the network."""

import gzip
import subprocess
from xml.etree import ElementTree as ET

import pytest

from roadmend.core.errors import InputError
from roadmend.world import lone_network
from roadmend.world.lone_network import with_traffic
from roadmend.world.network import find_binary
from roadmend.world.scenario_file import drawn_scenarios


@pytest.fixture
def town(tmp_path, monkeypatch):
    """A network with sidewalks, alone in a folder."""
    monkeypatch.setenv("ROADMEND_CACHE", str(tmp_path / "cache"))
    folder = tmp_path / "maps"
    folder.mkdir()
    grid = ("--grid", "--grid.number", "3", "--grid.length", "120", "--sidewalks.guess", "--crossings.guess")
    command = [str(find_binary("netgenerate")), *grid, "-o", str(folder / "town.net.xml")]
    subprocess.run(command, check=True, capture_output=True)
    return folder / "town.net.xml"


def travellers(configuration):
    return [one.tag for one in ET.parse(configuration.with_name("town.rou.xml")).getroot() if one.tag != "vType"]


def test_it_gets_cars_and_where_there_are_sidewalks_people(town, tmp_path):
    made = with_traffic(town)
    assert made.is_relative_to(tmp_path / "cache")
    assert set(travellers(made)) == {"vehicle", "person"}
    assert [*town.parent.iterdir()] == [town]


def test_the_traffic_is_made_once_and_again_for_another_network(town, monkeypatch):
    made = with_traffic(town)
    first = made.with_name("town.rou.xml").read_text()
    monkeypatch.setattr(lone_network, "random_traffic", None)  # nothing is made again
    assert with_traffic(town) == made
    monkeypatch.undo()
    monkeypatch.setenv("ROADMEND_CACHE", str(town.parent.parent / "other cache"))
    assert with_traffic(town).with_name("town.rou.xml").read_text() == first
    town.write_text(town.read_text() + "\n")
    assert with_traffic(town).parent.parent.name != made.parent.parent.name


@pytest.mark.parametrize(
    ("name", "change"),
    [
        ("elsewhere/town.net.xml", lambda content: content),
        ("town.net.xml.gz", gzip.compress),
        ("later/town.net.xml", lambda content: content.replace(b"generated on 2", b"generated on 3", 1)),
    ],
)
def test_the_same_network_has_the_same_traffic_packed_or_not_wherever_it_lies(town, name, change):
    other = town.parent / name
    other.parent.mkdir(exist_ok=True)
    other.write_bytes(change(town.read_bytes()))
    one, again = (with_traffic(path).with_name("town.rou.xml") for path in (town, other))
    assert [ET.tostring(each) for each in ET.parse(one).getroot()] == [
        ET.tostring(each) for each in ET.parse(again).getroot()
    ]


def test_a_drive_is_called_after_the_network(town):
    assert [scenario.name for scenario in drawn_scenarios([town], [3, 4], 60.0, 30.0)] == ["town-3", "town-4"]


def test_what_is_no_network_stays_as_it_is(tmp_path):
    for name in ("town.sumocfg", "none.net.xml", "folder"):
        assert with_traffic(tmp_path / name) == tmp_path / name


def test_a_cache_that_cannot_be_written_is_named(town, tmp_path, monkeypatch):
    (tmp_path / "file").write_text("")
    monkeypatch.setenv("ROADMEND_CACHE", str(tmp_path / "file"))
    with pytest.raises(InputError, match="cannot be written"):
        with_traffic(town)
