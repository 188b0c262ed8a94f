"""Selections: the first, the refined with its reasons, the random one."""

import dataclasses

import numpy as np
import pytest

from harness.generated import generate
from roadmend.core.errors import InputError
from roadmend.sera.bank import Bank, build_bank
from roadmend.sera.descriptor import OutcomeStatistics
from roadmend.sera.filters import Filters
from roadmend.sera.pattern import FailurePattern, PatternEvidence
from roadmend.sera.recommendation import recommend, shares
from roadmend.sera.reflection import EmbeddedReflector, candidates_of, difficulty_of

from .banks import PLAIN, cut_in, entry, ran

CUT_IN = FailurePattern("cut-in", "a truck cuts in at a highway exit in rain")
WALKER = FailurePattern("walker", "a pedestrian crosses the road while the ego turns right at night")


def made_of(tmp_path, entries):
    build_bank(tmp_path / "b", entries)
    return Bank(tmp_path / "b")


@pytest.fixture(scope="module")
def generated(tmp_path_factory):
    with made_of(tmp_path_factory.mktemp("bank"), generate(4000, 1)) as bank:
        yield bank


def test_all_three_selections_have_one_size_and_repeat_nothing(generated):
    found = recommend(generated, [CUT_IN, WALKER], 6)
    for picks in (found.initial, found.refined, found.random):
        assert len({pick.number for pick in picks}) == len(picks) == 12
        assert [pick.pattern for pick in picks].count(0) == 6
    assert found.missing == 0
    scores = [pick.score for pick in found.initial[:6]]
    assert scores == sorted(scores, reverse=True)


def shown(count):
    return FailurePattern("some", evidence=tuple(PatternEvidence(f"{number}.mcap") for number in range(count)))


@pytest.mark.parametrize(
    ("evidence", "total", "expected"),
    [
        ([6, 3, 1], 10, [6, 3, 1]),
        ([6, 3, 1], 5, [3, 1, 1]),
        ([6, 3, 1], 2, [1, 1, 0]),
        ([2, 2], 3, [2, 1]),
        ([0, 0], 4, [2, 2]),  # written by hand
        ([], 4, []),
    ],
)
def test_places_go_to_patterns_by_their_evidence_and_one_to_each(evidence, total, expected):
    assert shares([shown(count) for count in evidence], total) == expected


def test_every_pattern_gets_its_own_number(generated):
    found = recommend(generated, [CUT_IN, WALKER], [1, 3])
    for picks in (found.initial, found.refined):
        assert [pick.pattern for pick in picks] == [0, 1, 1, 1]
    assert len(found.random) == 4
    assert [pick.pattern for pick in recommend(generated, [CUT_IN, WALKER], [2, 0]).initial] == [0, 0]


def test_what_fits_covers_the_patterns_better_than_chance_and_reflection_does_not_lose(generated):
    measures = recommend(generated, [CUT_IN, WALKER], 8).measures
    assert measures["initial"].coverage > measures["random"].coverage + 0.2
    assert measures["refined"].coverage >= measures["initial"].coverage - 0.05
    assert measures["refined"].redundant <= measures["initial"].redundant
    assert measures["refined"].too_easy <= measures["initial"].too_easy


def test_the_swaps_lead_from_the_first_selection_to_the_refined(generated):
    found = recommend(generated, [CUT_IN, WALKER], 8)
    numbers = [pick.number for pick in found.initial]
    for swap in found.swaps:
        assert swap.gain > 0.0
        numbers[numbers.index(swap.out)] = swap.into
    assert numbers == [pick.number for pick in found.refined]
    assert found.swaps


def test_it_repeats_itself_and_another_seed_changes_the_random_selection_alone(generated):
    first, again, other = (recommend(generated, [CUT_IN], 5, seed=seed) for seed in (3, 3, 4))
    assert first == again
    assert (other.initial, other.refined) == (first.initial, first.refined)
    assert other.random != first.random


def test_filters_and_exclusions_hold_for_every_selection(generated):
    excluded = {generated.entry(pick.number).digest for pick in recommend(generated, [CUT_IN], 4).initial}
    found = recommend(generated, [CUT_IN], 4, Filters(light=("nighttime",)), excluded)
    for pick in (*found.initial, *found.refined, *found.random):
        chosen = generated.entry(pick.number)
        assert chosen.descriptor.light == "nighttime"
        assert chosen.digest not in excluded


