"""Words for manoeuvres, of the scenario language and of records."""

import pytest

from roadmend.safe.dsl import Manoeuvre
from roadmend.safe.manoeuvre_words import (
    comes_sideways,
    crosses_over,
    goes_backwards,
    leaves_driveway,
    runs_off,
    stands,
    to_the_left,
    turns_round,
)

MEANINGS = (stands, comes_sideways, crosses_over, runs_off, turns_round, goes_backwards, leaves_driveway)


@pytest.mark.parametrize(
    ("words", "meanings"),
    [
        ("Stop", {stands}),
        ("Parked", {stands}),
        ("Changing Lane", {comes_sideways}),
        ("change lane left", {comes_sideways}),
        ("drift left", {comes_sideways, crosses_over}),
        ("Overtake", {comes_sideways, crosses_over}),
        ("Merge", {comes_sideways}),
        ("Enter the Wrong Way", {crosses_over}),
        ("U-turn", {turns_round}),
        ("Reverse", {goes_backwards}),
        ("backing out", {goes_backwards}),
        ("Run off the Road", {runs_off}),
        ("Leave a Driveway", {leaves_driveway}),
        ("Move Forward", set()),
        ("Turn Left", set()),
        (None, set()),
    ],
)
def test_words_mean_what_they_say(words, meanings):
    assert {meaning for meaning in MEANINGS if meaning(words)} == meanings


def test_who_goes_sideways_goes_left_or_right_or_nobody_says():
    told = {words: to_the_left(words) for words in ("change lane left", "drift right", "Merge", "Turn Left", None)}
    assert [*told.values()] == [True, False, None, None, None]
    assert [to_the_left(word) for word in Manoeuvre] == [None] * len(Manoeuvre)
