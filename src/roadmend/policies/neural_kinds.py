"""The kinds of neural policies: what each makes of a scene's tokens, and what its head answers with."""

import json
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray
from pydantic import ValidationError

from roadmend.core.errors import InputError
from roadmend.networks.checkpoint import Checkpoint, Tensors
from roadmend.networks.compiled_encoder import CompiledEncoder
from roadmend.networks.compiled_set import CompiledExcerpt, CompiledSetEncoder
from roadmend.networks.shape import EncoderShape, ExcerptShape, HeadShape, SetShape
from roadmend.policies.neural_tokens import COLUMNS, PLACES

AnyShape = EncoderShape | SetShape | ExcerptShape


class Encoder(Protocol):
    """Turns the tokens of a scene into its state."""

    def encode(self, tokens: NDArray[np.float32], /) -> NDArray[np.float32]:
        """(N, COLUMNS) -> (state,)."""


@dataclass(frozen=True, slots=True)
class Kind:
    """How the policies of one kind are built."""

    shape: type[AnyShape]
    compiled: Callable[[Any, Tensors], Encoder]
    bins: int  # of the action, evenly from -1 to 1, as logits; 0: the action itself
    about: str

    @property
    def outputs(self) -> int:
        """Of the head: the action, and the logit of the lane change at the end."""
        return max(self.bins, 1) + 1


KINDS: dict[str, Kind] = {
    "neural": Kind(EncoderShape, CompiledEncoder, 21, "a transformer over objects, road and stop lines"),
    "ego_mlp": Kind(
        ExcerptShape, CompiledExcerpt, 21, "a perceptron that sees its own motion and road, and nobody else"
    ),
    "deep_sets": Kind(SetShape, CompiledSetEncoder, 0, "the largest values over all tokens, and a regressed action"),
}


def shapes_of(checkpoint: Checkpoint, path: Path) -> tuple[AnyShape, HeadShape]:
    """The shapes of a model's encoder and head.

    Raises:
        InputError: it was trained on other tokens.
    """
    kind, configuration = KINDS[checkpoint.header["kind"]], checkpoint.header["configuration"]
    foreign = InputError(str(path), "was trained on other tokens", "train it again with 'roadmend train policy'")
    try:
        encoder = kind.shape.model_validate_json(json.dumps(configuration["encoder"]))
        head = HeadShape.model_validate_json(json.dumps(configuration["head"]))
    except (KeyError, TypeError, ValidationError):
        raise foreign from None
    is_beyond = isinstance(encoder, ExcerptShape) and max(token for token, _ in encoder.places) > len(PLACES)
    if is_beyond or encoder.attributes != COLUMNS or head.outputs != kind.outputs or head.inputs != encoder.state:
        raise foreign
    return encoder, head
