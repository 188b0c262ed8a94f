"""OpenDRIVE files: complete or not at all."""

import pytest

from roadmend.core.errors import InputError, SimulationError
from roadmend.world.network import network_file
from roadmend.world.opendrive import write_opendrive
from roadmend.world.scenario_networks import OpenRoadNetwork


def test_a_network_becomes_one_file_and_nothing_is_left_beside_it(tmp_path):
    write_opendrive(network_file(OpenRoadNetwork()), tmp_path / "new" / "road.xodr")
    assert [path.name for path in (tmp_path / "new").iterdir()] == ["road.xodr"]
    assert "<OpenDRIVE>" in (tmp_path / "new" / "road.xodr").read_text(encoding="utf-8")


def test_what_is_no_network_is_an_error_and_leaves_nothing(tmp_path):
    (tmp_path / "x.net.xml").write_text("<net", encoding="utf-8")
    with pytest.raises(SimulationError, match="netconvert failed"):
        write_opendrive(tmp_path / "x.net.xml", tmp_path / "out" / "road.xodr")
    assert not list((tmp_path / "out").iterdir())


def test_a_place_that_cannot_be_written_is_one_line(tmp_path):
    (tmp_path / "file").write_text("", encoding="utf-8")
    with pytest.raises(InputError, match="cannot be written"):
        write_opendrive(network_file(OpenRoadNetwork()), tmp_path / "file" / "road.xodr")
