"""What a bag shows of a fault, on ticks made for the purpose and on a bag that was recorded without one."""

import json
from pathlib import Path

import numpy as np
import pytest

from roadmend.core.command import Command
from roadmend.core.outcome import Event, EventKind
from roadmend.core.repair import Repair, RepairStatus
from roadmend.core.route import Route, Stage
from roadmend.core.scene import EgoState, ObjectList
from roadmend.faults.evidence import Evidence, evidence_of, read_evidence
from roadmend.recording import messages, topics
from roadmend.recording.codec import MessageType, encode, type_of
from roadmend.recording.ticks import BagTick
from roadmend.recording.writer import BagWriter

SAMPLE = Path(__file__).parents[2] / "bags" / "samples" / "repaired"
GO = Command.from_action(0.5)
STEP = 50_000_000


def tick(place, *, command=GO, driven=GO, status=RepairStatus.PASS, speed=8.0, events=()):
    return BagTick(
        place * STEP,
        ego=EgoState.from_yaw(0.0, 0.0, 0.0, speed, 0.0, 4.8, 1.8),
        objects=ObjectList.empty(),
        command=command,
        driven=driven,
        repair=Repair(GO, status, 0.0, 0.0, 0.5, 0.5, intervened=False),
        events=list(events),
    )


def test_a_bag_without_a_fault_shows_none():
    evidence = read_evidence(SAMPLE, None, None, None)
    assert evidence.ticks > 100
    assert (evidence.lost, evidence.silence, evidence.to_state) == (0, None, None)


def test_the_longest_silence_of_the_policy_counts_and_the_state_that_follows():
    ticks = [tick(place) for place in range(30)]
    ticks[5] = tick(5, command=None)  # one that a busy machine has missed
    for place in range(10, 20):
        status = RepairStatus.STALE_COMMAND if place >= 12 else RepairStatus.PASS
        ticks[place] = tick(place, command=None, status=status, speed=0.0 if place >= 16 else 5.0)
    evidence = evidence_of(ticks, "policy", "STALE_COMMAND", None)
    assert evidence.silence == pytest.approx(0.5)
    assert evidence.to_state == pytest.approx(0.1)
    assert evidence.to_standstill == pytest.approx(0.3)
    assert evidence.lost == 0


def test_a_state_that_was_never_declared_is_told_as_none():
    ticks = [tick(place, command=None if place > 10 else GO) for place in range(30)]
    evidence = evidence_of(ticks, "policy", "STALE_COMMAND", None)
    assert evidence.silence == pytest.approx(0.55)
    assert evidence.to_state is None


def test_what_came_before_the_first_answer_and_the_last_tick_are_no_silence():
    ticks = [tick(place, driven=GO if 5 <= place < 29 else None) for place in range(30)]
    assert evidence_of(ticks, "repair", "WATCHDOG", None).silence is None


def test_an_event_declares_too():
    ticks = [tick(place, driven=GO if place < 10 else None) for place in range(30)]
    ticks[13].events.append(Event(0.65, EventKind.WATCHDOG, ""))
    assert evidence_of(ticks, "repair", "WATCHDOG", None).to_state == pytest.approx(0.15)


def test_ticks_that_are_missing_in_the_middle_or_at_the_end_are_lost_twice_an_ego_and_a_list():
    ticks = [tick(place) for place in range(30) if place not in {7, 8}]
    assert evidence_of(ticks, None, None, None).lost == 4
    assert evidence_of(ticks, None, None, 39 * 0.05).lost == 4 + 20


def test_a_state_of_ticks_that_were_answered_late_is_declared_all_the_same():
    status = [RepairStatus.STALE_COMMAND if 10 <= place < 20 else RepairStatus.PASS for place in range(30)]
    late = [tick(place, status=status[place]) for place in range(30)]
    assert evidence_of(late, "policy", "STALE_COMMAND", None).is_declared
    assert not evidence_of([tick(place) for place in range(30)], "policy", "STALE_COMMAND", None).is_declared


def test_where_messages_were_distorted_the_first_of_them_is_the_moment():
    ticks = [tick(place) for place in range(30)]
    ticks[8] = tick(8, status=RepairStatus.INVALID_COMMAND)
    ticks[13] = tick(13, status=RepairStatus.INVALID_COMMAND)
    evidence = evidence_of(ticks, None, "INVALID_COMMAND", None, touched=[12 * STEP])
    assert evidence.silence == pytest.approx(0.6)
    assert evidence.to_state == pytest.approx(0.05)


def test_what_a_message_held_need_not_be_said_of_ticks_that_were_stopped_for_want_of_another():
    ticks = [tick(place) for place in range(30)]
    for place in range(12, 20):
        status = RepairStatus.STALE_OBJECTS if place < 16 else RepairStatus.PASS
        ticks[place] = tick(place, status=status)
    ticks[18] = tick(18, status=RepairStatus.INVALID_OBJECTS)
    touched = [place * STEP for place in range(12, 20)]
    assert evidence_of(ticks, None, "INVALID_OBJECTS", None, touched).to_state == pytest.approx(0.1)
    assert evidence_of(ticks, None, "STALE_OBJECTS", None, [11 * STEP]).to_state == pytest.approx(0.05)
    assert evidence_of(ticks, None, "INVALID_COMMAND", None, touched).to_state is None


