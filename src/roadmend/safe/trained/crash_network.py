"""The trained network, in numpy: a text encoder, and heads that answer questions about vehicles, pairs of them, and the text."""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from roadmend.core.errors import InputError
from roadmend.core.settings import check_parameters
from roadmend.networks.checkpoint import load_checkpoint
from roadmend.networks.compiled_encoder import CompiledHead
from roadmend.networks.kernels import Floats, linear
from roadmend.networks.shape import HeadShape, TextShape
from roadmend.networks.tensors import restored
from roadmend.networks.text_encoder import TextReader
from roadmend.safe.trained.marked_text import MARKS, MarkedText
from roadmend.safe.trained.outputs import OF_PAIR, OF_PIECE, OF_TEXT, OF_VEHICLE, shares_of, width_of
from roadmend.safe.trained.word_pieces import WordPieces

KIND = "crash_text"
Shares = Mapping[str, NDArray[np.float64]]


@dataclass(frozen=True, slots=True)
class Answers:
    """Probabilities of the answers to each question, by its name.

    Attributes:
        vehicles: (V, answers).
        pairs: (V, V, answers), of the second vehicle as the first one has it.
        text: (answers,).
    """

    vehicles: Shares
    pairs: Shares
    text: Shares


def head_shapes(hidden: int) -> dict[str, HeadShape]:
    """The heads by their names in the file, for an encoder of that width."""
    return {
        "vehicle": HeadShape(inputs=2 * hidden, hidden=(hidden,), outputs=width_of(OF_VEHICLE)),
        "pair": HeadShape(inputs=4 * hidden, hidden=(hidden,), outputs=width_of(OF_PAIR)),
        "text": HeadShape(inputs=2 * hidden, hidden=(hidden,), outputs=width_of(OF_TEXT)),
        "party": HeadShape(inputs=hidden, hidden=(hidden,), outputs=width_of(OF_PIECE)),
    }


class CrashNetwork:
    """Reads marked texts.

    Args:
        path: of a model of the kind "crash_text".

    Raises:
        InputError: the file is missing, damaged or of another kind, or its tensors or its vocabulary are not its shape's.
    """

    def __init__(self, path: Path) -> None:
        checkpoint = load_checkpoint(path, KIND)
        self.digest = checkpoint.digest
        self.header: Mapping[str, Any] = checkpoint.header
        self.where = where = str(path)
        shape = check_parameters(checkpoint.header.get("shape"), TextShape, f"{where}, shape")
        try:
            self.pieces = WordPieces(checkpoint.header.get("vocabulary") or ())
            _check(self.pieces, shape)
            tensors = restored(checkpoint.tensors)
            self.encoder = TextReader(shape, tensors)
            self._heads = {
                name: CompiledHead(head, tensors, f"{name}.") for name, head in head_shapes(shape.hidden).items()
            }
        except (ValueError, TypeError) as error:
            raise InputError(where, f"is no model of crash texts ({error})", "give another file") from None

    def answer(self, text: MarkedText) -> Answers:
        """Answer all questions about one text, however long."""
        states = self._states(text)
        weights = text.shares / text.shares.sum(axis=1, keepdims=True)
        own, begin, mean = np.empty((len(weights), states.shape[1]), np.float32), states[0], states.mean(axis=0)
        linear(weights, states, np.zeros(states.shape[1], np.float32), own)
        count = len(own)
        vehicles = np.stack([self._heads["vehicle"].apply(np.concatenate([each, begin])) for each in own])
        pairs = np.zeros((count, count, width_of(OF_PAIR)), np.float32)
        for first in range(count):
            for second in range(count):
                row = np.concatenate([own[first], own[second], own[first] * own[second], begin])
                pairs[first, second] = self._heads["pair"].apply(row)
        whole = self._heads["text"].apply(np.concatenate([mean, begin]))
        return Answers(shares_of(vehicles, OF_VEHICLE), shares_of(pairs, OF_PAIR), shares_of(whole, OF_TEXT))

    def parties(self, text: MarkedText) -> NDArray[np.float64]:
        """Probabilities (T, 1 + SEATS) of whom each piece of a text without marks names: nobody, or the first who is named, and so on."""
        logits = np.stack([self._heads["party"].apply(state) for state in self._states(text)])
        return shares_of(logits, OF_PIECE)["party"]

    def _states(self, text: MarkedText) -> Floats:
        """What each piece has come to mean; a long text is read in windows, each piece where it stands furthest inside."""
        size, count = self.encoder.shape.positions, len(text.pieces)
        if count <= size:
            return self.encoder.read(text.pieces, text.marks)
        states = np.zeros((count, self.encoder.shape.hidden), np.float32)
        step = size // 2
        for start in range(0, count - step, step):
            at = min(start, count - size)
            skip = 0 if at == 0 else size // 4
            states[at + skip : at + size] = self.encoder.read(text.pieces[at : at + size], text.marks[at : at + size])[
                skip:
            ]
        return states


def _check(pieces: WordPieces, shape: TextShape) -> None:
    """Refuse a vocabulary or marks that the encoder's shape does not have.

    Raises:
        ValueError: so it is.
    """
    if len(pieces.vocabulary) != shape.pieces or shape.marks != MARKS:
        raise ValueError("the vocabulary or the marks are not those of its shape")
