"""What is asked about a told crash, and how a lesson comes anew each time."""

import random

import numpy as np
import pytest

from roadmend.safe.trained.lessons import lesson_of, names_by_words
from roadmend.safe.trained.made_up import made_up_lesson
from roadmend.safe.trained.marked_text import SOMEBODY_ELSE, Name, NamedCrash, mark_text
from roadmend.safe.trained.outputs import HEADINGS, OF_PAIR, OF_TEXT, OF_VEHICLE, RELATIONS, SEATS, TOUCHED
from roadmend.safe.trained.word_pieces import WordPieces
from roadmend.training.text_reading import UNASKED
from tests.networks.small_bert import WORDS
from tests.safe.trained.told import KEY, TEXT

PIECES = WordPieces(WORDS)
CRASH = names_by_words(TEXT, [["A car", "the car"], ["A van"]])
LESSON = lesson_of(CRASH, KEY)


def value(questions, answers, name):
    at = next(at for at, each in enumerate(questions) if each.name == name)
    return None if answers[at] == UNASKED else questions[at].values[answers[at]]


def test_names_are_found_as_whole_words():
    assert [TEXT[each.start : each.end] for each in CRASH.names] == ["the car", "A car", "A van"]
    assert [each.vehicles for each in CRASH.names] == [(0,), (0,), (1,)]
    assert names_by_words("A carport.", [["car"]]).names == ()


def test_the_key_becomes_answers():
    assert value(OF_VEHICLE, LESSON.vehicles[0], "heading") == "S2N"
    assert value(OF_VEHICLE, LESSON.vehicles[1], "model") == "Minivan"
    assert value(OF_PAIR, LESSON.pairs[0, 1], "relation") == "the second comes from the right of the first"
    assert value(OF_PAIR, LESSON.pairs[1, 0], "relation") == "the second comes from the left of the first"
    assert value(OF_PAIR, LESSON.pairs[1, 0], "struck_side") == "Right"
    assert LESSON.pairs[0, 1, 1] == TOUCHED.index(None)
    assert value(OF_TEXT, LESSON.text, "road_type") == "Intersection"
    assert value(OF_TEXT, LESSON.text, "weather") == "Rainy"
    assert value(OF_TEXT, LESSON.text, "stem") is None
    assert value(OF_TEXT, LESSON.text, "time") is None


def test_a_stem_counts_only_at_a_tee():
    tee = KEY | {"road_type": "T-intersection", "stem_direction": "West"}
    assert value(OF_TEXT, lesson_of(CRASH, tee).text, "stem") == "West"
    assert value(OF_TEXT, lesson_of(CRASH, tee | {"road_type": "Curve"}).text, "stem") is None


def test_a_key_of_more_vehicles_is_refused():
    with pytest.raises(ValueError, match="2 vehicles in the text, 1 in its key"):
        lesson_of(CRASH, KEY | {"vehicles": KEY["vehicles"][:1]})


def test_text_and_answers_are_turned_together():
    pairs = set()
    for seed in range(12):
        sample = LESSON.draw(PIECES, 512, random.Random(seed))
        words = {WORDS[piece] for piece in sample.pieces}
        heading = HEADINGS[sample.vehicles[0, 0]]
        pairs.add(
            (next(word for word in ("north", "east", "south", "west") if word in words and word != "west"), heading)
        )
        assert (sample.vehicles[1, 0] - sample.vehicles[0, 0]) % 4 == RELATIONS.index(
            OF_PAIR[0].values[sample.pairs[0, 1, 0]]
        )
        assert (sample.text == LESSON.text).all()
    assert len(pairs) > 2


def test_every_vehicle_is_named_by_its_own_seat():
    marked = mark_text(CRASH, PIECES, seats=[5, 2])
    named = [WORDS[piece] for piece, mark in zip(marked.pieces, marked.marks, strict=True) if mark == 6]
    assert named == ["a", "car", "the", "car"]
    assert marked.shares.shape == (2, len(marked.pieces))
    assert (marked.marks[marked.shares[1] == 1] == 3).all()
    assert (marked.pieces[0], marked.pieces[-1]) == (PIECES.begin, PIECES.end)


def test_who_is_named_nowhere_is_looked_for_at_the_beginning_and_others_have_a_mark():
    crash = NamedCrash("the car hit", (Name(0, 7, ()),), 1)
    marked = mark_text(crash, PIECES)
    assert marked.shares[0].tolist() == [1, 0, 0, 0, 0]
    assert marked.marks.tolist() == [0, SOMEBODY_ELSE, SOMEBODY_ELSE, 0, 0]


def test_more_vehicles_than_seats_are_refused():
    with pytest.raises(ValueError, match="9 vehicles: at most 8"):
        mark_text(NamedCrash("a", (), SEATS + 1), PIECES)


def test_made_up_crashes_agree_with_their_keys():
    generator = random.Random(0)
    points = {"S2N": "north", "W2E": "east", "N2S": "south", "E2W": "west"}
    told = 0
    for _ in range(1000):
        lesson = made_up_lesson(generator)
        assert all(0 <= name.start < name.end <= len(lesson.crash.text) for name in lesson.crash.names)
        assert {vehicle for name in lesson.crash.names for vehicle in name.vehicles} == {0, 1}
        text = lesson.crash.text.lower()
        if text.count("bound on") == 1 and "been" not in text and "having" not in text:
            at = text.index("bound on")
            near = [name for name in lesson.crash.names if name.end <= at]
            heading = value(OF_VEHICLE, lesson.vehicles[near[-1].vehicles[0]], "heading")
            if heading is not None and " was " in text[near[-1].end : at + 8]:
                told += 1
                assert text[:at].endswith(points[heading])
        relation, headings = lesson.pairs[0, 1, 0], lesson.vehicles[:, 0]
        assert relation == UNASKED or relation == (headings[1] - headings[0]) % 4
        struck = lesson.pairs[..., 1]
        assert (struck > 0).sum() == 1
        assert np.isin(struck, range(len(TOUCHED))).sum() == 2
    assert told > 5


def test_who_is_named_is_asked_of_a_text_without_marks():
    seen = []
    for seed in range(40):
        sample = LESSON.draw(PIECES, 512, random.Random(seed))
        parties = sample.parties[:, 0]
        if (parties == UNASKED).all():
            continue
        assert not sample.marks.any()
        words = [WORDS[piece] for piece in sample.pieces]
        named = [(word, party) for word, party in zip(words, parties, strict=True) if party]
        assert named == [("a", 1), ("car", 1), ("a", 2), ("van", 2), ("the", 1), ("car", 1)]
        seen.append(seed)
    assert 2 < len(seen) < 20
