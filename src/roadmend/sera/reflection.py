"""The second look: a selection as a whole, and swaps that mend it, each with its reason.

A selection is worth what its entries are worth (how well they fit their pattern, how many of its aspects they show, how
often policies fail in them) less what they repeat of each other. Swaps are made one at a time, the best first,
as long as they gain: a local search that ends, because every swap raises what is worth at most so much.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from roadmend.sera.bank import Bank, Hit
from roadmend.sera.descriptor import Descriptor
from roadmend.sera.pattern import FailurePattern
from roadmend.sera.terms import features
from roadmend.sera.words import words_of, words_of_pattern

_SIMILAR_FROM = 0.8  # cosine from which two entries repeat each other
_LEAST_GAIN = 0.02
_TOO_EASY, _TOO_HARD = "too easy", "too hard"
_DIFFICULTY_COSTS = {_TOO_EASY: 0.5, _TOO_HARD: 0.3, "": 0.0}
_WIDE = 5.0  # [m] from which nobody came near
_USUAL = 0.3  # share of runs that fail of a scenario that nobody has run; as good as one run that was


@dataclass(frozen=True, slots=True)
class Pick:
    """An entry of a selection."""

    number: int  # of the entry in its bank
    pattern: int  # that it was chosen for, as a place among the patterns
    score: float  # cosine to the pattern


@dataclass(frozen=True, slots=True)
class Swap:
    """One entry for another."""

    out: int  # number in the bank
    into: int  # number in the bank
    pattern: int
    gain: float
    reason: str


@dataclass(frozen=True, slots=True)
class Measures:
    """A selection as a whole."""

    coverage: float  # mean share of their pattern's aspects that the entries show, 0 to 1
    diversity: float  # 1 less the mean cosine of pairs
    redundant: int  # pairs that repeat each other
    too_easy: int
    too_hard: int


@dataclass(frozen=True)
class BankCandidate:
    """What reflection knows of an entry."""

    number: int
    name: str
    words: str
    difficulty: str  # too easy, too hard, or neither
    aspects: tuple[frozenset[str], ...]  # of each pattern, those that the entry shows
    runs: int  # of it that are known of
    failures: int  # among those

    @property
    def failing(self) -> float:
        """Share of runs that are to be expected to fail, by what is known: so much there is to learn."""
        return (self.failures + _USUAL) / (self.runs + 1)


@dataclass(frozen=True)
class Pool:
    """Entries to choose from, by their number, with scores for the patterns and likenesses among them."""

    patterns: tuple[str, ...]  # in words
    candidates: tuple[BankCandidate, ...]
    places: dict[int, int]  # number -> place among the candidates
    wanted: tuple[frozenset[str], ...]  # aspects of each pattern that the bank has at all
    scores: NDArray[np.float64]  # shape (patterns, candidates)
    likeness: NDArray[np.float64]  # cosines, shape (candidates, candidates)

    def pick(self, number: int, pattern: int) -> Pick:
        """An entry as chosen for a pattern."""
        return Pick(number, pattern, float(self.scores[pattern, self.places[number]]))

    def coverage(self) -> NDArray[np.float64]:
        """Share of each pattern's aspects that each candidate shows, shape (patterns, candidates)."""
        shown = [
            [len(candidate.aspects[place]) / max(1, len(wanted)) for candidate in self.candidates]
            for place, wanted in enumerate(self.wanted)
        ]
        return np.array(shown).reshape(len(self.wanted), len(self.candidates))


def candidates_of(bank: Bank, patterns: Sequence[FailurePattern], found: Sequence[Sequence[Hit]]) -> Pool:
    """Everything that was found for any pattern."""
    numbers = sorted({hit.number for hits in found for hit in hits})
    entries = [bank.entry(number) for number in numbers]
    shown = [frozenset(features(entry.descriptor).terms) for entry in entries]
    known = frozenset[str]().union(*shown)
    wanted = tuple(frozenset(features(pattern).terms) & known for pattern in patterns)
    candidates = tuple(
        BankCandidate(
            number,
            entry.name,
            words_of(entry.descriptor),
            difficulty_of(entry.descriptor),
            tuple(each & terms for each in wanted),
            sum(each.runs for each in entry.descriptor.outcomes),
            sum(each.failures for each in entry.descriptor.outcomes),
        )
        for number, entry, terms in zip(numbers, entries, shown, strict=True)
    )
    vectors = bank.vectors(numbers).astype(np.float64)
    queries = np.array([bank.embed(pattern) for pattern in patterns], dtype=np.float64)
    return Pool(
        tuple(words_of_pattern(pattern) for pattern in patterns),
        candidates,
        {number: place for place, number in enumerate(numbers)},
        wanted,
        queries @ vectors.T,
        vectors @ vectors.T,
    )


def difficulty_of(descriptor: Descriptor) -> str:
    """Whether there is nothing to learn from a scenario, by what policies have made of it so far.

    Too easy: every run reached the goal, and nobody came near. Too hard: two policies or methods ran it, and not one
    run of any reached the goal.
    """
    share = descriptor.difficulty
    if share is None:
        return ""
    near = [each.min_distance for each in descriptor.outcomes if each.min_distance is not None]
    if share == 0.0 and min(near, default=np.inf) >= _WIDE:
        return _TOO_EASY
    return _TOO_HARD if share == 1.0 and len(descriptor.outcomes) > 1 else ""


