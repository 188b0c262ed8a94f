"""Accounts of spells from a file that is read once, from front to back."""

from dataclasses import replace

import numpy as np
import pytest

from roadmend.core.command import Command
from roadmend.core.outcome import Event, EventKind
from roadmend.core.repair import Repair, RepairStatus, RepairTrigger
from roadmend.core.route import Route, Stage
from roadmend.core.scene import OBJECT, EgoState, ObjectList
from roadmend.recording import messages
from roadmend.recording.codec import encode, type_of
from roadmend.recording.episode import read_episode
from roadmend.recording.info import bag_info
from roadmend.recording.writer import BagWriter

TICK_NS = 50_000_000
EGO = messages.ego_message_of(EgoState.from_yaw(0.0, 0.0, 0.0, 8.0, 0.0, 4.0, 2.0), None)
ROUTE = messages.route_message_of(
    Route("straight", 6.0, 2.0, 90.0, 9.0, (Stage(np.array([0.0, 99.0]), np.zeros(2), np.full(2, 9.0)),), (), ()), None
)
END = messages.event_message_of(Event(0.2, EventKind.GOAL, "there"))


def objects(x):
    table = ObjectList(np.zeros(1, dtype=OBJECT)).with_columns(id=7, kind=1, x=x, length=4.0, width=2.0)
    return messages.object_message_of(table, np.zeros(0, dtype=np.uint8), None)


def state(final=-0.4, worth=0.3):
    triggers = (RepairTrigger(7, 1.0),)
    done = Repair(
        Command.from_action(final),
        RepairStatus.REPAIRED,
        0.9,
        0.5,
        0.5,
        final,
        final != 0.5,
        0,
        triggers,
        "near",
        worth,
    )
    return messages.repair_message_of(done, "rss", None)


@pytest.fixture
def accounts(tmp_path):
    """Of messages given as (topic, tick, content), or with their bytes changed by a fourth."""

    def of(*given):
        with BagWriter(tmp_path / "bag") as writer:
            for topic, tick, content, *change in given:
                message = replace(content, header=messages.header_at(tick * TICK_NS))
                data = encode(message)
                writer.add_topic(topic, type_of(message))
                writer.write(topic, tick * TICK_NS, change[0](data) if change else data)
        found = bag_info(tmp_path / "bag").spells
        return [(round(one.spell.begin / 0.05), one.spell.ticks, one.worth, one.who[0].words) for one in found]

    return of


def test_what_was_seen_is_that_of_the_first_tick_whatever_comes_first(accounts, tmp_path):
    told = accounts(
        ("/route", 0, ROUTE),
        ("/repair/state", 1, state()),
        ("/objects", 1, objects(25.0)),
        ("/ego", 1, EGO),
        ("/ego", 2, EGO),
        ("/objects", 2, objects(15.0)),
        ("/repair/state", 2, state(-0.8, 0.9)),
        ("/repair/state", 3, state(0.5)),
    )
    assert told == [(1, 2, 0.3, "car 7 ahead, 20 m")]  # from an ego of 6 m, as the route has it
    assert read_episode(tmp_path / "bag").spells() == bag_info(tmp_path / "bag").spells


def test_a_tick_without_objects_tells_the_number_alone(accounts):
    assert accounts(("/ego", 1, EGO), ("/repair/state", 1, state())) == [(1, 1, 0.3, "7")]


def test_objects_that_were_altered_tell_the_number_alone(accounts):
    cut = ("/objects", 1, objects(25.0), lambda data: data[:-9])
    assert accounts(("/ego", 1, EGO), cut, ("/repair/state", 1, state())) == [(1, 1, 0.3, "7")]


def test_nobody_drives_on_the_answer_to_the_final_tick(accounts, tmp_path):
    told = accounts(
        ("/ego", 3, EGO),
        ("/repair/state", 3, state()),
        ("/ego", 4, EGO),
        ("/repair/state", 4, state()),
        ("/events", 4, END),
    )
    assert told == [(3, 1, 0.3, "7")]
    assert read_episode(tmp_path / "bag").spells() == bag_info(tmp_path / "bag").spells


def test_a_shadow_in_the_bag_is_not_taken_for_what_was_done(accounts):
    told = accounts(("/car/shadow/repair/state", 1, state(-0.8, 0.9)), ("/car/repair/state", 2, state()))
    assert told == [(2, 1, 0.3, "7")]


def test_a_long_bag_holds_a_second_at_once(accounts):
    ticks = [("/repair/state", tick, state(-0.4 if tick % 10 == 0 else 0.5)) for tick in range(100)]
    assert [begin for begin, *_ in accounts(*ticks)] == [*range(0, 100, 10)]


def test_time_and_dose_are_true_at_another_rate_than_ours(accounts, tmp_path):
    accounts(*(("/repair/state", 2 * step, state(-0.7 if 10 <= step < 30 else 0.5)) for step in range(40)))
    (found,) = bag_info(tmp_path / "bag").spells
    told = found.as_dict()
    assert (told["ticks"], told["duration"], told["dose"]) == (20, pytest.approx(2.0), pytest.approx(2.4))
