"""The training of the trained reader: made-up crashes first, told ones after, and what it has learned on those held out."""

import hashlib
import random
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from pydantic import Field, field_validator

from roadmend.core.bounded_file import read_bytes
from roadmend.core.bounds import MODEL
from roadmend.core.errors import InputError
from roadmend.core.fanout import Mapper
from roadmend.core.journal import entry_key
from roadmend.core.parameters import Parameters
from roadmend.networks.bert_files import fewer_pieces, read_bert
from roadmend.networks.tensors import rounded
from roadmend.safe.trained.crash_network import head_shapes
from roadmend.safe.trained.lessons import CrashLesson, questions_of_training
from roadmend.safe.trained.made_up import made_up_lesson
from roadmend.safe.trained.marked_text import MARKS
from roadmend.safe.trained.outputs import CLAIMED, OF_PAIR, OF_PIECE, OF_TEXT, OF_VEHICLE, ReaderQuestion
from roadmend.safe.trained.told_crashes import ToldCrash, told_lessons, told_line
from roadmend.safe.trained.word_pieces import BEGIN, END, UNKNOWN, WordPieces
from roadmend.training.text_reading import (
    UNASKED,
    Draw,
    Pace,
    TextNetwork,
    TextSample,
    begin_network,
    fit,
    logits_of,
)
from roadmend.training.torch_state import tensors_of

_TRUST = {each.name: 0.25 for each in CLAIMED} | {
    "action": 0.4,
    "model": 0.5,
    "speed_limit": 0.5,
    "road_type": 0.2,
    "stem": 0.15,
    "lanes": 0.25,
    "cast": 0.8,
}
_ROUNDS = 8  # in which made-up crashes are taught, the state being kept after each
_LONGEST_SIGN = 3  # letters of pieces that are always kept, so that every word falls apart into something

Told = Callable[[str, int, int, float], None]  # a stage, how much of how much is done, and the loss


class Schooling(Parameters):
    """How the trained reader is trained."""

    made_up: int = Field(40_000, ge=0, le=1_000_000, description="made-up crashes to begin with")
    beside: int = Field(300, ge=0, le=100_000, description="made-up crashes in every epoch of told ones")
    epochs: int = Field(10, ge=1, le=200, description="passes through the told crashes")
    batch: int = Field(16, ge=1, le=256, description="texts a step; of made-up ones, which are short, twice as many")
    learning_rate: float = Field(
        1e-4, gt=0.0, le=0.1, description="of the encoder; rises, then falls to 2 % along a line"
    )
    made_up_learning_rate: float = Field(
        5e-5, gt=0.0, le=0.1, description="with made-up crashes, which say little that real texts do"
    )
    dropout: float = Field(0.1, ge=0.0, le=0.9, description="share of values dropped in training")
    pieces: int = Field(
        12_000, ge=100, le=200_000, description="most common pieces that are kept, beside those of the texts"
    )
    trust: dict[str, float] = Field(
        _TRUST,
        description="share of the network's log-odds that counts beside the rules' claims; of the cast, the certainty that adds to it",
    )
    held_out: tuple[str, ...] = Field((), description="authors whose texts are not learned from, but measured on")

    @field_validator("trust")
    @classmethod
    def _check_trust(cls, trust: dict[str, float]) -> dict[str, float]:
        if {*trust} != {*_TRUST}:
            raise ValueError(f"give a number for each of {', '.join(_TRUST)}, and for nothing else")
        if not all(0.0 <= share <= 1.0 for share in trust.values()):
            raise ValueError("each share lies between 0 and 1")
        return trust


@dataclass(frozen=True, slots=True)
class Schooled:
    """What came of it.

    Attributes:
        tensors: of the model's file.
        header: the rest of it, but for how the command was called.
    """

    tensors: dict[str, Any]
    header: dict[str, Any]


