"""The bank: what goes in, what is found, and files that are no good."""

import dataclasses
import sqlite3

import numpy as np
import pytest

from harness.generated import generate
from roadmend.core.errors import InputError
from roadmend.sera.bank import Bank, Built, build_bank
from roadmend.sera.describe import entry_of
from roadmend.sera.descriptor import OutcomeStatistics
from roadmend.sera.filters import Filters
from roadmend.sera.pattern import FailurePattern, Where, Who, Why
from roadmend.sera.terms import features
from roadmend.world.families import sample_scenario

from .banks import cut_in, entry, ran


@pytest.fixture(scope="module")
def generated(tmp_path_factory):
    path = tmp_path_factory.mktemp("bank") / "generated.bank"
    assert build_bank(path, generate(6000, 1)) == Built(6000, 0, 0)
    with Bank(path) as bank:
        yield bank


def terms_found(bank, pattern, count=10, **options):
    return [features(bank.entry(hit.number).descriptor).terms for hit in bank.search(pattern, count, **options)]


@pytest.mark.parametrize(
    ("words", "terms"),
    [
        ("cut-in at an exit in rain", ["hazard:cut_in", "road:highway_exit", "weather:rainy"]),
        ("snow at an on-ramp at night", ["weather:snowy", "road:on_ramp", "light:nighttime"]),
        ("a truck cuts in on the motorway exit", ["hazard+participant:cut_in+truck", "road:highway_exit"]),
        (
            "cyclist ignores the right of way, ego turns left",
            ["hazard+participant:run_right_of_way+bicycle", "manoeuvre:left_turn"],
        ),
        ("pedestrian crossing the road while turning right", ["hazard:pedestrian_crossing", "manoeuvre:right_turn"]),
    ],
)
def test_what_is_asked_for_comes_first(generated, words, terms):
    found = terms_found(generated, FailurePattern("x", words))
    assert len(found) == 10
    for each in found:
        assert set(terms) <= each.keys()


def test_structure_finds_what_words_find(generated):
    words = FailurePattern("x", "collision: a truck cuts in at a highway exit in fog")
    structure = FailurePattern(
        "y",
        what="COLLISION",
        where=Where(road="highway_exit", weather="foggy"),
        who=Who("truck"),
        why=Why(hazard="cut_in"),
    )
    assert generated.search(words, 10) == generated.search(structure, 10)


def test_a_known_quantity_draws_the_like_of_it_near(generated):
    def limits(limit):
        pattern = FailurePattern("x", "highway exit", where=Where(speed_limit=limit))
        return [generated.entry(hit.number).descriptor.road.speed_limit for hit in generated.search(pattern, 30)]

    assert np.mean(limits(33.33)) > np.mean(limits(22.22)) + 0.5


@pytest.mark.parametrize(
    "failure",
    [
        FailurePattern("x", what="COLLISION", where=Where(road="highway_exit", weather="clear", light="daytime")),
        FailurePattern("x", "crash at an exit in clear weather by day"),
    ],
)
def test_what_is_known_to_fail_comes_first_even_in_other_weather_and_what_is_mastered_after_what_is_unknown(
    tmp_path, failure
):
    others = [entry(f"other {number}", participants={"car": number}) for number in range(1, 9)]
    build_bank(
        tmp_path / "b",
        [
            entry("mastered", outcomes=ran("GOAL", 12.0), ego_speed=21.0),
            entry("unknown", ego_speed=22.0),
            entry("failed", outcomes=ran("COLLISION"), weather="rainy"),
            *others,
        ],
    )
    with Bank(tmp_path / "b") as bank:
        names = [bank.entry(hit.number).name for hit in bank.search(failure, 11)]
    assert names[0] == "failed"
    assert names.index("unknown") < names.index("mastered")