def test_nor_of_ticks_between_those_that_were_disturbed():
    ticks = [tick(place) for place in range(30)]
    ticks[12] = tick(12, status=RepairStatus.STALE_COMMAND)
    ticks[17] = tick(17, status=RepairStatus.MODEL_FAULT)
    evidence = evidence_of(ticks, None, "MODEL_FAULT", None, [12 * STEP, 17 * STEP])
    assert (evidence.silence, evidence.to_state) == (pytest.approx(0.6), 0.0)
    assert evidence.meanwhile == ()


def test_the_states_until_the_one_that_was_asked_for_are_told():
    ticks = [tick(place) for place in range(30)]
    ticks[13] = tick(13, status=RepairStatus.STALE_COMMAND)
    ticks[14] = tick(14, status=RepairStatus.MODEL_FAULT)
    evidence = evidence_of(ticks, None, "MODEL_FAULT", None, [12 * STEP])
    assert evidence.meanwhile == ("PASS", "STALE_COMMAND")
    assert Evidence.parse(json.loads(json.dumps(evidence.as_dict()))) == evidence


def test_a_state_that_graver_ones_hid_at_every_tick_was_not_declared():
    ticks = [
        tick(place, status=RepairStatus.STALE_COMMAND if place >= 12 else RepairStatus.PASS) for place in range(30)
    ]
    evidence = evidence_of(ticks, None, "INVALID_COMMAND", None, [place * STEP for place in range(12, 20)])
    assert (evidence.silence, evidence.to_state) == (pytest.approx(0.6), None)
    assert set(evidence.meanwhile) == {"STALE_COMMAND"}


@pytest.mark.parametrize(("kinds", "to_state"), [(["WATCHDOG"], 0.0), (["WATCHDOG", "RECOVERED"], None)])
def test_a_watchdog_that_brakes_already_does_not_say_it_again(kinds, to_state):
    ticks = [tick(place, driven=GO if place < 10 else None) for place in range(30)]
    for place, kind in enumerate(kinds, 5):
        ticks[place].events.append(Event(0.05 * place, EventKind[kind], ""))
    assert evidence_of(ticks, "repair", "WATCHDOG", None).to_state == to_state


def test_where_nothing_was_disturbed_for_long_enough_there_is_no_moment():
    evidence = evidence_of([tick(place) for place in range(30)], None, "STALE_COMMAND", None, [])
    assert (evidence.silence, evidence.to_state) == (None, None)


def test_a_run_without_a_fault_has_warned_of_nothing():
    assert not read_evidence(SAMPLE, None, None, None).in_diagnostics


@pytest.mark.parametrize("warned_at", [0, 3, 4, 8])
def test_only_what_was_warned_of_after_the_drive_had_begun_counts(tmp_path, warned_at):
    x = np.array([0.0, 500.0])
    route = Route("test", 4.7, 1.85, 480.0, 60.0, (Stage(x, 0.0 * x, np.full(2, 15.0)),), (), ())
    array, status = (MessageType(f"diagnostic_msgs/msg/Diagnostic{kind}") for kind in ("Array", "Status"))
    with BagWriter(tmp_path / "bag") as writer:

        def write(topic, place, message):
            writer.add_topic(f"/{topic.lstrip('/')}", type_of(message))
            writer.write(f"/{topic.lstrip('/')}", place * STEP, encode(message))

        write(topics.ROUTE, 0, messages.route_message_of(route, messages.header_at(0)))
        for place in range(10):
            header = messages.header_at(place * STEP)
            write(topics.EGO, place, messages.ego_message_of(tick(place).ego, header))
            write(topics.OBJECTS, place, messages.OBJECTS(header=header))
            if place >= 4:  # until then it is held
                write(topics.POLICY_COMMAND, place, messages.command_message_of(GO, header))
                write(topics.REPAIR_COMMAND, place, messages.command_message_of(GO, header))
            level = 2 if place == warned_at else 0
            said = status(name="/repair_node", level=level, message="controlled stop")
            write(topics.DIAGNOSTICS, place, array(status=[said]))
    evidence = read_evidence(tmp_path / "bag", None, None, None)
    assert evidence.begun == pytest.approx(0.2)
    assert evidence.in_diagnostics == (warned_at >= 4)


def test_while_the_vehicle_is_held_at_the_start_nobody_drives_whoever_answers_late():
    ticks = [tick(place, status=RepairStatus.STARTING if place < 7 else RepairStatus.PASS) for place in range(30)]
    assert evidence_of(ticks, "policy", "STALE_COMMAND", None).begun == pytest.approx(0.35)