def reasons(bank, count=2):
    return [swap.reason for swap in recommend(bank, [CUT_IN], count).swaps]


def test_of_twins_one_goes_for_another_scenario(tmp_path):
    wanted = {"hazards": cut_in("truck"), "weather": "rainy"}
    other = {**wanted, "light": "nighttime", "participants": {"bus": 9}, "ego_speed": 5.0, "drivers": {"reckless": 9}}
    with made_of(tmp_path, [entry("one", **wanted), entry("twin", **wanted), entry("other", **other)]) as bank:
        assert reasons(bank) == ["redundant: one is 1.00 like twin"]


def test_what_every_policy_mastered_far_from_anybody_goes(tmp_path):
    wanted = {"hazards": cut_in("truck"), "weather": "rainy"}
    easy = entry("easy", **wanted, outcomes=ran("GOAL", 30.0))
    untried = entry("untried", **wanted, participants={"car": 4})
    with made_of(tmp_path, [easy, untried, entry("dry")]) as bank:
        found = recommend(bank, [CUT_IN], 1)
        names = [bank.entry(pick.number).name for pick in found.refined]
        assert names == ["untried"]


def test_where_policies_fail_there_is_more_to_learn_than_where_they_do_not(tmp_path):
    wanted = {"hazards": cut_in("truck"), "weather": "rainy"}
    mastered = entry("mastered", **wanted, outcomes=ran("GOAL", 1.0))
    failed = entry("failed", **wanted, participants={"car": 4}, outcomes=ran("COLLISION"))
    untried = entry("untried", **wanted, participants={"car": 4}, light="nighttime")
    with made_of(tmp_path, [mastered, untried, failed, entry("dry")]) as bank:
        found = recommend(bank, [CUT_IN], 1)
        assert [bank.entry(pick.number).name for pick in found.initial] == ["mastered"]
        assert [bank.entry(pick.number).name for pick in found.refined] == ["failed"]
        assert found.swaps[0].reason == "more to learn: failed failed in 1 of 1 runs, mastered failed in 0 of 1 runs"


def test_too_easy_and_too_hard_are_read_off_the_outcomes():
    def difficulty(*outcomes):
        return difficulty_of(dataclasses.replace(PLAIN, outcomes=tuple(each for one in outcomes for each in one)))

    assert difficulty() == ""
    assert difficulty(ran("GOAL", 30.0)) == "too easy"
    assert difficulty(ran("GOAL", 1.0)) == ""
    assert difficulty(ran("COLLISION")) == ""
    assert difficulty(ran("COLLISION"), ran("COLLISION", policy="expert")) == "too hard"
    assert difficulty(ran("COLLISION"), ran("GOAL", 1.0, policy="expert")) == ""


def test_a_small_bank_gives_what_it_has_and_an_empty_one_nothing(tmp_path):
    with made_of(tmp_path, [entry("only", hazards=cut_in())]) as bank:
        found = recommend(bank, [CUT_IN, FailurePattern("day", "a highway exit by day")], 3)
        assert (len(found.refined), found.missing) == (1, 5)
    with made_of(tmp_path, []) as bank:
        found = recommend(bank, [CUT_IN], 3)
        assert (found.initial, found.refined, found.random, found.missing) == ((), (), (), 3)


def test_a_count_of_zero_says_nothing(tmp_path):
    never = entry("never", participants={"car": 0}, outcomes=(OutcomeStatistics("modular", {"GOAL": 0}),))
    with made_of(tmp_path, [never, entry("cut-in", hazards=cut_in("truck")), entry("dry")]) as bank:
        assert np.isfinite(bank.vectors(range(3))).all()
        found = recommend(bank, [CUT_IN], 1)
        assert [bank.entry(pick.number).name for pick in found.refined] == ["cut-in"]


def test_the_second_look_ends_where_likenesses_are_no_numbers(tmp_path):
    with made_of(tmp_path, [entry("one", hazards=cut_in()), entry("other")]) as bank:
        pool = candidates_of(bank, [CUT_IN], [bank.search(CUT_IN, 2)])
    damaged = dataclasses.replace(pool, scores=np.full_like(pool.scores, np.nan))
    assert EmbeddedReflector().reflect(damaged, [damaged.pick(0, 0)])[1] == []


def test_no_pattern_is_refused(generated):
    with pytest.raises(InputError, match="patterns: there is none"):
        recommend(generated, [], 3)