def test_filters_let_nothing_else_through(generated):
    filters = Filters(family=("S4", "S5"), weather=("snowy",), outcome=("COLLISION",), hazard=("cut_in",))
    hits = generated.search(FailurePattern("x", "rain"), 50, filters)
    assert 0 < len(hits) <= 50
    for hit in hits:
        descriptor = generated.entry(hit.number).descriptor
        assert descriptor.family in ("S4", "S5")
        assert descriptor.weather == "snowy"
        assert "COLLISION" in descriptor.outcomes[0].outcomes
        assert "cut_in" in {hazard.kind for hazard in descriptor.hazards}


def test_what_is_excluded_does_not_come(generated):
    pattern = FailurePattern("x", "cut-in at an exit in rain")
    first = generated.search(pattern, 5)
    digests = {generated.entry(hit.number).digest for hit in first[:2]}
    assert generated.search(pattern, 3, exclude={*digests, "unknown"}) == first[2:]


def test_an_unknown_filter_is_refused():
    with pytest.raises(InputError, match=r"weather: there is no 'hail'; choose from clear, sunny"):
        Filters(weather=("hail",))


def test_a_pattern_that_says_nothing_is_refused(generated):
    with pytest.raises(InputError, match="'zorblax': says nothing that this bank knows"):
        generated.search(FailurePattern("x", "zorblax"), 3)


def test_notes_are_searched_too(tmp_path):
    build_bank(tmp_path / "b", [entry("one"), entry("two", notes="Report: a mattress fell off a trailer")])
    with Bank(tmp_path / "b") as bank:
        assert [hit.number for hit in bank.search(FailurePattern("x", "mattress"), 1)] == [1]


def test_the_same_scenario_adds_its_outcomes_and_a_nearly_equal_one_is_left_out(tmp_path):
    scenario = sample_scenario("S4", 1)
    first = scenario.actors[0]
    nudged, moved = (
        scenario.model_copy(
            update={"name": name, "actors": [first.model_copy(update={"position": position}), *scenario.actors[1:]]}
        )
        for name, position in (("nudged", first.position * 1.005), ("moved", first.position * 1.5))
    )
    entries = [
        entry_of(scenario, "a", ran("GOAL", 2.0)),
        entry_of(scenario, "b", ran("COLLISION", 0.0)),
        entry_of(nudged, "c"),
        entry_of(moved, "d"),
        entry_of(moved.model_copy(update={"name": "alias"}), "e", ran("COLLISION", 0.0)),
    ]
    assert build_bank(tmp_path / "b", entries) == Built(added=2, merged=2, near_equal=1)
    with Bank(tmp_path / "b") as bank:
        kept = list(bank.entries())
        assert [each.name for each in kept] == ["S4-1", "moved"]
        assert kept[0].descriptor.outcomes == (OutcomeStatistics("modular", {"COLLISION": 1, "GOAL": 1}, 0.0),)
        assert kept[0].scenario == scenario
        assert kept[1].descriptor.outcomes == ran("COLLISION", 0.0)  # of its alias
        # The filter sees the outcome that came later.
        assert len(bank.search(FailurePattern("x", "exit"), 9, Filters(outcome=("COLLISION",)))) == 2


def test_the_same_entries_give_the_same_bank(tmp_path):
    for name in ("one", "two"):
        build_bank(tmp_path / name, generate(300, 2))
    assert (tmp_path / "one").read_bytes() == (tmp_path / "two").read_bytes()


def test_what_no_descriptor_tells_makes_another_bank_all_the_same(tmp_path):
    scenario, digests = sample_scenario("S1", 7), set()
    for seed in (1, 2):
        entry = entry_of(scenario.model_copy(update={"seed": seed}), "here")
        build_bank(tmp_path / str(seed), [entry])
        with Bank(tmp_path / str(seed)) as bank:
            digests.add(bank.digest)
    assert len(digests) == 2


