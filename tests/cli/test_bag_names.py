"""What a bag is called where a command makes another of it."""

import pytest

from roadmend.cli.bag import _name


@pytest.mark.parametrize("given", ["", "metadata.yaml"])
def test_points_in_the_name_of_a_folder_belong_to_it(tmp_path, given):
    folder = tmp_path / "osm.passenger-0"
    folder.mkdir()
    (folder / "metadata.yaml").touch()
    assert _name(folder / given) == "osm.passenger-0"


def test_of_a_file_the_ending_does_not(tmp_path):
    assert _name(tmp_path / "drive.v2_0.mcap") == "drive.v2_0"
