"""Texts in pieces of words."""

import itertools

import pytest
from hypothesis import given
from hypothesis import strategies as st

from roadmend.safe.trained.word_pieces import WordPieces

WORDS = ["[UNK]", "[CLS]", "[SEP]", "car", "##s", "##port", "c", "##a", "'", "-", "2", "##4", "cafe", "i"]


def said(text):
    pieces = WordPieces(WORDS)
    found, spans = pieces.split(text)
    return [(WORDS[place], text[start:end]) for place, (start, end) in zip(found, spans, strict=True)]


def test_words_fall_apart_into_the_longest_pieces():
    assert said("Cars, carport") == [("car", "Car"), ("##s", "s"), ("[UNK]", ","), ("car", "car"), ("##port", "port")]


def test_signs_are_words_of_their_own():
    assert said("car's-24") == [("car", "car"), ("'", "'"), ("[UNK]", "s"), ("-", "-"), ("2", "2"), ("##4", "4")]


def test_a_word_that_cannot_be_taken_apart_whole_is_unknown():
    assert said("cart ca") == [("[UNK]", "cart"), ("c", "c"), ("##a", "a")]
    assert said("c" + "a" * 200) == [("[UNK]", "c" + "a" * 200)]


def test_accents_and_large_letters_are_none():
    assert said("CAFÉ, İ") == [("cafe", "CAFÉ"), ("[UNK]", ","), ("i", "İ")]


def test_what_every_text_needs_must_be_there():
    with pytest.raises(ValueError, match=r"lacks \[CLS\], \[SEP\]"):
        WordPieces(["[UNK]", "a"])


@given(st.text(max_size=40))
def test_any_text_is_taken_apart_in_order(text):
    _, spans = WordPieces(WORDS).split(text)
    assert all(start < end <= len(text) for start, end in spans)
    assert all(one[1] <= other[0] for one, other in itertools.pairwise(spans))
