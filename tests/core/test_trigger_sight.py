import math

import numpy as np
import pytest

from roadmend.core.repair import RepairTrigger
from roadmend.core.scene import OBJECT, EgoState, ObjectKind, ObjectList
from roadmend.core.trigger_sight import TriggerSight, sight_of


def seen(ahead, left, yaw=0.0, *, kind=ObjectKind.CAR, ego_yaw=0.7, identity=7):
    """A car of 4 m by 2 m, placed and turned as the ego of 4 m by 2 m sees it, wherever that heads."""
    ego = EgoState.from_yaw(100.0, -50.0, ego_yaw, 8.0, 0.0, 4.0, 2.0)
    x = ego.x + ahead * math.cos(ego_yaw) - left * math.sin(ego_yaw)
    y = ego.y + ahead * math.sin(ego_yaw) + left * math.cos(ego_yaw)
    columns = {"id": 7, "kind": kind, "x": x, "y": y, "yaw": ego_yaw + yaw, "length": 4.0, "width": 2.0}
    objects = ObjectList(np.zeros(1, dtype=OBJECT)).with_columns(**columns)
    return sight_of(RepairTrigger(identity, 0.5), ego, objects)


@pytest.mark.parametrize("ego_yaw", [0.0, 0.7, -3.0, math.pi])
@pytest.mark.parametrize(
    ("ahead", "left", "place"),
    [
        (20.0, 0.0, "ahead"),
        (20.0, 1.9, "ahead"),  # still in the way
        (20.0, 2.1, "ahead left"),
        (20.0, -2.1, "ahead right"),
        (3.9, 3.0, "left"),
        (-3.9, -3.0, "right"),
        (-20.0, 0.0, "behind"),
        (-4.1, 3.0, "behind left"),
        (1.0, 1.0, "touching"),
    ],
)
def test_the_place_is_told_as_the_ego_sees_it(ahead, left, place, ego_yaw):
    assert seen(ahead, left, ego_yaw=ego_yaw).place == place


def test_who_stands_across_reaches_farther_into_the_way():
    assert seen(20.0, 2.5).place == "ahead left"
    assert seen(20.0, 2.5, 0.5 * math.pi).place == "ahead"


def test_distance_and_bearing_are_numbers():
    sight = seen(20.0, 0.0)
    assert sight.distance == pytest.approx(16.0)
    assert sight.bearing == pytest.approx(0.0, abs=1e-9)
    assert seen(0.0, 10.0).bearing == pytest.approx(0.5 * math.pi)
    assert seen(0.0, -10.0, ego_yaw=3.0).as_dict()["bearing_degrees"] == pytest.approx(-90.0)


def test_words():
    assert seen(20.0, 3.0).words == "car 7 ahead left, 16 m"
    assert seen(20.0, 0.0, kind=ObjectKind.UNKNOWN).words == "object 7 ahead, 16 m"


@pytest.mark.parametrize("missing", [{"identity": 8}, {"ahead": math.nan}])
def test_who_cannot_be_found_is_named_by_the_number_alone(missing):
    sight = seen(**{"ahead": 20.0, "left": 0.0} | missing)
    identity = missing.get("identity", 7)
    assert sight == TriggerSight(identity, 0.5)
    assert sight.words == f"{identity}"
    assert sight.as_dict() == {
        "id": identity,
        "weight": 0.5,
        "kind": None,
        "distance": None,
        "bearing_degrees": None,
        "place": "",
    }
