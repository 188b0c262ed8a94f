"""Messages of one tick find each other by their stamp."""

import itertools

import pytest

from roadmend.nodes.pairing import TickPairing


@pytest.fixture
def pairing():
    return TickPairing("ego", "objects")


@pytest.mark.parametrize("order", list(itertools.permutations(["ego", "objects", "command"])))
def test_a_tick_is_complete_with_its_last_part_whatever_the_order(order):
    pairing = TickPairing("ego", "objects", "command")
    *early, last = order
    assert [pairing.add(5, part, part.upper(), 0.0) for part in early] == [None, None]
    assert pairing.add(5, last, last.upper(), 0.0) == {"ego": "EGO", "objects": "OBJECTS", "command": "COMMAND"}
    assert pairing.waiting() is None


def test_parts_of_two_ticks_do_not_mix(pairing):
    assert pairing.add(1, "ego", "a", 0.0) is None
    assert pairing.add(2, "objects", "b", 0.0) is None
    assert pairing.add(1, "objects", "c", 0.0) == {"ego": "a", "objects": "c"}
    assert pairing.add(2, "ego", "d", 0.0) == {"ego": "d", "objects": "b"}


def test_a_part_that_comes_twice_completes_nothing_and_the_later_one_counts(pairing):
    assert pairing.add(1, "ego", "first", 0.0) is None
    assert pairing.add(1, "ego", "second", 1.0) is None
    assert pairing.waiting() == (1, {"ego": "second"}, 0.0)  # it has been waited for since the first
    assert pairing.add(1, "objects", "o", 2.0) == {"ego": "second", "objects": "o"}


def test_a_complete_tick_drops_older_incomplete_ones_and_keeps_newer_ones(pairing):
    for stamp in (1, 2, 4):
        pairing.add(stamp, "ego", stamp, 0.0)
    pairing.add(3, "ego", 3, 0.0)
    assert pairing.add(3, "objects", 3, 0.0) is not None
    assert pairing.waiting() == (4, {"ego": 4}, 0.0)
    pairing.give_up(4)
    assert pairing.waiting() is None


def test_the_newest_incomplete_tick_is_the_one_waited_for(pairing):
    pairing.add(7, "ego", "new", 3.0)
    pairing.add(6, "ego", "old", 4.0)
    assert pairing.waiting() == (7, {"ego": "new"}, 3.0)


def test_the_oldest_incomplete_tick_is_the_one_that_ages_however_many_come_after_it(pairing):
    assert pairing.oldest() is None
    for stamp in (5, 6, 7):
        pairing.add(stamp, "ego", stamp, float(stamp))
    assert pairing.oldest() == (5, {"ego": 5}, 5.0)
    pairing.add(6, "objects", 6, 8.0)
    assert pairing.oldest() == (7, {"ego": 7}, 7.0)


def test_the_newest_tick_with_some_parts_is_found_among_those_that_lack_them(pairing):
    pairing.add(1, "ego", 1, 0.0)
    pairing.add(2, "ego", 2, 0.0)
    pairing.add(3, "objects", 3, 0.0)
    assert pairing.newest_with(["ego"]) == (2, {"ego": 2})
    assert pairing.newest_with([]) == (3, {"objects": 3})
    assert pairing.newest_with(["ego", "objects"]) is None


def test_giving_up_drops_the_tick_and_all_before_it(pairing):
    for stamp in (1, 2, 3):
        pairing.add(stamp, "ego", stamp, float(stamp))
    pairing.give_up(2)
    assert pairing.waiting() == (3, {"ego": 3}, 3.0)
    assert pairing.add(2, "objects", "late", 4.0) is None  # its ego has been forgotten


def test_cleared_it_waits_for_nothing(pairing):
    pairing.add(1, "ego", "a", 0.0)
    pairing.clear()
    assert pairing.waiting() is None
    assert pairing.add(1, "objects", "b", 0.0) is None


def test_what_a_dropped_tick_had_to_do_without_comes_too_late_once(pairing):
    pairing.add(1, "ego", "a", 0.0)
    pairing.give_up(1)
    assert not pairing.comes_too_late(1, "ego")  # it had that: time ran backwards
    assert not pairing.comes_too_late(0, "objects")
    assert pairing.comes_too_late(1, "objects")
    assert not pairing.comes_too_late(1, "objects")


def test_after_a_tick_that_was_whole_and_in_another_time_nothing_comes_too_late(pairing):
    for part in ("ego", "objects", "command"):
        pairing.add(1, part, "a", 0.0)
    assert not pairing.comes_too_late(1, "trajectory")
    pairing.add(2, "ego", "a", 0.0)
    pairing.give_up(2)
    pairing.clear()
    assert not pairing.comes_too_late(2, "objects")
