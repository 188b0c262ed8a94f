"""Who does what in a sentence, by its tree: subjects, passives, relative clauses, what "and" joins."""

import pytest

from .apart import taken_apart, words


def at(structure, word):
    return next(place for place, item in enumerate(structure.items) if item.low == word)


@pytest.mark.parametrize(
    ("text", "verb", "subject"),
    [
        ("V1 struck V2.", "struck", "v 1"),
        ("V2 was struck by V1.", "struck", "v 2"),
        ("V1 turned left and struck V2.", "struck", "v 1"),
        ("V2, which was northbound, struck V1.", "struck", "v 2"),
    ],
)
def test_the_subject_of_a_predicate(text, verb, subject):
    structure = taken_apart(text)
    place = at(structure, verb)
    assert structure.is_predicate(place)
    assert words(structure.items, structure.subject(place)) == subject


def test_left_is_a_hand_or_a_departure():
    hand, departure = taken_apart("V1 turned left."), taken_apart("V1 left the road.")
    assert not hand.is_predicate(at(hand, "left"))
    assert departure.is_predicate(at(departure, "left"))


def test_a_preposition_brings_a_group_in():
    structure = taken_apart("V1 was behind V2.")
    (_, other) = structure.groups
    assert structure.lead(other).low == "behind"


def test_what_and_joins():
    structure = taken_apart("V1 struck V2 and V3.")
    assert [group.mention.number for group in structure.joined(structure.groups[1])] == [2, 3]


def test_every_word_hangs_on_a_root():
    structure = taken_apart(
        "V1, a 2004 Honda Civic, was traveling north in the first lane when it struck V2 in the rear."
    )
    assert len(structure.tree) == len(structure.items)
    tops = {([place, *structure.tree.chain(place)])[-1] for place in range(len(structure.items))}
    assert all(structure.tree[top].head == top for top in tops)


def test_the_same_sentence_has_the_same_tree():
    text = "V2 was going straight when V1 turned left in front of it."
    assert taken_apart(text).tree == taken_apart(text).tree


def test_a_word_at_the_very_beginning_counts_as_governed():
    structure = taken_apart("He braked.")
    assert list(structure.tree.children(at(structure, "braked"), "nsubj")) == [0]
    assert structure.tree.has(at(structure, "braked"), "nsubj")
    assert not structure.tree.has(at(structure, "braked"), "dobj")


def test_a_noun_group_is_not_joined_to_itself():
    structure = taken_apart("V1's front and left side struck V2.")
    joined = list(structure.joined(structure.groups[0]))
    assert joined[0] is structure.groups[0]
    assert all(each is not joined[0] for each in joined[1:])
