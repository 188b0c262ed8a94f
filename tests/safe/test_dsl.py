"""What a scenario may not say."""

import pytest

from roadmend.safe.dsl import (
    Action,
    Compass,
    CrashScenario,
    DescribedCollision,
    DescribedEnvironment,
    DescribedRoadNetwork,
    DescribedVehicle,
    DslModel,
    Position,
    RoadType,
)

CAR = DescribedVehicle(DslModel.SEDAN, Position.W2E, Action.MOVE_FORWARD, 45)
NOWHERE = DescribedEnvironment(None, None)


@pytest.mark.parametrize("lanes", [0, -1, 25])
def test_lanes_out_of_range(lanes):
    with pytest.raises(ValueError, match="num_lanes"):
        DescribedRoadNetwork(RoadType.STRAIGHT, lanes)


@pytest.mark.parametrize("road_type", [None, *(kind for kind in RoadType if kind is not RoadType.T_INTERSECTION)])
def test_a_stem_needs_a_t_intersection(road_type):
    with pytest.raises(ValueError, match="stem_direction"):
        DescribedRoadNetwork(road_type, 2, Compass.WEST)


@pytest.mark.parametrize("limit", [0, -5, 100.5])
def test_speed_limits_out_of_range(limit):
    with pytest.raises(ValueError, match="speed_limit_mph"):
        DescribedVehicle(None, None, None, limit)


def test_a_way_needs_two_points():
    with pytest.raises(ValueError, match="action"):
        DescribedVehicle(None, None, ((0.0, 0.0),), None)


def test_a_crash_needs_a_vehicle():
    with pytest.raises(ValueError, match="vehicles is empty"):
        CrashScenario(DescribedRoadNetwork(None, None), (), NOWHERE)


@pytest.mark.parametrize(
    ("road_type", "position"),
    [(RoadType.MERGING, Position.W2E), (RoadType.CURVE, Position.ON_RAMP), (None, Position.MAIN_ROAD)],
)
def test_positions_belong_to_road_types(road_type, position):
    with pytest.raises(ValueError, match=r"vehicles\[0\].initial_position"):
        CrashScenario(DescribedRoadNetwork(road_type, 2), (DescribedVehicle(None, position, None, None),), NOWHERE)


def test_collisions_need_two_vehicles_that_are_there():
    with pytest.raises(ValueError, match="itself"):
        DescribedCollision(1, 1)
    with pytest.raises(ValueError, match="name vehicle 2"):
        CrashScenario(DescribedRoadNetwork(None, None), (CAR,), NOWHERE, (DescribedCollision(1, 2),))


def test_own_fields_need_their_prefix():
    with pytest.raises(ValueError, match="x-"):
        DescribedEnvironment(None, None, {"wind": 3})


@pytest.mark.parametrize("name", ["x-a\nb", "x-a\u2028b", "x-<a", "x-a>", "x-a "])
def test_own_fields_fit_into_a_line_of_the_text_form(name):
    with pytest.raises(ValueError, match="x-"):
        DescribedEnvironment(None, None, {name: 3})
