"""What a relay makes of messages: which are touched, how, and what goes on of them."""

import math

import numpy as np
import pytest

from roadmend.core.command import Command, Trajectory
from roadmend.core.scene import EgoState, ObjectList
from roadmend.core.tick import INTERVAL_NS
from roadmend.faults import distortion as module
from roadmend.faults.distortion import CLOCK, CROWD, Distorter, Distortion, check_distortion
from roadmend.nodes.frame_check import frame_of
from roadmend.recording import messages, topics
from roadmend.recording.codec import encode

PLAN = Trajectory(0.1, *(np.arange(3.0) for _ in range(4)))
EGO = EgoState.from_yaw(1.0, 2.0, 0.1, 5.0, 0.0, 4.8, 1.8)
THREE = ObjectList.of(
    id=[1, 2, 3],
    kind=1,
    x=[1.0, 2.0, 3.0],
    y=0.0,
    yaw=0.0,
    speed=0.0,
    acceleration=0.0,
    yaw_rate=0.0,
    length=4.0,
    width=2.0,
)
SIGNALS = np.empty(0, dtype=np.uint8)
DECODERS = {
    topics.EGO: messages.EGO,
    topics.OBJECTS: messages.OBJECTS,
    topics.POLICY_COMMAND: messages.COMMAND,
    topics.POLICY_TRAJECTORY: messages.TRAJECTORY,
    topics.REPAIR_COMMAND: messages.COMMAND,
}


def message(topic, tick, objects=THREE):
    header = messages.header_at(tick * INTERVAL_NS)
    made = {
        topics.EGO: lambda: messages.ego_message_of(EGO, header),
        topics.OBJECTS: lambda: messages.object_message_of(objects, SIGNALS, header),
        topics.POLICY_TRAJECTORY: lambda: messages.trajectory_message_of(PLAN, header),
    }.get(topic, lambda: messages.command_message_of(Command(0.4, 0.0, change_lane=True), header))
    return encode(made())


def passed(topic, name, tick=5, objects=THREE, **more):
    distorter = Distorter(Distortion(name, 5, 3, **more))
    return [*distorter.pass_on(topic, message(topic, tick, objects))], distorter


@pytest.mark.parametrize("topic", DECODERS)
@pytest.mark.parametrize("tick", [4, 8])
def test_before_it_begins_and_when_it_is_over_a_message_is_what_it_was(topic, tick):
    for name in [*module._CHANGES[topic], *module._ANY]:
        assert passed(topic, name, tick)[0] == [message(topic, tick)]


@pytest.mark.parametrize(("topic", "name"), [(topic, name) for topic in DECODERS for name in module._CHANGES[topic]])
@pytest.mark.parametrize("objects", [THREE, ObjectList.empty()])
def test_each_change_makes_another_message_with_the_same_stamp(topic, name, objects):
    (data,), distorter = passed(topic, name, objects=objects)
    assert data != message(topic, 5, objects)
    assert messages.stamp_of_bytes(data) == distorter.first == 5 * INTERVAL_NS
    DECODERS[topic].decode(data)
    assert distorter.touched == 1


def test_what_the_changes_are():
    def changed(topic, name):
        return DECODERS[topic].decode(passed(topic, name)[0][0])

    assert math.isnan(changed(topics.POLICY_COMMAND, "nan").throttle)
    both = changed(topics.POLICY_COMMAND, "both_pedals")
    assert min(both.throttle, both.brake) > 0.0
    assert changed(topics.OBJECTS, "duplicate_ids").id.tolist() == [1, 2, 3, 1, 2, 3]
    assert len(changed(topics.OBJECTS, "crowd").id) == CROWD + 3
    assert len(set(changed(topics.OBJECTS, "crowd").id.tolist())) == CROWD + 3
    assert len(changed(topics.OBJECTS, "unequal").yaw) == 2
    assert math.isnan(changed(topics.EGO, "nan").pose.pose.position.x)


def test_frames_stamps_and_bytes():
    (foreign,), _ = passed(topics.EGO, "foreign_frame")
    assert frame_of(foreign) == module.FOREIGN_FRAME
    (ahead,), _ = passed(topics.EGO, "ahead")
    assert messages.stamp_of_bytes(ahead) == 5 * INTERVAL_NS + module.FAR_AHEAD_NS
    assert messages.EGO.decode(ahead).pose.pose.position.x == 1.0
    (cut,), _ = passed(topics.POLICY_COMMAND, "cut")
    with pytest.raises(ValueError, match="the bytes are no"):
        messages.COMMAND.decode(cut)
    (short,), distorter = passed(topics.POLICY_COMMAND, "short")
    with pytest.raises(ValueError, match="4 bytes are too few for a header"):
        messages.stamp_of_bytes(short)
    assert distorter.first == 5 * INTERVAL_NS
    assert passed(topics.POLICY_COMMAND, "silent")[0] == []


def test_what_is_late_comes_in_order_when_its_time_has_come():
    distorter = Distorter(Distortion("late", 5, 3, late=2))
    came = [
        [messages.stamp_of_bytes(data) // INTERVAL_NS for data in distorter.pass_on("ego", message("ego", tick))]
        for tick in range(4, 12)
    ]
    assert came == [[4], [], [], [5], [6, 8], [7, 9], [10], [11]]


def test_a_share_is_about_that_share_and_the_same_every_time():
    def touched(seed):
        distorter = Distorter(Distortion("silent", 0, 1000, share=0.3, seed=seed))
        return [not distorter.pass_on("ego", message("ego", tick)) for tick in range(1000)]

    assert 250 < sum(touched(1)) < 350
    assert touched(1) == touched(1) != touched(2)


def test_the_first_so_many_in_a_row_are_where_a_distorter_touches_them():
    what = Distortion("silent", 10, 200, share=0.5, seed=3)
    distorter = Distorter(what)
    touched = [not distorter.pass_on("ego", message("ego", tick)) for tick in range(220)]
    for length in (1, 2, 3):
        first = what.first_in_a_row("ego", length)
        rows = [place for place in range(220) if all(touched[place : place + length])]
        assert first == rows[0]
    assert what.first_in_a_row("ego", 201) is None


@pytest.mark.parametrize("shift", [10.0, -0.2])
def test_a_clock_that_jumps_goes_on_from_there_and_answers_find_their_way_back(shift):
    distorter = Distorter(Distortion("jump", 5, shift=round(shift * 1e9)))
    for tick in range(12):
        (data,) = distorter.pass_on("ego", message("ego", tick))
        moved = messages.stamp_of_bytes(data)
        assert moved == tick * INTERVAL_NS + (round(shift * 1e9) if tick >= 5 else 0)
        (answer,) = distorter.pass_on(topics.REPAIR_COMMAND, module.stamped(message(topics.REPAIR_COMMAND, 0), moved))
        assert messages.stamp_of_bytes(answer) == tick * INTERVAL_NS
    assert distorter.first == round(shift * 1e9) + 5 * INTERVAL_NS


@pytest.mark.parametrize(
    ("topic", "name", "what"),
    [
        ("egos", "nan", "topic: 'egos' is none of ego"),
        ("ego", "both_pedals", "none of those of ego"),
        ("ego", "stranger", "none of those"),
        (CLOCK, "nan", "of clock: jump"),
    ],
)
def test_what_cannot_be_distorted_so_is_named(topic, name, what):
    with pytest.raises(ValueError, match=what):
        check_distortion(topic, name)
