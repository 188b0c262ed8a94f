"""Who took part, as a network finds it, beside the cast of the rules."""

import numpy as np
import pytest

from roadmend.safe.reading.reader import read_claims
from roadmend.safe.trained.parties import Party, find_parties, is_numbered, recast
from roadmend.safe.trained.word_pieces import WordPieces
from tests.networks.small_bert import WORDS

TEXT = "A car was northbound on Elm. A van was westbound on Oak and hit the car in the left side."


class Finder:
    """A network that names the pieces that it is told."""

    def __init__(self, text, names):
        self.pieces = WordPieces(WORDS)
        _, spans = self.pieces.split(text)
        self.rows = np.full((len(spans) + 2, 9), 0.01)
        self.rows[:, 0] = 0.9
        for at, (start, end) in enumerate(spans, start=1):
            for party, word, share in names:
                if text.find(word) <= start and end <= text.find(word) + len(word):
                    self.rows[at] = 0.0
                    self.rows[at, party] = share

    def parties(self, text):
        assert not text.marks.any()
        return self.rows


def test_pieces_that_name_the_same_are_one_place_and_parties_come_in_order():
    found = find_parties(Finder(TEXT, [(2, "A car", 0.7), (1, "A van", 0.95), (2, "the car", 0.8)]), TEXT)
    assert [[TEXT[slice(*place)] for place in each.places] for each in found] == [["A car", "the car"], ["A van"]]
    assert [each.certainty for each in found] == pytest.approx([0.8, 0.95])


def places(*words):
    return tuple((TEXT.find(word), TEXT.find(word) + len(word)) for word in words)


def test_a_party_that_the_rules_lack_joins_the_cast_and_fewer_change_nothing():
    said = read_claims(TEXT)
    assert len(said.kept) == 2
    both = [Party(places("A car", "the car"), 0.95), Party(places("A van"), 0.95)]
    more = recast(TEXT, said, [*both, Party(places("Oak"), 0.95)], 0.9)
    assert more.said.kept == (0, 1, 2)
    assert (more.said.cast[2].names, more.said.cast[2].number) == (("oak",), 3)
    assert more.said.claims == said.claims
    assert {name.vehicles for name in more.crash.names if TEXT[name.start : name.end] == "Oak"} == {(2,)}
    assert more.crash.count == 3
    assert recast(TEXT, said, both[1:], 0.9).said is said


def test_where_vehicles_are_numbered_nobody_else_is_looked_for():
    assert is_numbered(read_claims("V1 was northbound on Elm. V2 was westbound on Oak and hit V1 in the left side."))
    assert not is_numbered(read_claims(TEXT))


def test_a_network_that_agrees_or_is_not_sure_changes_nothing():
    said = read_claims(TEXT)
    both = [Party(places("A car"), 0.95), Party(places("A van"), 0.95)]
    assert recast(TEXT, said, both, 0.9).said is said
    assert recast(TEXT, said, [Party(places("A car"), 0.85)], 0.9).said is said
    assert recast(TEXT, said, [], 0.9).said is said
