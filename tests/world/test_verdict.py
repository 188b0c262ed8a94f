"""How a tick is judged: contact, goal, lost, out of time, or a stand-off that is ended. Without SUMO."""

import math
from dataclasses import dataclass, field
from types import SimpleNamespace

import numpy as np
import pytest

from roadmend.core.outcome import Blame, Event, EventKind
from roadmend.core.route import Route, Stage, Window
from roadmend.core.scene import ObjectKind, ObjectList
from roadmend.world.ego import RouteFollower
from roadmend.world.impacts import Impacts
from roadmend.world.participants import Observation
from roadmend.world.simulation import Simulation

TICK = 7
TIME = 0.35  # [s] at that tick, 20 of them a second
LENGTH = 300.0  # [m] of the road
FAR_BEHIND = -40.0  # [m]


@dataclass
class Somebody:
    """Who is around: behind the ego by default, and as far away as told."""

    name: str
    gap: float  # [m] between the outlines
    kind: ObjectKind = ObjectKind.CAR
    speed: float = 5.0  # [m/s]
    ahead: float = FAR_BEHIND  # [m] of the ego's centre
    seen: bool = True


class Crowd:
    """Stands for the participants: whoever is told, in that order; their numbers begin with 11."""

    def __init__(self, people):
        self.people = {each.name: each for each in people}

    def number_of(self, name):
        return 11 + list(self.people).index(name)

    def kind_of(self, name):
        return self.people[name].kind

    def observe(self, ego):
        people = list(self.people.values())
        around = ObjectList.of(
            id=np.arange(11, 11 + len(people)),
            kind=[each.kind for each in people],
            x=[ego.x + each.ahead for each in people],
            y=ego.y,
            yaw=0.0,
            speed=[each.speed for each in people],
            acceleration=0.0,
            yaw_rate=0.0,
            length=4.6,
            width=1.8,
        )
        gaps = np.array([each.gap for each in people])
        visible = np.array([each.seen for each in people], dtype=bool)
        return Observation(around.select(visible), around, tuple(self.people), gaps, gaps.min(initial=math.inf))


@dataclass
class Recorder:
    """Takes the place of the rules for drivers and stand-offs; remembers what it was asked."""

    answer: list = field(default_factory=list)
    waiting: object = "who waits"
    asked: list = field(default_factory=list)

    def step(self, *arguments):
        self.asked.append(arguments)
        return self.answer


def road(goal=290.0, stages=1):
    x = np.linspace(0.0, LENGTH, 31)
    lanes = tuple(Stage(x, np.full_like(x, 3.2 * lane), np.full_like(x, 20.0)) for lane in range(stages))
    return Route("t", 4.6, 1.8, goal, 60.0, lanes, (Window(0.0, LENGTH),) * (stages - 1), ())


def simulation(*people, speed=8.0, position=100.0, time_limit=60.0, stages=1, cleared=()):
    """A simulation at its tick 7, the ego on a straight road to the east."""
    made = object.__new__(Simulation)
    made._impacts = Impacts(())
    made.scenario = SimpleNamespace(ego=SimpleNamespace(length=4.6, width=1.8), time_limit=time_limit)
    made._follower = RouteFollower(road(stages=stages), position)
    made._dynamics = SimpleNamespace(speed=speed)
    made._participants = Crowd(people)
    made._courtesy, made._stand_off = Recorder(), Recorder(list(cleared))
    made._script = SimpleNamespace(heedless={"who heeds nothing"}, held={"who is slow": 0.5})
    made._built = SimpleNamespace(signals=())
    made._tick, made._last_yaw, made._final, made._seen = TICK, 0.0, None, None
    return made


def judge(*people, events=(), **circumstances):
    return simulation(*people, **circumstances)._observe(events)


