"""The tokenizers by name."""

from collections.abc import Callable

from roadmend.core.errors import InputError
from roadmend.repair.adreft.paper_tokens import PaperTokenizer
from roadmend.repair.adreft.rich_tokens import RichTokenizer
from roadmend.repair.adreft.tokenizer import Tokenizer

TOKENIZERS: dict[str, Callable[[], Tokenizer]] = {
    PaperTokenizer.name: PaperTokenizer,
    RichTokenizer.name: RichTokenizer,
}


def make_tokenizer(name: str) -> Tokenizer:
    """A tokenizer by name.

    Raises:
        InputError: there is no such tokenizer.
    """
    if name not in TOKENIZERS:
        raise InputError("tokenizer", f"there is no {name!r}", f"choose one of: {', '.join(TOKENIZERS)}")
    return TOKENIZERS[name]()
