"""The folder of a BERT encoder, as the transformers library writes it: what a text encoder begins from."""

import io
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import safetensors.numpy
from numpy.typing import NDArray
from pydantic import BaseModel, ConfigDict, ValidationError
from safetensors import SafetensorError

from roadmend.core.bounded_file import read_bytes, read_text
from roadmend.core.bounds import MODEL, SETTINGS
from roadmend.core.errors import InputError
from roadmend.core.json_text import read_json
from roadmend.core.settings import describe
from roadmend.networks.shape import TextShape

_MEND = "give the folder of a BERT encoder, with config.json, vocab.txt or tokenizer.json, and model.safetensors"
_SCOPES = ("", "bert.")  # that stand before the names of the tensors


class _Configuration(BaseModel):
    model_config = ConfigDict(extra="ignore")
    hidden_size: int
    num_hidden_layers: int
    num_attention_heads: int
    intermediate_size: int
    max_position_embeddings: int
    hidden_act: str


def read_bert(folder: Path, marks: int) -> tuple[TextShape, dict[str, NDArray[np.float32]], list[str]]:
    """Read an encoder.

    Args:
        folder: with config.json, vocab.txt or tokenizer.json, and model.safetensors.
        marks: that its pieces shall be able to bear, 0 for none among them.

    Returns:
        Its shape, its weights under the names of networks.encoder.TextEncoder (its marks not among them), and its
        vocabulary.

    Raises:
        InputError: a file is missing, damaged, or that of another kind of network.
    """
    where = str(folder)
    try:
        settings = _Configuration.model_validate(_json(folder / "config.json"))
    except ValidationError:
        raise InputError(str(folder / "config.json"), "is not that of a BERT encoder", _MEND) from None
    if settings.hidden_act != "gelu":
        raise InputError(where, f"its layers rectify by {settings.hidden_act!r}, not by GELU", _MEND)
    vocabulary = _vocabulary(folder)
    try:
        shape = TextShape(
            pieces=len(vocabulary),
            positions=settings.max_position_embeddings,
            marks=marks,
            hidden=settings.hidden_size,
            layers=settings.num_hidden_layers,
            heads=settings.num_attention_heads,
            feed_forward=settings.intermediate_size,
        )
    except ValidationError as error:
        what = f"its encoder has another shape than can be read with: {describe(error, TextShape)}"
        raise InputError(where, what, "give a BERT encoder within that bound") from None
    try:
        found = safetensors.numpy.load(read_bytes(folder / "model.safetensors", MODEL, _MEND))
        return shape, _named(found, shape), vocabulary
    except (SafetensorError, KeyError, ValueError) as error:
        raise InputError(where, f"its weights are not those of a BERT encoder ({error})", _MEND) from None


def fewer_pieces(
    tensors: dict[str, NDArray[np.float32]], vocabulary: Sequence[str], kept: Sequence[int]
) -> tuple[dict[str, NDArray[np.float32]], list[str]]:
    """An encoder that knows only some of its pieces, by their places; other words fall apart into smaller ones."""
    return {**tensors, "pieces.weight": tensors["pieces.weight"][[*kept]]}, [vocabulary[place] for place in kept]


def _named(found: dict[str, NDArray[Any]], shape: TextShape) -> dict[str, NDArray[np.float32]]:
    scope = next((scope for scope in _SCOPES if f"{scope}embeddings.word_embeddings.weight" in found), None)
    if scope is None:
        raise ValueError("there are no word embeddings")

    def of(name: str) -> NDArray[np.float32]:
        values: NDArray[np.float32] = found[f"{scope}{name}"].astype(np.float32)
        return values

    words = of("embeddings.word_embeddings.weight")
    if words.shape != (shape.pieces, shape.hidden):
        raise ValueError(f"word embeddings of shape {words.shape} for {shape.pieces} pieces")
    kinds = of("embeddings.token_type_embeddings.weight")
    if not kinds.size:
        raise ValueError("there are no types of tokens")
    kind = kinds[0]  # all texts are of the first kind
    named = {"pieces.weight": words, "positions.weight": of("embeddings.position_embeddings.weight") + kind}
    named |= {f"norm.{part}": of(f"embeddings.LayerNorm.{part}") for part in ("weight", "bias")}
    for place in range(shape.layers):
        own = f"encoder.layer.{place}."
        for part in ("weight", "bias"):
            rows = [of(f"{own}attention.self.{name}.{part}") for name in ("query", "key", "value")]
            named[f"layers.{place}.attention_in.{part}"] = np.concatenate(rows)
            for name, theirs in (
                ("attention_out", "attention.output.dense"),
                ("norm1", "attention.output.LayerNorm"),
                ("feed_in", "intermediate.dense"),
                ("feed_out", "output.dense"),
                ("norm2", "output.LayerNorm"),
            ):
                named[f"layers.{place}.{name}.{part}"] = of(f"{own}{theirs}.{part}")
    return named


def _vocabulary(folder: Path) -> list[str]:
    listed = folder / "vocab.txt"
    if listed.is_file():
        # Not splitlines: what ends a line to Unicode is a piece of its own in some vocabularies.
        lines = io.StringIO(read_text(listed, SETTINGS, _MEND))
        return [line.removesuffix("\n") for line in lines]
    content = _json(folder / "tokenizer.json")
    model = content.get("model")
    places = model.get("vocab") if isinstance(model, dict) else None
    is_listed = isinstance(places, dict) and all(type(place) is int for place in places.values())
    if not isinstance(places, dict) or not is_listed or {*places.values()} != {*range(len(places))}:
        raise InputError(str(folder / "tokenizer.json"), "holds no vocabulary of pieces of words", _MEND)
    return sorted(places, key=lambda piece: int(places[piece]))


def _json(path: Path) -> dict[str, Any]:
    content = read_json(path, SETTINGS, _MEND)
    if not isinstance(content, dict):
        raise InputError(str(path), "holds no fields", _MEND)
    return content
