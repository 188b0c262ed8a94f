"""A recorded episode tick by tick."""

from dataclasses import replace

import numpy as np
import pytest

from roadmend.core.command import Command, Trajectory
from roadmend.core.errors import InputError
from roadmend.core.outcome import Blame, Event, EventKind
from roadmend.core.repair import Repair, RepairStatus, RepairTrigger
from roadmend.core.scene import EgoState, ObjectKind
from roadmend.recording import messages, topics
from roadmend.recording.codec import encode, type_of
from roadmend.recording.reader import BagReader
from roadmend.recording.ticks import BagTicks
from roadmend.recording.writer import BagWriter

TICK_NS = 50_000_000
COLUMNS = ("x", "y", "yaw", "speed", "acceleration", "yaw_rate", "length", "width")
EGO = messages.ego_message_of(EgoState.from_yaw(0.0, 0.0, 0.0, 8.0, 0.0, 4.7, 1.85), None)
COMMAND = messages.command_message_of(Command(0.5, 0.0, change_lane=True), None)
PLAN = messages.trajectory_message_of(Trajectory(0.5, *np.ones((4, 1)), "follow"), None)


def objects(count, ids=None):
    return messages.OBJECTS(
        id=np.arange(count if ids is None else ids, dtype=np.uint32),
        kind=np.ones(count, dtype=np.uint8),
        signal=np.array([2], dtype=np.uint8),
        **{name: np.full(count, 2.0) for name in COLUMNS},
    )


def route(**fields):
    x = np.array([0.0, 100.0])
    limit = np.full(2, 9.0)
    stage = {"stage_begin": np.zeros(1, dtype=np.uint32), "x": x, "y": np.zeros(2), "speed_limit": limit}
    size = {"ego_length": 4.0, "ego_width": 1.7}
    return messages.ROUTE(scenario="straight", goal=90.0, time_limit=9.0, **stage, **size, **fields)


@pytest.fixture
def bag(tmp_path):
    """Writes messages given as (topic, tick, content), or (topic, tick, content, tick at which it arrived)."""

    def write(*given, prefix=""):
        with BagWriter(tmp_path / "bag") as writer:
            for short, tick, content, *late in given:
                message = replace(content, header=messages.header_at(tick * TICK_NS))
                writer.add_topic(f"{prefix}/{short}", type_of(message))
                writer.write(f"{prefix}/{short}", (late or [tick])[0] * TICK_NS, encode(message))
        return BagTicks(BagReader(tmp_path / "bag"))

    return write


def test_what_belongs_to_one_stamp_is_one_tick_even_if_it_came_late(bag):
    ticks = list(
        bag(
            ("route", 0, route()),
            ("ego", 0, EGO),
            ("objects", 0, objects(2)),
            ("policy/command", 0, COMMAND, 3),
            ("ego", 1, EGO),
            ("objects", 1, objects(1)),
            ("policy/trajectory", 0, PLAN, 3),
            ("ego", 4, EGO),
        )
    )
    assert [tick.stamp for tick in ticks] == [0, TICK_NS, 4 * TICK_NS]
    first, second, third = ticks
    scene, decision = first.scene(first.route), first.decision
    assert (scene.ego.length, scene.ego.speed, len(scene.objects), scene.signals.tolist()) == (4.0, 8.0, 2, [2])
    assert (decision.command.throttle, decision.command.change_lane, len(decision.trajectory)) == (0.5, True, 1)
    assert second.scene(first.route).time == 0.05
    assert second.decision is third.scene(first.route) is None


def test_only_a_second_of_ticks_is_held_at_once(bag, monkeypatch):
    given = [(short, tick, one) for tick in range(100) for short, one in (("ego", EGO), ("objects", objects(1)))]
    ticks = bag(("route", 0, route()), *given)
    read = []
    monkeypatch.setattr(messages, "ego_of", read.append)
    for number, tick in enumerate(ticks):
        assert tick.stamp == number * TICK_NS
        assert len(read) - number <= 23


def test_topics_in_a_namespace_are_found(bag):
    ticks = bag(("route", 0, route()), ("ego", 0, EGO), ("objects", 0, objects(1)), prefix="/car")
    assert ticks.namespace == "/car"
    assert len(list(ticks)) == 1