class Reflector(Protocol):
    """Looks at a selection as a whole and swaps entries."""

    def reflect(self, pool: Pool, initial: Sequence[Pick]) -> tuple[list[Pick], list[Swap]]:
        """The selection after the swaps, and the swaps; how many each pattern has stays as it is."""


class EmbeddedReflector:
    """Swaps as long as the selection gains by what is measured."""

    def reflect(self, pool: Pool, initial: Sequence[Pick]) -> tuple[list[Pick], list[Swap]]:
        """The selection after the swaps, and the swaps; the same pool and selection give the same."""
        picks, swaps = [*initial], list[Swap]()
        worth = Worth(pool)
        while picks:
            gains = worth.gains(picks)
            row, into = np.unravel_index(int(np.argmax(gains)), gains.shape)
            if not gains[row, into] >= _LEAST_GAIN:  # NaN, of a bank that was damaged, ends it too
                break
            out, new = picks[row], pool.candidates[into].number
            others = [pick for pick in picks if pick is not out]
            swaps.append(
                Swap(out.number, new, out.pattern, float(gains[row, into]), worth.reason(out, int(into), others))
            )
            picks[row] = pool.pick(new, out.pattern)
        return picks, swaps


class Worth:
    """What entries of a pool are worth to a selection."""

    def __init__(self, pool: Pool) -> None:
        self.pool = pool
        self.costs = np.array([_DIFFICULTY_COSTS[candidate.difficulty] for candidate in pool.candidates])
        self.coverage, self.repeats = pool.coverage(), _repeats(pool)
        self.failing = np.array([candidate.failing for candidate in pool.candidates])
        self.value = pool.scores + self.coverage + self.failing - self.costs

    def gains(self, picks: Sequence[Pick]) -> NDArray[np.float64]:
        """What a selection gains by each candidate in the place of each pick, shape (picks, candidates).

        Minus infinity for candidates that are in the selection.
        """
        chosen = np.array([self.pool.places[pick.number] for pick in picks])
        patterns = np.array([pick.pattern for pick in picks])
        crowding = self.repeats[:, chosen].sum(axis=1)
        lost = self.value[patterns, chosen] - crowding[chosen]
        won = self.value[patterns] - crowding + self.repeats[chosen]
        won[:, chosen] = -np.inf
        return np.asarray(won - lost[:, None])

    def reason(self, out: Pick, into: int, others: Sequence[Pick]) -> str:
        """Why a candidate, by its place, is better than a pick beside others: what it gains most by."""
        old, pattern = self.pool.places[out.number], out.pattern
        rest = [self.pool.places[pick.number] for pick in others]
        parts = {
            "repeats": self.repeats[old, rest].sum() - self.repeats[into, rest].sum(),
            "coverage": self.coverage[pattern, into] - self.coverage[pattern, old],
            "difficulty": self.costs[old] - self.costs[into],
            "failing": self.failing[into] - self.failing[old],
            "score": self.pool.scores[pattern, into] - self.pool.scores[pattern, old],
        }
        return _reason(self.pool, pattern, old, into, max(parts, key=lambda name: float(parts[name])), rest)


def _repeats(pool: Pool) -> NDArray[np.float64]:
    """What two entries cost beside each other: from 0 where they are different enough to 1 where they are equal."""
    result = np.clip((pool.likeness - _SIMILAR_FROM) / (1.0 - _SIMILAR_FROM), 0.0, 1.0)
    np.fill_diagonal(result, 0.0)
    return np.asarray(result)


def _reason(pool: Pool, pattern: int, out: int, into: int, part: str, others: Sequence[int]) -> str:
    old, new = pool.candidates[out], pool.candidates[into]
    match part:
        case "repeats":
            twin = max(others, key=lambda other: float(pool.likeness[out, other]))
            return f"redundant: {old.name} is {pool.likeness[out, twin]:.2f} like {pool.candidates[twin].name}"
        case "coverage":
            more = sorted(new.aspects[pattern] - old.aspects[pattern])
            return f"coverage: {new.name} also shows {', '.join(more)}"
        case "difficulty":
            return f"{old.difficulty}: what {old.name} came to leaves little to learn"
        case "failing":
            return f"more to learn: {_record(new)}, {_record(old)}"
        case _:
            return f"relevance: {new.name} is closer to the pattern"


def _record(candidate: BankCandidate) -> str:
    if not candidate.runs:
        return f"nobody has run {candidate.name}"
    return f"{candidate.name} failed in {candidate.failures} of {candidate.runs} runs"


def measure(pool: Pool, picks: Sequence[Pick]) -> Measures:
    """Measure a selection; an empty one shows nothing."""
    if not picks:
        return Measures(0.0, 0.0, 0, 0, 0)
    places = np.array([pool.places[pick.number] for pick in picks])
    coverage = pool.coverage()[[pick.pattern for pick in picks], places]
    pairs = pool.likeness[np.ix_(places, places)][np.triu_indices(len(places), 1)]
    difficulties = [pool.candidates[place].difficulty for place in places]
    return Measures(
        coverage=float(coverage.mean()),
        diversity=float(1.0 - pairs.mean()) if len(pairs) else 0.0,
        redundant=int(np.count_nonzero(pairs > _SIMILAR_FROM)),
        too_easy=difficulties.count(_TOO_EASY),
        too_hard=difficulties.count(_TOO_HARD),
    )
