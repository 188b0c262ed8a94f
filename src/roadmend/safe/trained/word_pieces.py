"""Texts in pieces of words, as BERT takes them (Wu et al. 2016, "WordPiece"; Devlin et al. 2019)."""

import re
import unicodedata
from collections.abc import Iterator, Sequence

UNKNOWN, BEGIN, END = "[UNK]", "[CLS]", "[SEP]"
_GOES_ON = "##"  # before a piece that does not begin its word
_WORD = re.compile(r"[^\W_]+|[^\w\s]|_")  # a sign that is neither letter nor digit is a word
_LONGEST = 100  # letters of a word that is taken apart


class WordPieces:
    """Takes texts apart into the pieces of a vocabulary, in small letters and without accents.

    Args:
        vocabulary: all pieces; one that goes on in a word begins with "##".

    Raises:
        ValueError: the vocabulary lacks a piece that every text needs.
    """

    def __init__(self, vocabulary: Sequence[str]) -> None:
        self.vocabulary = tuple(vocabulary)
        self._places = {piece: place for place, piece in enumerate(vocabulary)}
        missing = {UNKNOWN, BEGIN, END} - {*self._places}
        if missing:
            raise ValueError(f"the vocabulary lacks {', '.join(sorted(missing))}")
        self.begin, self.end = self._places[BEGIN], self._places[END]

    def split(self, text: str) -> tuple[list[int], list[tuple[int, int]]]:
        """The pieces of a text by their place in the vocabulary, and the characters of the text that each stands for."""
        found = [
            (place, span)
            for word in _WORD.finditer(_plain(text))
            for place, span in self._taken_apart(word[0], word.start())
        ]
        return [place for place, _ in found], [span for _, span in found]

    def _taken_apart(self, word: str, at: int) -> Iterator[tuple[int, tuple[int, int]]]:
        """The longest piece that the word begins with, the longest that what is left begins with, and so on."""
        found, start = list[tuple[int, tuple[int, int]]](), 0
        while start < len(word) <= _LONGEST:
            before = _GOES_ON if start else ""
            end = next((end for end in range(len(word), start, -1) if before + word[start:end] in self._places), None)
            if end is None:
                break
            found.append((self._places[before + word[start:end]], (at + start, at + end)))
            start = end
        yield from found if start == len(word) else [(self._places[UNKNOWN], (at, at + len(word)))]


def _plain(text: str) -> str:
    """The text in small letters without accents, letter for letter."""
    return "".join(unicodedata.normalize("NFD", letter.lower())[0] for letter in text)
