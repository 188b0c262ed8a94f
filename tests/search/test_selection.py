"""Which points become cases: spread, shared out evenly, different and not too alike."""

import itertools

import pytest
from hypothesis import given
from hypothesis import strategies as st

from roadmend.search.evaluation import Trial
from roadmend.search.moves import distance
from roadmend.search.registry import make_technique
from roadmend.search.selection import Picker, shares, spread

from .toy import SPACE, drive

TRIALS = drive(make_technique("avfuzzer", SPACE, 1), 400)


@given(st.lists(st.integers(), unique=True, max_size=60), st.integers(1, 80))
def test_spread_keeps_all_and_takes_even_steps(items, count):
    ordered = spread(items, count)
    assert sorted(ordered) == sorted(items)
    first = [items.index(item) for item in ordered[:count]]
    assert first == sorted(first)
    steps = [after - before for before, after in itertools.pairwise(first)]
    assert not steps or max(steps) - min(steps) <= 1


def test_spread_of_known_items():
    assert spread(range(9), 3) == [1, 4, 7, 0, 2, 3, 5, 6, 8]


@given(st.integers(0, 100), st.lists(st.integers(0, 30), max_size=8))
def test_shares_are_even_where_there_is_enough(total, available):
    taken = shares(total, available)
    assert sum(taken) == min(total, sum(available))
    assert all(0 <= share <= most for share, most in zip(taken, available, strict=True))
    unspent = [share for share, most in zip(taken, available, strict=True) if share < most]
    assert not unspent or max(taken) - min(unspent) <= 1


@pytest.mark.parametrize("least", [0.0, 0.05, 0.1])
def test_what_is_picked_is_new_and_apart(least):
    known = {TRIALS[3].evaluation.digest}
    picker = Picker(SPACE, least, known)
    pairs = [*enumerate(TRIALS)]
    first = picker.pick(pairs, 30)
    second = picker.pick([pair for pair in pairs if pair not in first], 1000)
    picked = [*first, *second]
    assert [index for index, _ in first] == sorted(index for index, _ in first)
    assert len(first) == 30
    digests = [trial.evaluation.digest for _, trial in picked]
    assert len({*digests}) == len(digests)
    assert not known & {*digests}
    points = [trial.parameters for _, trial in picked]
    apart = [distance(SPACE, one, other) for place, one in enumerate(points) for other in points[:place]]
    assert min(apart) >= least
    rest = [trial for pair in pairs if pair not in picked for trial in pair[1:]]
    assert all(
        trial.evaluation.digest in {*digests, *known}
        or any(distance(SPACE, trial.parameters, point) < least for point in points)
        for trial in rest
    )


def test_a_trajectory_is_taken_once():
    one = TRIALS[0]
    twin = Trial(TRIALS[1].parameters, one.evaluation)
    assert Picker(SPACE, 0.0, set()).pick([(0, one), (1, twin)], 2) == [(0, one)]
