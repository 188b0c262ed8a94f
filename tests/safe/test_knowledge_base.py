"""The knowledge base: complete, and its examples true to the language."""

import pytest

from roadmend.safe.dsl import Position, RoadType
from roadmend.safe.knowledge_base import retrieve


@pytest.mark.parametrize("road_type", RoadType)
def test_every_road_type_has_a_template_with_a_worked_example(road_type):
    template, example = retrieve(road_type, ())
    assert template.road_type is road_type
    assert template.guidance.startswith("Step 1")
    for each in template.examples:
        assert each.answer.road.road_type is road_type
        assert each.directions == tuple(vehicle.initial_position for vehicle in each.answer.vehicles)
        assert each.analysis
        assert each.summary
    assert example in template.examples


@pytest.mark.parametrize(
    ("directions", "found"),
    [
        ([Position.S2N, Position.N2S], {Position.W2E, Position.E2W}),  # opposite, whatever the compass
        ([Position.E2W, Position.E2W], {Position.N2S}),
        ([Position.E2W], {Position.N2S}),
    ],
)
def test_examples_are_found_by_how_the_vehicles_stand_to_each_other(directions, found):
    _, example = retrieve(RoadType.STRAIGHT, directions)
    assert set(example.directions) == found
