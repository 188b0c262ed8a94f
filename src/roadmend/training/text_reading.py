"""Fits a network that answers questions about texts, the vehicles they name and pairs of these."""

import random
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor, nn
from torch.nn import functional

from roadmend.core.bounded_file import read_text
from roadmend.core.bounds import ARGUMENT
from roadmend.core.errors import InputError
from roadmend.core.whole_file import written_beside
from roadmend.networks.checkpoint import load_checkpoint, save_checkpoint
from roadmend.networks.encoder import Head, TextEncoder
from roadmend.networks.shape import HeadShape, TextShape
from roadmend.training.torch_state import load_optimizer, load_tensors, optimizer_tensors, tensors_of

UNASKED = -1  # an answer that is not known
_SORTED_TOGETHER = 8  # batches whose texts are sorted by their length, so that little is padding
_SMOOTHING = 0.05  # of the answers
_WARM_UP = 0.06  # share of the steps in which the learning rate rises
_LEAST_RATE = 0.02  # share of it that is left at the end
_LARGEST_GRADIENT = 1.0
_HEADS, _WORDS = 10.0, 0.25  # their learning rates, of that of the encoder
_DECAY = 0.01  # of the weights, by AdamW
_KIND = "text_training"  # of the files that a training keeps
_MEMORIES = ("step", "exp_avg", "exp_avg_sq")  # that AdamW has of each parameter
_DONE = "epochs"  # the file that says how many are done

Weights = Sequence[tuple[int, float]]  # of each question of a group: how many answers, and the weight of its loss


@dataclass(frozen=True, slots=True)
class TextSample:
    """One text and what is known of it; UNASKED where nothing is.

    Attributes:
        pieces: (T,) int64.
        marks: (T,) int64.
        shares: (V, T) float32, how much a piece counts for a vehicle.
        vehicles: (V, questions) int64.
        pairs: (V, V, questions) int64.
        text: (questions,) int64.
        parties: (T, questions) int64, of each piece.
    """

    pieces: NDArray[np.int64]
    marks: NDArray[np.int64]
    shares: NDArray[np.float32]
    vehicles: NDArray[np.int64]
    pairs: NDArray[np.int64]
    text: NDArray[np.int64]
    parties: NDArray[np.int64]


Draw = Callable[[random.Random], TextSample]  # a lesson, as it comes this time


@dataclass(frozen=True, slots=True)
class Questions:
    """Of vehicles, of pairs, of the text and of its pieces."""

    vehicles: Weights
    pairs: Weights
    text: Weights
    parties: Weights


class TextNetwork(nn.Module):
    """A text encoder and four heads, under the names of the shipped file."""

    def __init__(self, shape: TextShape, heads: dict[str, HeadShape], dropout: float = 0.0) -> None:
        super().__init__()
        self.encoder = TextEncoder(shape, dropout)
        names = ("vehicle", "pair", "text", "party")
        self.vehicle, self.pair, self.text, self.party = (Head(heads[name]) for name in names)
        self.drop = nn.Dropout(dropout)

    def forward(self, pieces: Tensor, marks: Tensor, mask: Tensor, shares: Tensor) -> tuple[Tensor, ...]:
        """Logits about vehicles (B, V, .), about pairs (B, V, V, .), about texts (B, .), and about pieces (B, T, .).

        Args:
            pieces: (B, T) int64.
            marks: (B, T) int64.
            mask: (B, T) bool, True where a piece is real.
            shares: (B, V, T) float32.
        """
        states = self.encoder(pieces, marks, mask)
        own = shares / shares.sum(-1, keepdim=True).clamp(min=1e-6) @ states
        begin = states[:, :1]
        mean = (states * mask[..., None]).sum(1) / mask.sum(1, keepdim=True)
        count = own.shape[1]
        first, second = own[:, :, None].expand(-1, -1, count, -1), own[:, None].expand(-1, count, -1, -1)
        pairs = torch.cat([first, second, first * second, begin[:, None].expand_as(first)], -1)
        vehicles = torch.cat([own, begin.expand_as(own)], -1)
        return (
            self.vehicle(self.drop(vehicles)),
            self.pair(self.drop(pairs)),
            self.text(self.drop(torch.cat([mean, begin[:, 0]], -1))),
            self.party(self.drop(states)),
        )


def begin_network(
    shape: TextShape, heads: dict[str, HeadShape], encoder: Mapping[str, NDArray[Any]], dropout: float, seed: int
) -> TextNetwork:
    """A network with the weights of an encoder, as far as these are given; all others are drawn."""
    torch.manual_seed(seed)
    network = TextNetwork(shape, heads, dropout)
    network.encoder.load_state_dict({name: torch.from_numpy(value) for name, value in encoder.items()}, strict=False)
    return network


