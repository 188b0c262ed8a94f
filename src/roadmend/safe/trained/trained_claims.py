"""What the trained reader says of a summary, as claims for the solver to weigh beside those of the rules."""

import math
from collections.abc import Iterator, Mapping
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from roadmend.core.errors import InputError
from roadmend.networks.checkpoint import find_model
from roadmend.safe.claims import AnyClaim, Claim, ClaimSource, DirectionClaim
from roadmend.safe.dsl import RoadType
from roadmend.safe.reading.limits import possible_limits
from roadmend.safe.reading.reader import SummaryClaims
from roadmend.safe.trained.crash_network import Answers, CrashNetwork
from roadmend.safe.trained.marked_text import NamedCrash, mark_text
from roadmend.safe.trained.outputs import CLAIMED, OF_TEXT, OF_VEHICLE, RELATION, ROADS, SEATS, ReaderQuestion
from roadmend.safe.trained.parties import find_parties, is_numbered, recast

SHIPPED = "crash-text"
_TURNS = 4  # a text is read as it stands and with its compass turned, and what comes out is averaged
_REASON = "the trained reader takes the text so"
_SURELY = 1e-4  # no probability is nearer to 0 or 1
_FEW = 8  # values of a question whose every answer is claimed or disclaimed
_WORTH_SAYING = 0.1  # least probability of an answer among more than these
_CAST = "cast"  # in the header's "trust": how sure the network must be of all who took part, where the rules find fewer


def trained_claims(summary: str, said: SummaryClaims) -> tuple[SummaryClaims, tuple[AnyClaim, ...]]:
    """What the rules say with the cast as the shipped network has it, and its claims; none of more vehicles than it can tell apart.

    Raises:
        InputError: the model is missing or damaged, or a library that it needs is not installed.
    """
    return TrainedReader(_shipped()).read(summary, said)


def trained_reader() -> str:
    """The shipped network by name and digest, for a result to say.

    Raises:
        InputError: as for its claims.
    """
    return f"{SHIPPED} {_shipped().digest[:12]}"


class TrainedReader:
    """Makes claims of a summary.

    Args:
        network: that reads it. Its header's "trust" says by question how much of its log-odds count.

    Raises:
        InputError: it does not say so of every question.
    """

    def __init__(self, network: CrashNetwork) -> None:
        self.network = network
        self.trust: Mapping[str, float] = network.header.get("trust") or {}
        names = [_CAST, *(each.name for each in CLAIMED)]
        if missing := [name for name in names if not isinstance(self.trust.get(name), int | float)]:
            what = f"does not say how far its answers about {missing[0]} are trusted"
            raise InputError(network.where, what, "give another file")

    def read(self, summary: str, said: SummaryClaims) -> tuple[SummaryClaims, tuple[AnyClaim, ...]]:
        """What the rules say with those whom they lack in the cast, and all that the network claims, about vehicles by their place in the cast."""
        parties = [] if is_numbered(said) else find_parties(self.network, summary)
        found = recast(summary, said, parties, self.trust[_CAST])
        if not 0 < len(found.said.kept) <= SEATS:
            return found.said, ()
        return found.said, tuple(self._claims(possible_limits(said.text), self.answers(found.crash), found.said.kept))

    def answers(self, crash: NamedCrash) -> Answers:
        """The mean of what it answers, the compass turned by each number of quarters and the answers turned back."""
        found = [
            _turned_back(self.network.answer(mark_text(crash.turned(quarters), self.network.pieces)), quarters)
            for quarters in range(_TURNS)
        ]
        return Answers(*(_mean([getattr(each, group) for each in found]) for group in ("vehicles", "pairs", "text")))

    def _claims(self, limits: frozenset[int], answers: Answers, kept: tuple[int, ...]) -> Iterator[AnyClaim]:
        merges = ROADS[int(answers.text["road_type"].argmax())] is RoadType.MERGING
        for seat, place in enumerate(kept):
            for asked in OF_VEHICLE:
                if asked.name == "ramp" and not merges:
                    continue  # elsewhere nobody was asked in training
                for each in self._of(f"vehicles[{place}].{asked.field}", asked, answers.vehicles[asked.name][seat]):
                    if asked.name != "speed_limit" or each.value in limits:
                        yield each
        for first in range(len(kept)):
            for second in range(first + 1, len(kept)):
                shares = answers.pairs[RELATION.name][first, second]
                for relation, share in zip(RELATION.values, shares, strict=True):
                    held = self._held(RELATION, share)
                    yield DirectionClaim(kept[first], kept[second], relation, held, ClaimSource.TRAINED, _REASON)
        for asked in OF_TEXT:
            shares = answers.text[asked.name]
            if asked.values[int(shares.argmax())] is not None:  # else the text does not tell it
                yield from self._of(asked.field, asked, shares)

    def _of(self, path: str, asked: ReaderQuestion, shares: Any) -> Iterator[Claim]:
        for value, share in zip(asked.values, shares, strict=True):
            if value is not None and (len(asked.values) <= _FEW or share >= _WORTH_SAYING):
                yield Claim(path, value, self._held(asked, share), ClaimSource.TRAINED, _REASON)

    def _held(self, asked: ReaderQuestion, share: float) -> float:
        """A probability whose log-odds count as far as they are trusted."""
        share = min(max(float(share), _SURELY), 1.0 - _SURELY)
        return 1.0 / (1.0 + math.exp(-self.trust[asked.name] * math.log(share / (1.0 - share))))


def _turned_back(answers: Answers, quarters: int) -> Answers:
    heading = np.roll(answers.vehicles["heading"], -quarters, axis=-1)
    stem = np.roll(answers.text["stem"], -quarters, axis=-1)
    return Answers({**answers.vehicles, "heading": heading}, answers.pairs, {**answers.text, "stem": stem})


def _mean(groups: list[Mapping[str, Any]]) -> dict[str, Any]:
    return {name: sum(group[name] for group in groups) / len(groups) for name in groups[0]}


@cache
def _shipped() -> CrashNetwork:
    return CrashNetwork(Path(find_model(SHIPPED)))
