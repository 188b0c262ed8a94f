"""Scenarios small enough for tests of the graph."""

import pytest

from roadmend.world.families import sample_scenario
from roadmend.world.scenario_file import save_scenario


@pytest.fixture
def scenario_file(tmp_path):
    """Writes a sampled scenario and returns its path."""

    def write(family, seed, **changes):
        scenario = sample_scenario(family, seed).model_copy(update=changes)
        path = tmp_path / f"{scenario.name}.yaml"
        save_scenario(scenario, path)
        return path

    return write
