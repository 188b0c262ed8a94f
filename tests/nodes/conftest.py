"""Scenarios small enough for tests of the graph."""

import pytest
import rclpy
from rclpy.context import Context
from rclpy.node import Node

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


@pytest.fixture
def node(domain):
    """Makes nodes that are no programs of ours, each in a context of its own, as a process has it."""
    made = []

    def make(name):
        context = Context()
        rclpy.init(context=context, domain_id=domain)
        made.append((Node(name, context=context), context))
        return made[-1][0]

    yield make
    for one, context in made:
        one.destroy_node()
        context.try_shutdown()
