"""The corpus that a command works on."""

from pathlib import Path

from roadmend.cli.resources import config_folder
from roadmend.core.errors import InputError
from roadmend.world.corpus import Corpus, load_corpus


def corpus_of(policy: str, file: Path | None = None) -> Corpus:
    """A policy's corpus: that of ``file``, or the one that ships.

    Raises:
        InputError: there is none, it is damaged, or it is of another policy.
    """
    path = file or config_folder() / "corpora" / f"{policy}.jsonl"
    corpus = load_corpus(path)
    if corpus.policy != policy:
        raise InputError(str(path), f"is a corpus of the policy '{corpus.policy}'", f"give one of '{policy}'")
    return corpus
