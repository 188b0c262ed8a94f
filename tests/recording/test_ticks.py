"""A recorded episode tick by tick."""

from types import SimpleNamespace

import numpy as np
import pytest

from roadmend.core.errors import InputError
from roadmend.core.outcome import Blame, Event, EventKind
from roadmend.core.scene import ObjectKind
from roadmend.recording import ticks as bag_ticks
from roadmend.recording.encoder import Encoder
from roadmend.recording.reader import BagReader
from roadmend.recording.ticks import BagTicks
from roadmend.recording.values import event_of
from roadmend.recording.writer import BagWriter

TICK_NS = 50_000_000
NONE = SimpleNamespace(x=0.0, y=0.0, z=0.0, w=1.0)
NAMED = SimpleNamespace(
    position=NONE, orientation=NONE, linear=SimpleNamespace(x=8.0, y=0.0, z=0.0), angular=SimpleNamespace(x=0, y=0, z=0)
)
EGO = SimpleNamespace(
    child_frame_id="base_link",
    pose=SimpleNamespace(pose=NAMED, covariance=np.zeros(36)),
    twist=SimpleNamespace(twist=NAMED, covariance=np.zeros(36)),
)
COLUMNS = ("x", "y", "yaw", "speed", "acceleration", "yaw_rate", "length", "width")


def objects(count, ids=None):
    columns = {name: np.full(count, 2.0) for name in COLUMNS}
    return SimpleNamespace(id=[*range(count if ids is None else ids)], kind=[1] * count, signal=[2], **columns)


def route(begin=0):
    lists = {"change_begin", "change_end", "zone_stage", "zone_begin", "zone_end", "zone_rule", "zone_signal"}
    return SimpleNamespace(
        scenario="straight",
        ego_length=4.0,
        ego_width=1.7,
        goal=90.0,
        time_limit=9.0,
        stage_begin=[begin],
        x=[0.0, 100.0],
        y=[0.0, 0.0],
        speed_limit=[9.0, 9.0],
        **dict.fromkeys(lists, ()),
    )


COMMAND = SimpleNamespace(throttle=0.5, brake=0.0, change_lane=True)
PLAN = SimpleNamespace(interval=0.5, x=[1.0], y=[0.0], yaw=[0.0], speed=[8.0], behaviour="follow")
TYPES = {
    "ego": "nav_msgs/msg/Odometry",
    "objects": "roadmend_msgs/msg/ObjectList",
    "route": "roadmend_msgs/msg/Route",
    "policy/command": "roadmend_msgs/msg/Command",
    "policy/trajectory": "roadmend_msgs/msg/Trajectory",
    "events": "roadmend_msgs/msg/ScenarioEvent",
}


@pytest.fixture
def bag(tmp_path):
    """Writes messages given as (topic, tick, content), or (topic, tick, content, tick at which it arrived)."""
    encoder = Encoder()

    def write(*messages, prefix=""):
        with BagWriter(tmp_path / "bag") as writer:
            for short, tick, content, *late in messages:
                stamp = SimpleNamespace(sec=tick * TICK_NS // 10**9, nanosec=tick * TICK_NS % 10**9)
                message = SimpleNamespace(header=SimpleNamespace(stamp=stamp, frame_id="map"), **vars(content))
                writer.add_topic(f"{prefix}/{short}", TYPES[short])
                data = encoder.encode(TYPES[short], message)
                writer.write(f"{prefix}/{short}", (late or [tick])[0] * TICK_NS, data)
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
    messages = [(short, tick, one) for tick in range(100) for short, one in (("ego", EGO), ("objects", objects(1)))]
    ticks = bag(("route", 0, route()), *messages)
    read = []
    monkeypatch.setattr(bag_ticks, "ego_of", read.append)
    for number, tick in enumerate(ticks):
        assert tick.stamp == number * TICK_NS
        assert len(read) - number <= 23


def test_topics_in_a_namespace_are_found(bag):
    ticks = bag(("route", 0, route()), ("ego", 0, EGO), ("objects", 0, objects(1)), prefix="/car")
    assert ticks.namespace == "/car"
    assert len(list(ticks)) == 1


def test_unusable_objects_are_none_but_an_unusable_route_ends_it(bag):
    broken = ("objects", 0, objects(2, ids=3))
    (tick,) = bag(("route", 0, route()), ("ego", 0, EGO), broken)
    assert tick.objects is tick.signals is None


def test_a_route_whose_rule_is_unknown_is_refused(bag):
    wrong = SimpleNamespace(
        **vars(route())
        | {"zone_stage": [0], "zone_begin": [1.0], "zone_end": [2.0], "zone_rule": [99], "zone_signal": [-1]}
    )
    with pytest.raises(InputError, match=r"/route at 0\.00 s: 99 is not a valid RightOfWay"):
        list(bag(("route", 0, wrong), ("ego", 0, EGO), ("objects", 0, objects(1))))


def test_the_final_event_is_told(bag):
    contact = {"object_id": [7], "object_name": ["bus_1"], "object_kind": [3], "blame": 4, "impact_speed": 6.5}
    event, other = (SimpleNamespace(kind=kind, text=text, **contact) for kind, text in ((2, "hit bus_1"), (99, "")))
    first, last = bag(
        ("route", 0, route()), ("ego", 0, EGO), ("objects", 0, objects(1)), ("events", 0, other), ("events", 1, event)
    )
    assert first.final is None
    assert last.final == Event(
        0.05, EventKind.COLLISION, "hit bus_1", (7,), ("bus_1",), (ObjectKind.BUS,), Blame.REAR, 6.5
    )


def test_bags_of_earlier_versions_do_not_say_who_is_to_blame():
    stamp = SimpleNamespace(sec=1, nanosec=0)
    value = SimpleNamespace(header=SimpleNamespace(stamp=stamp), kind=2, object_id=[7], object_name=["a"], text="hit a")
    assert event_of(value) == Event(1.0, EventKind.COLLISION, "hit a", (7,), ("a",))


def test_a_bag_without_an_episode_is_refused(bag):
    with pytest.raises(InputError, match="holds no ego and no route; name a bag that an episode was recorded into"):
        bag(("objects", 0, objects(1)))