def test_an_ordinary_tick_goes_on():
    before = Event(0.0, EventKind.STARTED, "begun")
    hidden = Somebody("hidden", 2.0, seen=False)
    tick = judge(Somebody("v1", 3.0), hidden, events=(before,))
    assert (tick.number, tick.final, tick.events) == (TICK, None, (before,))
    assert tick.min_distance == 2.0
    assert tick.scene.time == pytest.approx(TIME)
    assert tick.scene.time == TICK * 50_000_000 * 1e-9
    assert tick.scene.objects.id.tolist() == [11]
    assert tick.scene.signals.tolist() == []


def test_the_ego_is_seen_where_it_is():
    ego = judge(speed=8.0, position=123.0).scene.ego
    assert (ego.x, ego.y, ego.yaw, ego.speed) == (123.0, 0.0, 0.0, 8.0)
    assert (ego.length, ego.width, ego.yaw_rate) == (4.6, 1.8, 0.0)


@pytest.mark.parametrize(
    ("before", "now", "rate"), [(0.0, 0.02, 0.4), (0.1, -0.1, -4.0), (3.13, -3.13, 0.4637), (-3.13, 3.13, -0.4637)]
)
def test_the_yaw_rate_is_the_turn_of_a_twentieth_of_a_second(before, now, rate):
    made = simulation()
    made._last_yaw, made._follower.yaw = before, now
    assert made._observe(()).scene.ego.yaw_rate == pytest.approx(rate, abs=1e-4)
    assert made._observe(()).scene.ego.yaw_rate == 0.0


@pytest.mark.parametrize(("gap", "met"), [(-0.1, True), (0.0, True), (1e-6, False), (0.5, False)])
def test_outlines_that_touch_collide(gap, met):
    tick = judge(Somebody("v1", 4.0), Somebody("v2", gap))
    assert (tick.final is not None) is met
    if met:
        assert tick.final.kind is EventKind.COLLISION
        assert tick.final.time == tick.scene.time
        assert tick.final.object_names == ("v2",)
        assert tick.final.object_ids == (12,)
        assert tick.final.object_kinds == (ObjectKind.CAR,)
        assert tick.final.impact_speed == 8.0


@pytest.mark.parametrize("kind", [ObjectKind.PEDESTRIAN, ObjectKind.CAR, ObjectKind.BICYCLE])
@pytest.mark.parametrize("speed", [0.0, 0.04, 0.05, 0.0501, 0.06, 3.0])
def test_who_walks_into_the_standing_ego_has_not_been_hit(speed, kind):
    tick = judge(Somebody("w", 0.0, kind), speed=speed)
    met = speed > 0.05 or kind is not ObjectKind.PEDESTRIAN
    assert (tick.final is not None) is met


def test_all_that_are_hit_at_once_are_named_in_their_order():
    people = (Somebody("a", 1.0), Somebody("b", 0.0), Somebody("c", -0.2), Somebody("w", 0.0, ObjectKind.PEDESTRIAN))
    assert judge(*people).final.object_names == ("b", "c", "w")
    assert judge(*people).final.object_ids == (12, 13, 14)
    assert judge(*people).final.object_kinds == (ObjectKind.CAR, ObjectKind.CAR, ObjectKind.PEDESTRIAN)
    assert judge(*people, speed=0.0).final.object_names == ("b", "c")


@pytest.mark.parametrize(
    ("ahead", "speed", "blame"),
    [(4.0, 5.0, Blame.FRONT), (-4.0, 9.0, Blame.REAR), (4.0, 0.0, Blame.OTHER_STOOD)],
)
def test_the_blame_is_found_for_the_one_that_was_hit(ahead, speed, blame):
    tick = judge(Somebody("v1", 30.0, speed=0.0, ahead=30.0), Somebody("v2", 0.0, speed=speed, ahead=ahead))
    assert tick.final.blame is blame


