"""What a stage of ADReFT's training is given: whom it trains for, and how it runs."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from numpy.typing import NDArray

from roadmend.training.adreft.network import digest_of_cases
from roadmend.training.closed_loop import EpisodeCase

Tensors = dict[str, NDArray[Any]]  # of networks, by name
Report = Callable[[str, int, int, str], None]  # what is done, how much of it, of how much, and a word on how it goes

PRACTICE_STATE = "practice-{}.safetensors"  # file of the state of a round


@dataclass(frozen=True, slots=True)
class RepairedPolicy:
    """A policy, and the cases that its repair is learned from."""

    policy: str
    policy_digest: str  # of the policy's model; empty where it has none
    corpus_digest: str
    training: Sequence[EpisodeCase]

    def as_header(self) -> dict[str, str]:
        """What a model's header says of it."""
        return {"corpus": self.corpus_digest, "policy": self.policy_digest, "training": digest_of_cases(self.training)}


@dataclass(frozen=True, slots=True)
class TrainingSubject:
    """Whom the model is trained for, and on what."""

    driver: RepairedPolicy
    validation: Sequence[EpisodeCase]
    also: Sequence[RepairedPolicy] = ()  # their trials are practised on too: braking does much the same under any


@dataclass(frozen=True, slots=True)
class StageRun:
    """The chance that decides it, the machine, and where its state is kept."""

    seed: int
    device: str  # torch's name of where to compute
    state: Path  # file of the state; one that exists is gone on with
    log: Path | None = None  # folder for TensorBoard


def spread(cases: Sequence[EpisodeCase], number: int) -> list[EpisodeCase]:
    """``number`` of the cases, the same share of every family and kind, in their order; 0 stands for all."""
    if not number or number >= len(cases):
        return list(cases)
    groups: dict[tuple[str, bool], list[int]] = {}
    for index, case in enumerate(cases):
        groups.setdefault((case.family, case.is_violation), []).append(index)
    chosen: list[int] = []
    turn = 0
    while len(chosen) < number:
        for group in groups.values():
            if turn < len(group) and len(chosen) < number:
                chosen.append(group[turn])
        turn += 1
    return [cases[index] for index in sorted(chosen)]
