"""What was counted outlives the node that counted it."""

from dataclasses import replace

import pytest

from roadmend.core.command import Command
from roadmend.core.repair import Repair, RepairStatus
from roadmend.nodes.repair_tally import RepairTally


def answer(asked, sent, status=RepairStatus.REPAIRED):
    command = Command.from_action(sent)
    return Repair(command, status, 1.0, 0.5, asked, sent, intervened=asked != sent)


ANSWERS = [
    (0.0, answer(0.2, 0.2, RepairStatus.RESET)),
    (0.05, answer(0.2, -0.7)),
    (0.1, answer(0.3, -0.1)),
    (0.15, answer(0.1, 0.1, RepairStatus.PASS)),
    (0.2, answer(float("nan"), -0.5, RepairStatus.STALE_COMMAND)),
    (0.25, replace(answer(0.4, -0.5, RepairStatus.STALE_COMMAND), held_back=True)),
]


def counted(answers, journal=None):
    tally = RepairTally(journal)
    for time, repair in answers:
        tally.add(time, repair)
    return tally


def test_a_node_that_is_killed_takes_nothing_with_it(tmp_path):
    journal = tmp_path / "answers"
    whole = counted(ANSWERS).account()
    counted(ANSWERS, journal)  # never closed: as after SIGKILL
    assert RepairTally(journal).account() == whole
    assert whole["answers"] == 6
    assert whole["interventions"] == 4
    assert whole["stale"] == 2
    assert [spell["held_back"] for spell in whole["spells"]] == [0, 1]


@pytest.mark.parametrize("cut", range(1, len(ANSWERS)))
def test_the_one_that_takes_its_place_goes_on_counting(tmp_path, cut):
    journal = tmp_path / "answers"
    counted(ANSWERS[:cut], journal)
    counted(ANSWERS[cut:], journal)
    found, whole = RepairTally(journal).account(), counted(ANSWERS).account()
    spells = found.pop("spells"), whole.pop("spells")
    assert found == whole
    assert [sum(spell["ticks"] for spell in each) for each in spells] == [4, 4]
    assert len(spells[0]) == len(spells[1]) + (cut in (2, 5))  # no spell goes on over a death


def test_half_an_answer_is_none(tmp_path):
    journal = tmp_path / "answers"
    counted(ANSWERS, journal)
    journal.write_bytes(journal.read_bytes() + b"cut")
    assert counted(ANSWERS[:1], journal).account()["answers"] == 7
    assert RepairTally(journal).account()["answers"] == 7


@pytest.mark.parametrize("damage", [b"\x07" * 26, b"\x07" * 3])
def test_a_journal_that_is_none_does_not_keep_it_from_counting(tmp_path, damage):
    journal = tmp_path / "answers"
    journal.write_bytes(damage)
    assert counted(ANSWERS, journal).account()["answers"] in (6, 7)


def test_where_nothing_can_be_written_it_counts_all_the_same(tmp_path):
    assert counted(ANSWERS, tmp_path / "missing" / "answers").account() == counted(ANSWERS).account()
