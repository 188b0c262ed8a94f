"""What a learner sees, held against the scene."""

import math

import numpy as np
import pytest

from roadmend.core.plain_moment import plain_moment
from roadmend.core.route import RightOfWay, Route, Stage, Window, Zone
from roadmend.core.scene import EgoState, ObjectKind, ObjectList, Scene, Signal
from roadmend.gym.observation import AHEAD, EGO, OBJECT, ROAD, ZONE, observation_space
from roadmend.gym.observer import DriveObserver

MOMENT = plain_moment()


def see(route=MOMENT.route, scene=MOMENT.scene, most=4):
    observer = DriveObserver(most)
    observer.reset(route)
    observation = observer.see(scene)
    assert observation_space(most).contains(observation)
    return observation


def number(row, columns, name):
    return row[[column.name for column in columns].index(name)]


def test_the_ego_and_its_road():
    seen = see()
    expected = {"speed": 5.0, "acceleration": 0.0, "offset": 0.0, "speed_limit": 10.0, "left": 80.0, "must_change": 0.0}
    assert {name: number(seen["ego"], EGO, name) for name in expected} == expected
    assert [*seen["road"][:, 0]] == [*AHEAD]
    assert not seen["road"][:, 1:3].any()
    assert {*seen["road"][:, [column.name for column in ROAD].index("speed_limit")]} == {10.0}


def test_others_are_where_the_ego_sees_them_nearest_first():
    yaw = 2.5
    ego = EgoState.from_yaw(10.0, 0.0, yaw, 5.0, 0.0, 4.5, 1.8)
    far, near = (12.0, 5.0), (3.0, -2.0)  # ahead, left
    x, y = (
        [10.0 + a * math.cos(yaw) - b * math.sin(yaw) for a, b in (far, near)],
        [a * math.sin(yaw) + b * math.cos(yaw) for a, b in (far, near)],
    )
    others = ObjectList.of(
        id=[7, 8], kind=[ObjectKind.BUS, ObjectKind.PEDESTRIAN], x=x, y=y, yaw=[yaw + 3.0, -yaw], speed=[3.0, 1.0],
        acceleration=[0.5, 0.0], yaw_rate=[0.1, 0.0], length=[12.0, 0.5], width=[2.5, 0.6],
    )  # fmt: skip
    seen = see(scene=Scene(0.0, ego, others, MOMENT.scene.signals))
    assert [*seen["objects_mask"]] == [1, 1, 0, 0]
    assert seen["objects"][0, :2] == pytest.approx(near, abs=1e-5)
    assert seen["objects"][1, :8] == pytest.approx([*far, 3.0, 3.0, 0.5, 0.1, 12.0, 2.5], abs=1e-5)
    assert number(seen["objects"][0], OBJECT, "yaw") == pytest.approx(math.remainder(-2.0 * yaw, 2.0 * math.pi))
    assert number(seen["objects"][0], OBJECT, "pedestrian") == number(seen["objects"][1], OBJECT, "bus") == 1.0
    assert seen["objects"][:, 8:].sum() == 2.0
    assert not seen["objects"][2:].any()


@pytest.mark.parametrize("count", [0, 4, 30])
def test_any_number_of_others_fits(count):
    others = ObjectList.of(
        id=np.arange(count), kind=1, x=np.arange(count) * 400.0, y=1e6, yaw=9.0, speed=200.0, acceleration=-99.0,
        yaw_rate=50.0, length=99.0, width=99.0,
    )  # fmt: skip
    seen = see(scene=Scene(0.0, MOMENT.scene.ego, others, MOMENT.scene.signals))
    assert seen["objects_mask"].sum() == min(count, 4)


def test_zones_and_lane_changes():
    (stage,) = MOMENT.route.stages
    side = type(stage)(stage.x, stage.y + 3.2, stage.speed_limit)
    zones = (
        Zone(0, 60.0, 70.0, RightOfWay.SIGNAL, 0),
        Zone(0, 30.0, 35.0, RightOfWay.YIELD),
        Zone(0, 2.0, 3.0, RightOfWay.STOP),  # behind
        Zone(1, 80.0, 90.0, RightOfWay.STOP),  # of the next lane
    )
    two = Route("two", 4.5, 1.8, 90.0, 30.0, (stage, side), (Window(20.0, 50.0),), zones)
    lights = np.array([Signal.RED], dtype=np.uint8)
    seen = see(two, Scene(2.0, MOMENT.scene.ego, MOMENT.scene.objects, lights))
    assert [*seen["zones_mask"]] == [1, 1, 0]
    assert seen["zones"][0, :2] == pytest.approx([30.0 - 10.0 - 2.25, 35.0 - 10.0 + 2.25])
    assert number(seen["zones"][0], ZONE, "yield") == number(seen["zones"][1], ZONE, "signal") == 1.0
    assert number(seen["zones"][1], ZONE, "red") == 1.0
    assert seen["zones"][0, 2:].sum() == 1.0
    names = ("must_change", "change_begin", "change_end", "change_side", "time_left")
    assert [number(seen["ego"], EGO, name) for name in names] == [1.0, 10.0, 40.0, 1.0, 28.0]
    right = Route("two", 4.5, 1.8, 90.0, 30.0, (side, stage), (Window(20.0, 50.0),), ())
    assert number(see(right)["ego"], EGO, "change_side") in {-1.0, 0.0}


@pytest.mark.parametrize("length", [200.0, 3000.0])
@pytest.mark.parametrize(("lane", "side"), [(4.0, 1.0), (-4.0, -1.0)])
@pytest.mark.parametrize("turn", [1.0, -1.0])
def test_a_lane_around_a_corner_is_on_the_side_on_which_it_is_there(length, lane, side, turn):
    def stage(x, y):
        x, y = np.array(x), turn * np.array(y)
        return Stage(x, y, np.full(len(x), 10.0))

    # North, then east or west into a street whose other lane leads on from the corner.
    own = stage([0.0, 0.0, 1.0, 4.0, 404.0], [-length, -4.0, -1.0, 0.0, 0.0])
    beside = turn * lane
    other = stage([5.0, 404.0, 404.0 + length], [beside, beside, beside])
    begin, end = length + 50.0, length + 300.0
    route = Route("corner", 4.5, 1.8, 300.0, 90.0, (own, other), (Window(begin, end),), ())
    for position in (0.0, 0.5 * length, length, begin, end):
        ego = EgoState.from_yaw(*own.pose(position), 5.0, 0.0, 4.5, 1.8)
        seen = see(route, Scene(0.0, ego, MOMENT.scene.objects, MOMENT.scene.signals))
        assert number(seen["ego"], EGO, "change_side") == side


def test_acceleration_is_that_of_the_last_tick():
    observer = DriveObserver(1)
    observer.reset(MOMENT.route)
    observer.see(MOMENT.scene)
    faster = MOMENT.scene.ego._replace(speed=5.1)
    seen = observer.see(Scene(0.05, faster, MOMENT.scene.objects, MOMENT.scene.signals))
    assert number(seen["ego"], EGO, "acceleration") == pytest.approx(2.0)


def test_every_column_says_what_it_is():
    for columns in (EGO, ROAD, ZONE, OBJECT):
        assert len({column.name for column in columns}) == len(columns)
        assert all(column.meaning and column.low < column.high for column in columns)
