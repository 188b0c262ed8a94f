"""Texts in pieces of words, as BERT takes them (Devlin et al. 2019; Wu et al. 2016, "WordPiece")."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

from roadmend.core.extras import extra_missing

if TYPE_CHECKING:
    from tokenizers import Tokenizer

UNKNOWN, BEGIN, END = "[UNK]", "[CLS]", "[SEP]"


class WordPieces:
    """Takes texts apart into the pieces of a vocabulary, in small letters.

    Args:
        vocabulary: all pieces; one that goes on in a word begins with "##".

    Raises:
        InputError: the library that takes texts apart is not installed.
        ValueError: the vocabulary lacks a piece that every text needs.
    """

    def __init__(self, vocabulary: Sequence[str]) -> None:
        missing = {UNKNOWN, BEGIN, END} - {*vocabulary}
        if missing:
            raise ValueError(f"the vocabulary lacks {', '.join(sorted(missing))}")
        self.vocabulary = tuple(vocabulary)
        self._tokenizer = _tokenizer({piece: place for place, piece in enumerate(vocabulary)})
        self.begin, self.end = vocabulary.index(BEGIN), vocabulary.index(END)

    def split(self, text: str) -> tuple[list[int], list[tuple[int, int]]]:
        """The pieces of a text by their place in the vocabulary, and the characters of the text that each stands for."""
        found = self._tokenizer.encode(text, add_special_tokens=False)
        return [*found.ids], [*found.offsets]


def _tokenizer(places: dict[str, int]) -> "Tokenizer":
    try:
        from tokenizers import Tokenizer, models, normalizers, pre_tokenizers  # noqa: PLC0415 - only reading needs it
    except ModuleNotFoundError as error:
        raise extra_missing(error) from None
    tokenizer = Tokenizer(models.WordPiece(places, unk_token=UNKNOWN, max_input_chars_per_word=100))
    tokenizer.normalizer = normalizers.BertNormalizer(lowercase=True)
    tokenizer.pre_tokenizer = pre_tokenizers.BertPreTokenizer()
    return tokenizer