@torch.no_grad()
def logits_of(network: TextNetwork, sample: TextSample) -> tuple[NDArray[np.float32], ...]:
    """What a network says of one text: about its vehicles (V, .), pairs of them (V, V, .), the text (.) and its pieces (T, .)."""
    return tuple(each[0].cpu().numpy() for each in network(*_stacked([sample], _device(network)).inputs))


@dataclass(frozen=True, slots=True)
class _Batch:
    inputs: tuple[Tensor, Tensor, Tensor, Tensor]
    vehicles: Tensor
    pairs: Tensor
    text: Tensor
    parties: Tensor


@dataclass(frozen=True, slots=True)
class Pace:
    """How lessons are taught.

    Attributes:
        epochs: times that each is.
        batch: lessons at a time.
        learning_rate: of the encoder; that of its words is a quarter of it, that of the heads ten times.
        seed: of all that is drawn.
    """

    epochs: int
    batch: int
    learning_rate: float
    seed: int


def fit(
    network: TextNetwork,
    lessons: Sequence[Draw],
    questions: Questions,
    pace: Pace,
    keep: Path,
    identity: str,
    told: Callable[[int, int, float], None],
) -> None:
    """Teach the lessons, each once an epoch, in an order and a form that are drawn.

    Args:
        network: learns, in place, on the device that it is on.
        lessons: to be drawn anew in every epoch.
        questions: that they answer.
        pace: how.
        keep: folder for the state after the last epoch; where it holds one of the same training, that goes on, and comes
            to the same in the end.
        identity: digest of all that decides what comes out.
        told: hears after every step how many are done of how many, and the loss of the last [nat].

    Raises:
        InputError: the folder holds the state of something else, or cannot be written.
    """
    device = _device(network)
    groups = _groups(network, pace.learning_rate)
    optimizer = torch.optim.AdamW(groups, weight_decay=_DECAY)
    whole, rest = divmod(len(lessons), pace.batch * _SORTED_TOGETHER)
    steps = whole * _SORTED_TOGETHER + -(-rest // pace.batch)  # an epoch
    rising = max(1, round(_WARM_UP * steps * pace.epochs))
    begin = load_training(keep, network, optimizer, identity)
    network.train()
    for epoch in range(begin, pace.epochs):
        generator = random.Random(f"roadmend/text-reading/{pace.seed}/{epoch}")
        torch.manual_seed(generator.getrandbits(63))
        for step, samples in enumerate(_batches(lessons, pace.batch, generator), start=epoch * steps):
            share = min(1.0, (step + 1) / rising) * max(_LEAST_RATE, 1.0 - step / (steps * pace.epochs))
            for group, own in zip(optimizer.param_groups, groups, strict=True):
                group["lr"] = share * own["rate"]
            loss = _loss(network, _stacked(samples, device), questions)
            optimizer.zero_grad()
            loss.backward()  # type: ignore[no-untyped-call]
            nn.utils.clip_grad_norm_(network.parameters(), _LARGEST_GRADIENT)
            optimizer.step()
            told(step + 1, steps * pace.epochs, float(loss.detach()))
        save_training(keep, network, optimizer, epoch + 1, identity)
    network.eval()


def _device(network: TextNetwork) -> torch.device:
    return network.encoder.pieces.weight.device


def _groups(network: TextNetwork, rate: float) -> list[dict[str, Any]]:
    words = [*network.encoder.pieces.parameters()]
    encoder = [each for name, each in network.encoder.named_parameters() if not name.startswith("pieces.")]
    heads = [each for name, each in network.named_parameters() if not name.startswith("encoder.")]
    rates = zip((encoder, words, heads), (rate, rate * _WORDS, rate * _HEADS), strict=True)
    return [{"params": each, "lr": own, "rate": own} for each, own in rates]


def save_training(
    folder: Path, network: nn.Module, optimizer: torch.optim.Optimizer, epochs: int, identity: str
) -> None:
    """Keep the state of a training, by its identity, after some epochs, whole or not at all.

    Raises:
        InputError: it cannot be written.
    """
    weights = tensors_of(network)
    memory = optimizer_tensors(optimizer, "")
    header = {
        "kind": _KIND,
        "configuration": {"epochs": epochs},
        "data_digest": identity,
        "metrics": {},
        "ancestry": [],
    }
    parts = {"weights": weights} | {
        part: {name: value for name, value in memory.items() if name.endswith(f".{part}")} for part in _MEMORIES
    }
    for part, tensors in parts.items():  # apart, for together they are larger than a model may be
        save_checkpoint(folder / f"{part}-{epochs}.safetensors", tensors, header)
    with written_beside(folder / _DONE) as beside:
        beside.write_text(f"{epochs}\n", encoding="utf-8")
    for part in parts:
        (folder / f"{part}-{epochs - 1}.safetensors").unlink(missing_ok=True)


def load_training(folder: Path, network: nn.Module, optimizer: torch.optim.Optimizer, identity: str) -> int:
    """Give a training the state that was kept, and say after how many epochs that was; 0 where none was.

    Raises:
        InputError: what was kept is damaged, or of another training.
    """
    done = folder / _DONE
    if not done.is_file():
        return 0
    text = read_text(done, ARGUMENT).strip()
    if not text.isdecimal():
        raise InputError(str(done), "says no number of epochs", "remove the folder, and begin anew")
    files = {part: load_checkpoint(folder / f"{part}-{text}.safetensors", _KIND) for part in ("weights", *_MEMORIES)}
    if any(file.header["data_digest"] != identity for file in files.values()):
        what = "holds a training of other texts, settings, seed, encoder or code"
        raise InputError(str(folder), what, "give another folder, or remove this one")
    found = {part: file.tensors for part, file in files.items()}
    try:
        load_tensors(network, found["weights"])
    except RuntimeError:
        raise InputError(str(folder), "holds no whole training", "remove it, and begin anew") from None
    load_optimizer(optimizer, {name: value for part in _MEMORIES for name, value in found[part].items()}, "")
    return int(text)


def _batches(lessons: Sequence[Draw], batch: int, generator: random.Random) -> Iterator[Sequence[TextSample]]:
    order = [*lessons]
    generator.shuffle(order)
    together = batch * _SORTED_TOGETHER
    for start in range(0, len(order), together):
        drawn = sorted((draw(generator) for draw in order[start : start + together]), key=lambda each: len(each.pieces))
        rows = [drawn[at : at + batch] for at in range(0, len(drawn), batch)]
        generator.shuffle(rows)
        yield from rows


def _stacked(samples: Sequence[TextSample], device: torch.device) -> _Batch:
    size, length = len(samples), max(len(each.pieces) for each in samples)
    count = max(len(each.shares) for each in samples)
    pieces, marks = (torch.zeros(size, length, dtype=torch.int64) for _ in range(2))
    mask, shares = torch.zeros(size, length, dtype=torch.bool), torch.zeros(size, count, length)
    vehicles = torch.full((size, count, samples[0].vehicles.shape[-1]), UNASKED)
    pairs = torch.full((size, count, count, samples[0].pairs.shape[-1]), UNASKED)
    parties = torch.full((size, length, samples[0].parties.shape[-1]), UNASKED)
    for at, each in enumerate(samples):
        own, end = len(each.shares), len(each.pieces)
        pieces[at, :end], marks[at, :end] = torch.from_numpy(each.pieces), torch.from_numpy(each.marks)
        mask[at, :end], parties[at, :end] = True, torch.from_numpy(each.parties)
        shares[at, :own, :end] = torch.from_numpy(each.shares)
        vehicles[at, :own], pairs[at, :own, :own] = torch.from_numpy(each.vehicles), torch.from_numpy(each.pairs)
    text = torch.stack([torch.from_numpy(each.text) for each in samples])
    pieces, marks, mask, shares, vehicles, pairs, text, parties = (
        each.to(device) for each in (pieces, marks, mask, shares, vehicles, pairs, text, parties)
    )
    return _Batch((pieces, marks, mask, shares), vehicles, pairs, text, parties)


def _loss(network: TextNetwork, batch: _Batch, questions: Questions) -> Tensor:
    """The weighted sum of the cross entropies of all questions [nat]."""
    total = torch.zeros((), device=batch.text.device)
    wanted = (
        (questions.vehicles, batch.vehicles),
        (questions.pairs, batch.pairs),
        (questions.text, batch.text),
        (questions.parties, batch.parties),
    )
    with torch.autocast(batch.text.device.type, torch.bfloat16):  # in half of the time
        answered = network(*batch.inputs)
    for outputs, (weights, answers) in zip(answered, wanted, strict=True):
        logits, at = outputs.float(), 0
        for place, (count, weight) in enumerate(weights):
            own, known = logits[..., at : at + count].reshape(-1, count), answers[..., place].reshape(-1)
            at += count
            if (known != UNASKED).any():
                total = total + weight * functional.cross_entropy(
                    own, known, ignore_index=UNASKED, label_smoothing=_SMOOTHING
                )
    return total