def school(
    told: Sequence[ToldCrash],
    base: Path,
    settings: Schooling,
    seed: int,
    work: Path,
    mapper: Mapper,
    watch: Told,
    device: str = "cpu",
) -> Schooled:
    """Train.

    Args:
        told: crashes to learn from and to be measured on.
        base: folder of the BERT encoder to begin from.
        settings: how.
        seed: of all that is drawn.
        work: folder for the state of the training, which goes on there if it was interrupted.
        mapper: reads the texts by the rules, which find the names.
        watch: hears how far it has come.
        device: of torch, to compute on.

    Raises:
        InputError: the encoder is missing or damaged, the folder holds something else, or an author who is to be held out
            wrote nothing.
    """
    absent = [author for author in settings.held_out if author not in {crash.author for crash in told}]
    if absent:
        what = f"{', '.join(absent)} wrote none of the told crashes"
        raise InputError("held_out", what, f"choose of {', '.join(sorted({crash.author for crash in told}))}")
    shape, tensors, vocabulary = read_bert(base, MARKS)
    encoder = hashlib.sha256(read_bytes(base / "model.safetensors", MODEL, "give an encoder")).hexdigest()
    data = hashlib.sha256("\n".join(map(told_line, told)).encode()).hexdigest()
    decided = settings.model_dump(mode="json", exclude={"trust"})
    identity = entry_key([__name__], decided, seed, data, encoder)
    lessons, measured = list[CrashLesson](), list[CrashLesson]()
    for crash, lesson in zip(told, told_lessons(told, work, mapper, partial(_read, watch, len(told))), strict=True):
        if lesson is not None:
            (measured if crash.author in settings.held_out else lessons).append(lesson)
    kept = _kept(vocabulary, lessons, settings.pieces)
    tensors, vocabulary = fewer_pieces(tensors, vocabulary, kept)
    shape = shape.model_copy(update={"pieces": len(kept)})
    pieces = WordPieces(vocabulary)
    network = begin_network(shape, head_shapes(shape.hidden), tensors, settings.dropout, seed).to(device)

    def made_up(generator: random.Random) -> TextSample:
        return made_up_lesson(generator).draw(pieces, shape.positions, generator)

    def teach(stage: str, draws: Sequence[Draw], pace: Pace) -> None:
        keep = work / stage.replace(" ", "-")
        fit(network, draws, questions_of_training(), pace, keep, identity, partial(_tell, watch, stage))

    if settings.made_up:
        each = -(-settings.made_up // _ROUNDS)
        teach(
            "made-up crashes", [made_up] * each, Pace(_ROUNDS, 2 * settings.batch, settings.made_up_learning_rate, seed)
        )
    draws: list[Draw] = [partial(lesson.draw, pieces, shape.positions) for lesson in lessons]
    draws += [made_up] * settings.beside
    teach("told crashes", draws, Pace(settings.epochs, settings.batch, settings.learning_rate, seed + 1))
    metrics = {"lessons": len(lessons), "held_out": len(measured), **_measure(network, measured, pieces)}
    header = {
        "configuration": {**settings.model_dump(mode="json"), "seed": seed},
        "metrics": metrics,
        "shape": shape.model_dump(mode="json"),
        "vocabulary": vocabulary,
        "trust": dict(settings.trust),
        "data_digest": data,
        "ancestry": [encoder],
    }
    return Schooled(rounded(tensors_of(network)), header)


def _read(watch: Told, of: int, done: int) -> None:
    watch("reading", done, of, 0.0)


def _tell(watch: Told, stage: str, done: int, of: int, loss: float) -> None:
    watch(stage, done, of, loss)


def _kept(vocabulary: Sequence[str], lessons: Sequence[CrashLesson], most: int) -> list[int]:
    """Places of the pieces that stay: common ones, which a vocabulary of BERT has first, short ones, and those of the texts."""
    whole = WordPieces(vocabulary)
    used = {UNKNOWN, BEGIN, END}
    for lesson in lessons:
        for quarters in range(4):
            used |= {vocabulary[place] for place in whole.split(lesson.crash.turned(quarters).text)[0]}
    plain = [place for place, piece in enumerate(vocabulary) if piece.isascii() and not piece.startswith("[")]
    signs = [place for place in plain if len(vocabulary[place].removeprefix("##")) < _LONGEST_SIGN]
    return sorted({*plain[:most], *signs, *(place for place, piece in enumerate(vocabulary) if piece in used)})


def _measure(network: TextNetwork, lessons: Sequence[CrashLesson], pieces: WordPieces) -> Mapping[str, float]:
    """Of the questions that can be asked about the lessons, the share that is answered right, by question."""
    right: dict[str, list[bool]] = {}
    generator = random.Random(0)
    for lesson in lessons:
        sample = lesson.draw(pieces, network.encoder.shape.positions, generator)
        known = (sample.vehicles, sample.pairs, sample.text, sample.parties)
        for questions, found, answers in zip(
            (OF_VEHICLE, OF_PAIR, OF_TEXT, OF_PIECE), logits_of(network, sample), known, strict=True
        ):
            _count(questions, found, answers, right)
    return {name: round(float(np.mean(marks)), 4) for name, marks in right.items() if marks}


def _count(questions: Sequence[ReaderQuestion], logits: Any, answers: Any, right: dict[str, list[bool]]) -> None:
    at = 0
    for place, question in enumerate(questions):
        best = logits[..., at : at + len(question.values)].argmax(-1)
        at += len(question.values)
        asked = answers[..., place]
        right.setdefault(question.name, []).extend((best == asked)[asked != UNASKED].tolist())
