import numpy as np
import pytest

from roadmend.core.command import Command
from roadmend.core.repair import Repair, RepairStatus, RepairTrigger
from roadmend.core.scene import OBJECT, EgoState, ObjectList
from roadmend.core.spell import Spell
from roadmend.core.spell_account import MINOR, SpellAccount, SpellAccountBuilder, with_needs
from roadmend.core.trigger_sight import TriggerSight

EGO = EgoState.from_yaw(0.0, 0.0, 0.0, 8.0, 0.0, 4.0, 2.0)


def answer(final, worth=None, triggers=(), reason=""):
    """The policy asks for 0.5."""
    status = RepairStatus.PASS if final == 0.5 else RepairStatus.REPAIRED
    command = Command.from_action(final)
    return Repair(command, status, 0.0, 0.5, 0.5, final, final != 0.5, 0, triggers, reason, worth)


def test_worth_who_and_why_are_those_of_the_first_tick_and_the_action_the_strongest():
    builder = SpellAccountBuilder()
    answers = [
        answer(0.5, 0.9, reason="not yet"),
        answer(0.0, 0.3, (RepairTrigger(7, 0.8),), "close"),
        answer(-0.6, 0.1, (RepairTrigger(8, 0.8),), "closer"),
        answer(-0.2, None),
        answer(0.5),
        answer(-1.0, None, reason="again"),
    ]
    begins = [builder.add(0.05 * tick, each) for tick, each in enumerate(answers)]
    assert begins == [False, True, False, False, False, True]
    first, second = builder.accounts
    assert (first.spell.begin, first.spell.ticks, first.strongest) == (0.05, 3, -0.6)
    assert first.spell.dose == pytest.approx(0.05 * (0.5 + 1.1 + 0.7))
    assert (first.worth, first.who, first.why) == (0.3, (TriggerSight(7, 0.8),), "close")
    assert (second.worth, second.who, second.why) == (None, (), "again")


def test_what_was_seen_belongs_to_the_last_spell_and_stays_there():
    builder = SpellAccountBuilder()
    objects = ObjectList(np.zeros(1, dtype=OBJECT)).with_columns(id=7, kind=1, x=20.0, length=4.0, width=2.0)
    builder.add(0.0, answer(0.0, triggers=(RepairTrigger(7, 0.8), RepairTrigger(9, 0.2))))
    builder.see(EGO, objects)
    builder.add(0.05, answer(-0.4))
    builder.add(0.1, answer(0.5))
    builder.add(0.15, answer(0.0, triggers=(RepairTrigger(7, 0.8),)))
    first, second = builder.accounts
    assert [sight.words for sight in first.who] == ["car 7 ahead, 16 m", "9"]
    assert [sight.words for sight in second.who] == ["7"]


def test_only_those_that_matter_are_named_to_people():
    who = tuple(TriggerSight(number, weight) for number, weight in enumerate([2.0, 2.0 * MINOR, 1.9 * MINOR]))
    assert SpellAccount(Spell(0.0, 1, 1.0), 0.0, None, who, "").chiefly == who[:2]
    assert SpellAccount(Spell(0.0, 1, 1.0), 0.0, None, (TriggerSight(1, -0.5),), "").chiefly == (TriggerSight(1, -0.5),)
    assert SpellAccount(Spell(0.0, 1, 1.0), 0.0, None, (), "").chiefly == ()


def test_needs_find_their_spells_by_the_tick():
    accounts = [SpellAccount(Spell(begin, 3, 1.0), 0.0, None, (), "") for begin in (0.3, 7.0)]
    told = with_needs(accounts, [Spell(0.1 + 0.2, 9, 9.0, 0.4), Spell(5.0, 1, 1.0, 1.0)])
    assert [(account.spell.need, account.spell.ticks) for account in told] == [(0.4, 3), (None, 3)]
    assert told[0].as_dict() == {
        "begin": 0.3,
        "ticks": 3,
        "duration": pytest.approx(0.15),
        "dose": pytest.approx(0.05),
        "strongest": 0.0,
        "worth": None,
        "need": 0.4,
        "triggers": [],
        "reason": "",
    }
