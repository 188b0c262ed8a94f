"""A ROS domain of its own for each test that starts nodes, and scenarios small enough for tests."""

import pytest

from roadmend.nodes.domain import own_domain
from roadmend.world.families import sample_scenario
from roadmend.world.scenario_file import save_scenario


@pytest.fixture
def domain(monkeypatch):
    monkeypatch.delenv("ROS_DOMAIN_ID", raising=False)
    with own_domain() as number:
        monkeypatch.setenv("ROS_DOMAIN_ID", str(number))
        monkeypatch.setenv("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")
        yield number


@pytest.fixture
def scenario_file(tmp_path):
    """Writes a sampled scenario and returns its path."""

    def write(family, seed, **changes):
        scenario = sample_scenario(family, seed).model_copy(update=changes)
        path = tmp_path / f"{scenario.name}.yaml"
        save_scenario(scenario, path)
        return path

    return write
