"""What the trained reader says of a summary, as claims for the solver to weigh beside those of the rules."""

import math
from collections.abc import Iterator, Mapping
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from roadmend.networks.checkpoint import find_model
from roadmend.safe.claims import AnyClaim, Claim, ClaimSource, DirectionClaim
from roadmend.safe.reading.reader import SummaryClaims
from roadmend.safe.trained.crash_network import Answers, CrashNetwork
from roadmend.safe.trained.marked_text import SEATS, mark_text, named_crash
from roadmend.safe.trained.outputs import HEADINGS, LANES, RELATIONS, ROADS, STEMS

SHIPPED = "crash-text"
_TURNS = 4  # a text is read as it stands and with its compass turned, and what comes out is averaged
_REASON = "the trained reader takes the text so"
_SURELY = 1e-4  # no probability is nearer to 0 or 1


def trained_claims(summary: str, said: SummaryClaims) -> tuple[AnyClaim, ...]:
    """The claims of the shipped network; none where the text speaks of more vehicles than it can tell apart.

    Raises:
        InputError: the model is missing or damaged, or a library that it needs is not installed.
    """
    return TrainedReader(_shipped()).claims(summary, said)


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
    """

    def __init__(self, network: CrashNetwork) -> None:
        self.network = network
        self.trust: Mapping[str, float] = network.header["trust"]

    def claims(self, summary: str, said: SummaryClaims) -> tuple[AnyClaim, ...]:
        """All that it claims, about the vehicles that took part by their place in the cast."""
        if not 0 < len(said.kept) <= SEATS:
            return ()
        return tuple(self._claims(self.answers(summary, said), said.kept))

    def answers(self, summary: str, said: SummaryClaims) -> Answers:
        """The mean of what it answers, the compass turned by each number of quarters and the answers turned back."""
        crash = named_crash(summary, said)
        found = [
            _turned_back(self.network.answer(mark_text(crash.turned(quarters), self.network.pieces)), quarters)
            for quarters in range(_TURNS)
        ]
        return Answers(*(_mean([getattr(each, group) for each in found]) for group in ("vehicles", "pairs", "text")))

    def _claims(self, answers: Answers, kept: tuple[int, ...]) -> Iterator[AnyClaim]:
        for seat, place in enumerate(kept):
            path = f"vehicles[{place}].initial_position"
            yield from self._of(path, "heading", HEADINGS, answers.vehicles["heading"][seat])
        for first in range(len(kept)):
            for second in range(first + 1, len(kept)):
                for relation, share in zip(RELATIONS, answers.pairs["relation"][first, second], strict=True):
                    yield DirectionClaim(
                        kept[first], kept[second], relation, self._held("relation", share), ClaimSource.TRAINED, _REASON
                    )
        yield from self._of("road_type", "road_type", ROADS, answers.text["road_type"])
        yield from self._of("stem_direction", "stem", STEMS, answers.text["stem"])
        yield from self._of("num_lanes", "lanes", LANES, answers.text["lanes"])

    def _of(self, path: str, question: str, values: tuple[Any, ...], shares: Any) -> Iterator[Claim]:
        for value, share in zip(values, shares, strict=True):
            yield Claim(path, value, self._held(question, share), ClaimSource.TRAINED, _REASON)

    def _held(self, question: str, share: float) -> float:
        """A probability whose log-odds count as far as they are trusted."""
        share = min(max(float(share), _SURELY), 1.0 - _SURELY)
        return 1.0 / (1.0 + math.exp(-self.trust[question] * math.log(share / (1.0 - share))))


def _turned_back(answers: Answers, quarters: int) -> Answers:
    heading = np.roll(answers.vehicles["heading"], -quarters, axis=-1)
    stem = np.roll(answers.text["stem"], -quarters, axis=-1)
    return Answers({**answers.vehicles, "heading": heading}, answers.pairs, {**answers.text, "stem": stem})


def _mean(groups: list[Mapping[str, Any]]) -> dict[str, Any]:
    return {name: sum(group[name] for group in groups) / len(groups) for name in groups[0]}


@cache
def _shipped() -> CrashNetwork:
    return CrashNetwork(Path(find_model(SHIPPED)))
