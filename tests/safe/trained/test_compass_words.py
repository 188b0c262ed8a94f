"""A text turned on the compass."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from roadmend.safe.trained.compass_words import turn_text

TURNED = {
    "He went north, then Northbound.": "He went east, then Eastbound.",
    "The S/B pickup, veh 2 NB, EB lane": "The W/B pickup, veh 2 EB, SB lane",
    "in a south-easterly direction": "in a south-westerly direction",
    "the North-West corner, SW of it": "the North-East corner, NW of it",
    "NORTHEAST END, WESTERN SIDE": "SOUTHEAST END, NORTHERN SIDE",
    "runs N-S, V1 W on Elm": "runs E-W, V1 N on Elm",
    "on 12 E. Main St": "on 12 S. Main St",
}
KEPT = [
    "the driver's side",
    "the easter parade in Weston",
    "Mr. W. E. Northam",
    "e-mail, s and n",
    "Norther Inc. V1's boot",
]


@pytest.mark.parametrize(("text", "turned"), TURNED.items())
def test_every_word_for_a_point_of_the_compass_is_turned(text, turned):
    assert turn_text(text, [], 1)[0] == turned


@pytest.mark.parametrize("text", KEPT)
def test_what_is_none_stays(text):
    assert turn_text(text, [], 1)[0] == text


@pytest.mark.parametrize("text", TURNED)
def test_four_quarters_are_a_whole_turn(text):
    for quarters in range(4):
        once, _ = turn_text(text, [], quarters)
        assert turn_text(once, [], -quarters)[0] == text


def test_places_stay_on_their_words():
    text = "A northwest road; the Civic went west and hit the van, eastbound."
    words = ["Civic", "van", "northwest", "eastbound"]
    places = [(text.index(word), text.index(word) + len(word)) for word in words]
    for quarters in range(4):
        turned, moved = turn_text(text, places, quarters)
        found = [turned[start:end] for start, end in moved]
        assert found[:2] == words[:2]
        assert found[3].endswith("bound")
    assert turn_text(text, places, 2)[0] == "A southeast road; the Civic went east and hit the van, westbound."


@given(st.text("NSEWnsew northbound-/B. '", max_size=60), st.integers(0, 3))
def test_any_text_is_turned(text, quarters):
    turned, [(start, end)] = turn_text(text, [(0, len(text))], quarters)
    assert (start, end) == (0, len(turned))