def test_an_empty_bank_is_a_bank(tmp_path):
    assert build_bank(tmp_path / "b", []) == Built(0, 0, 0)
    with Bank(tmp_path / "b") as bank:
        assert len(bank) == 0
        assert bank.search(FailurePattern("x", "cut-in"), 5) == []
        assert list(bank.entries()) == []


def test_what_fails_half_way_leaves_the_old_bank_and_no_litter(tmp_path):
    path = tmp_path / "b"
    build_bank(path, [entry("old", hazards=cut_in())])

    def broken():
        yield entry("new")
        raise InputError("line 2", "is no entry", "mend it")

    with pytest.raises(InputError, match="line 2"):
        build_bank(path, broken())
    with Bank(path) as bank:
        assert [each.name for each in bank.entries()] == ["old"]
    assert list(tmp_path.iterdir()) == [path]


def change(path, statement, *values):
    with sqlite3.connect(path) as connection:
        connection.execute(statement, values)
    connection.close()


@pytest.mark.parametrize(
    ("spoil", "message"),
    [
        (lambda path: path.unlink(), "no such file; give a bank"),
        (lambda path: path.write_text("not a bank\n" * 100), "is no bank or is damaged"),
        (lambda path: path.write_bytes(b""), "is no bank; give a file that 'roadmend sera bank build' made"),
        (lambda path: path.write_bytes(path.read_bytes()[: path.stat().st_size // 2]), "damaged"),
        (lambda path: change(path, "PRAGMA application_id = 7"), "is no bank; give a file"),
        (
            lambda path: change(path, "UPDATE meta SET value = 'roadmend-bank/9' WHERE key = 'format'"),
            "has the format 'roadmend-bank/9', not 'roadmend-bank/1'; export it with the roadmend that wrote it",
        ),
        (lambda path: change(path, "UPDATE meta SET value = 'other' WHERE key = 'embedder'"), "there is no 'other'"),
        (lambda path: change(path, "DELETE FROM parts WHERE name = 'vectors'"), "its vectors are not what was written"),
        (lambda path: change(path, "DELETE FROM entries WHERE number = 0"), "it holds 99 of 100 entries"),
    ],
)
def test_a_bad_file_is_refused_in_one_line(tmp_path, spoil, message):
    path = tmp_path / "b"
    build_bank(path, generate(100, 1))
    spoil(path)
    with pytest.raises(InputError) as caught:
        Bank(path)
    assert message in str(caught.value)
    assert "\n" not in str(caught.value)


def test_a_damaged_entry_is_refused_when_it_is_read(tmp_path):
    build_bank(tmp_path / "b", generate(3, 1))
    change(tmp_path / "b", "UPDATE entries SET descriptor = ? WHERE number = 1", b"{}")
    with Bank(tmp_path / "b") as bank, pytest.raises(InputError, match="bank: is damaged"):
        list(bank.entries())


def test_a_place_that_cannot_be_written_and_an_unknown_embedder_are_refused(tmp_path):
    (tmp_path / "file").write_text("")
    with pytest.raises(InputError, match="cannot be written"):
        build_bank(tmp_path / "file" / "b", [])
    with pytest.raises(InputError, match="embedder: there is no 'oracle'; choose one of latent"):
        build_bank(tmp_path / "b", [], "oracle")


def test_quantities_that_are_unknown_agree_with_all_alike():
    fast, slow = (entry(str(speed), ego_speed=speed).descriptor for speed in (30.0, 5.0))
    quantities = [features(each).quantities for each in (fast, slow)]
    assert [each["ego_speed"] for each in quantities] == [30.0, 5.0]
    assert "ego_speed" not in features(FailurePattern("x", "exit")).quantities
    assert "difficulty" not in quantities[0]
    assert "difficulty" not in features(FailurePattern("x", what="GOAL")).quantities
    assert features(FailurePattern("x", what="TIMEOUT")).quantities["difficulty"] == 1.0
    assert features(dataclasses.replace(fast, outcomes=ran("COLLISION"))).quantities["difficulty"] == 1.0
