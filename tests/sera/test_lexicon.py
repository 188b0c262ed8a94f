"""Words of people become terms."""

import pytest

from roadmend.sera.lexicon import terms_of_text
from roadmend.sera.pattern import FailurePattern, Where, Who, Why
from roadmend.sera.terms import features


@pytest.mark.parametrize(
    ("text", "terms"),
    [
        ("Cut-in at an exit in rain", {"hazard:cut_in", "road:highway_exit", "weather:rainy"}),
        (
            "a lorry slams on the brakes on the motorway exit",
            {"participant:truck", "hazard:hard_braking", "road:highway_exit"},
        ),
        ("cyclist runs the red light at night", {"participant:bicycle", "hazard:run_right_of_way", "light:nighttime"}),
        ("merging from the on-ramp, wet road", {"manoeuvre:merge", "road:on_ramp", "weather:rainy"}),
        ("pedestrian crosses at a T-junction", {"hazard:pedestrian_crossing", "road:tee_junction"}),
        ("zorblax at the wheel", {"zorblax", "wheel"}),
        ("the ego vehicle", set()),
    ],
)
def test_words_mean_terms(text, terms):
    assert set(terms_of_text(text)) == terms


def test_one_who_cuts_in_and_brakes_does_both():
    found = features(FailurePattern("x", "a truck cuts in and brakes from the left")).terms
    for kind in ("cut_in", "cut_in_and_brake", "hard_braking"):
        assert {f"hazard:{kind}", f"hazard+participant:{kind}+truck", f"hazard+side:{kind}+left"} <= found.keys()


def test_two_participants_in_words_are_joined_with_no_hazard():
    found = features(FailurePattern("x", "a truck or a bus cuts in")).terms
    assert not [term for term in found if term.startswith("hazard+")]


def test_structure_and_words_say_the_same():
    words = FailurePattern("x", "collision: a truck cuts in at a highway exit in fog")
    structure = FailurePattern(
        "y",
        what="COLLISION",
        where=Where(road="highway_exit", weather="foggy"),
        who=Who("truck"),
        why=Why(hazard="cut_in"),
    )
    assert features(words).terms == features(structure).terms
