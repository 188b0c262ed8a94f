from dataclasses import replace

import pytest

from roadmend.core.command import Command
from roadmend.core.repair import Repair, RepairStatus
from roadmend.core.spell import Spell, SpellBuilder


def answer(final):
    """The policy asks for 0.5."""
    status = RepairStatus.PASS if final == 0.5 else RepairStatus.REPAIRED
    command = Command(max(final, 0.0), max(-final, 0.0))
    return Repair(command, status, 0.0, 0.5, 0.5, final, final != 0.5)


def test_held_back_lane_changes_are_counted_spell_by_spell():
    builder = SpellBuilder()
    held = replace(answer(0.5), status=RepairStatus.REPAIRED, intervened=True, held_back=True)
    for tick, each in enumerate([held, answer(0.0), held, answer(0.5), held]):
        builder.add(0.05 * tick, each)
    assert [spell.held_back for spell in builder.spells] == [2, 1]
    assert builder.spells[1].dose == 0.0


def test_spells_are_uninterrupted_and_know_their_dose():
    builder = SpellBuilder()
    assert builder.spells == ()
    begins = [builder.add(0.05 * tick, answer(final)) for tick, final in enumerate([0.5, 0.0, -0.5, 0.5, 0.5, -1.0])]
    assert begins == [False, True, False, False, False, True]
    first, second = builder.spells
    assert (first.begin, first.ticks, first.need) == (0.05, 2, None)
    assert first.dose == pytest.approx(0.05 * (0.5 + 1.0))
    assert first.end == pytest.approx(0.15)
    assert second == Spell(0.25, 1, 1.5)


def test_an_answer_counts_until_the_next_one_whatever_the_rate():
    builder = SpellBuilder()
    for step, final in enumerate([0.5, 0.0, -0.5, 0.5, -1.0]):
        builder.add(0.1 * step, answer(final))
    first, last = builder.spells
    assert (first.ticks, first.end - first.begin, first.dose) == (2, pytest.approx(0.2), pytest.approx(0.1 * 1.5))
    assert last == Spell(0.4, 1, 1.5)  # none follows


def test_a_clock_that_was_set_back_shortens_nothing():
    builder = SpellBuilder()
    for time in (7.0, 7.05, 0.0):
        builder.add(time, answer(0.0))
    assert builder.spells == (Spell(7.0, 3, 1.5),)