def test_a_contact_from_behind_is_the_egos_fault_while_it_changes_lanes():
    made = simulation(Somebody("v1", 0.0, speed=9.0, ahead=-4.0), stages=2)
    assert made._follower.begin_change(8.0)
    assert made._observe(()).final.blame is Blame.CHANGING


@pytest.mark.parametrize(
    ("position", "kind"), [(289.9, None), (290.0, EventKind.GOAL), (300.4, EventKind.GOAL), (310.0, EventKind.GOAL)]
)
def test_the_goal_ends_it(position, kind):
    tick = judge(position=position)
    assert (tick.final.kind if tick.final else None) is kind
    if tick.final is not None:
        assert tick.final.time == tick.scene.time


def test_the_end_of_a_lane_that_is_not_the_last_ends_it():
    assert judge(position=300.4, stages=2).final is None
    tick = judge(position=300.6, stages=2)
    assert tick.final.kind is EventKind.OFF_ROUTE
    assert tick.final.time == tick.scene.time


@pytest.mark.parametrize(
    ("limit", "over"),
    [(0.3, True), (TIME, True), (TIME + 0.9e-9, True), (TIME + 1.03e-9, False), (0.4, False), (60.0, False)],
)
def test_the_time_limit_ends_it(limit, over):
    tick = judge(time_limit=limit)
    assert (tick.final is not None) is over
    if over:
        assert tick.final.kind is EventKind.TIMEOUT
        assert tick.final.time == tick.scene.time


def test_of_several_ends_the_gravest_counts():
    contact = Somebody("v1", 0.0)
    assert judge(contact, position=295.0, time_limit=0.1).final.kind is EventKind.COLLISION
    assert judge(position=295.0, time_limit=0.1).final.kind is EventKind.GOAL
    assert judge(position=301.0, time_limit=0.1, stages=2).final.kind is EventKind.OFF_ROUTE


def test_the_end_is_the_last_event_and_stays_the_end():
    before = Event(0.0, EventKind.CHANGE_LANE, "to stage 1")
    made = simulation(Somebody("v1", 0.0))
    tick = made._observe((before,))
    assert tick.events == (before, tick.final)
    assert made._final is tick.final


def test_who_blocks_the_ego_for_too_long_is_taken_off_the_road():
    before = Event(0.0, EventKind.CHANGE_LANE, "to stage 1")
    people = (Somebody("v1", 1.0), Somebody("v2", 2.0), Somebody("v3", 3.0))
    tick = judge(*people, cleared=("v3", "v1"), events=(before,))
    assert tick.final is None
    assert tick.events[0] is before
    assert [each.kind for each in tick.events[1:]] == [EventKind.CLEARED] * 2
    assert [each.object_names for each in tick.events[1:]] == [("v3",), ("v1",)]
    assert [each.object_ids for each in tick.events[1:]] == [(13,), (11,)]
    assert [each.object_kinds for each in tick.events[1:]] == [(ObjectKind.CAR,)] * 2
    assert all(each.time == tick.scene.time for each in tick.events[1:])


def test_nobody_is_cleared_once_the_episode_is_over():
    tick = judge(Somebody("v1", 0.0), cleared=("v1",))
    assert [each.kind for each in tick.events] == [EventKind.COLLISION]


def test_the_rules_for_the_others_are_given_what_is_there():
    made = simulation(Somebody("v1", 1.0), Somebody("v2", 2.0, seen=False), position=120.0)
    tick = made._observe(())
    ego, seen = tick.scene.ego, made.seen
    assert seen.names == ("v1", "v2")
    assert seen.objects is tick.scene.objects
    assert made._courtesy.asked == [(ego, seen.names, seen.around, {"who heeds nothing"}, {"who is slow": 0.5})]
    ((stander, way, names, around, waiting),) = made._stand_off.asked
    assert (stander, names, around, waiting) == (ego, seen.names, seen.around, "who waits")
    assert way(15.0) == pytest.approx((135.0, 0.0, 0.0))  # the pose that far ahead on the ego's lane