def test_the_answers_of_a_shadow_are_not_what_was_driven_where_there_are_no_others(bag):
    done = Repair(Command(0.0, 0.6), RepairStatus.REPAIRED, 0.8, 0.5, 0.3, -0.6, True, 2, (), "7 ahead", 0.5)
    ticks = bag(
        ("route", 0, route()),
        ("ego", 0, EGO),
        ("objects", 0, objects(1)),
        ("shadow/repair/state", 0, messages.repair_message_of(done, "rss", None)),
        ("shadow/repair/command", 0, messages.command_message_of(done.command, None)),
    )
    (tick,) = ticks
    assert tick.repair is tick.driven is None
    assert topics.REPAIR_STATE not in ticks.topics


def test_unusable_objects_are_none_but_an_unusable_route_ends_it(bag):
    broken = ("objects", 0, objects(2, ids=3))
    (tick,) = bag(("route", 0, route()), ("ego", 0, EGO), broken)
    assert tick.objects is tick.signals is None


def test_bytes_that_are_no_message_are_absent_but_a_route_of_them_ends_it(bag, tmp_path):
    bag(("route", 0, route()), ("ego", 0, EGO), ("objects", 0, objects(1)), ("policy/command", 0, COMMAND))
    for spoilt in ("policy/command", "route"):
        with BagWriter(tmp_path / spoilt.replace("/", "-")) as writer:
            for record in BagReader(tmp_path / "bag").records(None):
                writer.add_topic(record.topic, record.type_name)
                cut = len(record.data) // 2 if record.topic == f"/{spoilt}" else len(record.data)
                writer.write(record.topic, record.time_ns, record.data[:cut])
    (tick,) = BagTicks(BagReader(tmp_path / "policy-command"), ("ego",))
    assert tick.command is None
    assert tick.ego is not None
    with pytest.raises(InputError, match="is not a roadmend_msgs/msg/Route"):
        list(BagTicks(BagReader(tmp_path / "route"), ("ego",)))


def test_a_route_whose_rule_is_unknown_is_refused(bag):
    zone = {"zone_stage": np.zeros(1, np.uint32), "zone_begin": np.ones(1), "zone_end": np.full(1, 2.0)}
    wrong = route(**zone, zone_rule=np.full(1, 99, np.uint8), zone_signal=np.full(1, -1, np.int32))
    with pytest.raises(InputError, match=r"/route at 0\.00 s: 99 is not a valid RightOfWay"):
        list(bag(("route", 0, wrong), ("ego", 0, EGO), ("objects", 0, objects(1))))


def test_the_final_event_is_told(bag):
    who = (7,), ("bus_1",), (ObjectKind.BUS,)
    contact = Event(0.05, EventKind.COLLISION, "hit bus_1", *who, Blame.REAR, 6.5)
    event = messages.event_message_of(contact)
    other = messages.EVENT(kind=99)
    first, last = bag(
        ("route", 0, route()), ("ego", 0, EGO), ("objects", 0, objects(1)), ("events", 0, other), ("events", 1, event)
    )
    assert first.final is None
    assert last.final == contact


def test_a_bag_without_an_episode_is_refused(bag):
    with pytest.raises(InputError, match="holds no ego and no route; name a bag that an episode was recorded into"):
        bag(("objects", 0, objects(1)))


def test_a_bag_carries_a_repair_without_loss(bag):
    triggers = (RepairTrigger(7, 0.9), RepairTrigger(3, 0.1))
    done = Repair(
        Command(0.0, 0.6, change_lane=True),
        RepairStatus.REPAIRED,
        0.8,
        0.5,
        0.3,
        -0.6,
        True,
        2,
        triggers,
        "7 ahead",
        0.5,
    )
    (tick,) = bag(
        ("route", 0, route()),
        ("ego", 0, EGO),
        ("objects", 0, objects(1)),
        ("repair/state", 0, messages.repair_message_of(done, "rss", None)),
        ("repair/command", 0, messages.command_message_of(done.command, None)),
    )
    assert tick.repair == done
