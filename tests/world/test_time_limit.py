"""The time limit of a route that nobody has given one."""

import pytest

from roadmend.core.errors import InputError
from roadmend.core.outcome import EventKind
from roadmend.policies.registry import make_policy
from roadmend.repair.registry import make_repairer
from roadmend.world.procedural_networks import NetworkRequest, generate_configuration
from roadmend.world.runner import run_episode
from roadmend.world.scenario_file import scenario_of_configuration
from roadmend.world.time_limit import time_for_route

ROUTE = ["B1B2", "B2B3", "B3B4", "B4B5", "B5B6"]


@pytest.fixture(scope="module")
def ring(tmp_path_factory):
    return generate_configuration(NetworkRequest("ring", 1, tmp_path_factory.mktemp("ring")))


def test_a_longer_route_gets_more_time(ring):
    limits = [scenario_of_configuration(ring, ROUTE[:count], 60.0).time_limit for count in (1, 2, 3, 5)]
    assert limits == sorted(set(limits))
    assert all(limit >= 40.0 and limit % 10.0 == 0.0 for limit in limits)


def test_it_is_enough_for_a_careful_policy(ring):
    scenario = scenario_of_configuration(ring, ROUTE, 60.0)
    result = run_episode(scenario, make_policy("modular"), make_repairer("none"))
    assert result.outcome is EventKind.GOAL
    assert result.duration > 0.3 * scenario.time_limit  # and not just anything


def test_what_the_user_says_holds(ring):
    assert scenario_of_configuration(ring, ROUTE, 60.0, 17.0).time_limit == 17.0


def test_a_route_that_is_not_there_is_refused_before_anything_starts(ring):
    with pytest.raises(InputError, match="there is no edge 'nowhere'"):
        scenario_of_configuration(ring, ["B1B2", "nowhere"], 60.0)
    scenario = scenario_of_configuration(ring, ROUTE, 60.0, 17.0)
    with pytest.raises(InputError, match="no lane leads from"):
        time_for_route(scenario.model_copy(update={"ego": scenario.ego.model_copy(update={"route": ["B1B2", "B4B5"]})}))
