"""How fast and how well a bank finds: latencies and recall against exact search, over many failure patterns."""

import random
import time
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from harness.generated import generate
from roadmend.sera.bank import Bank, chunks
from roadmend.sera.descriptor import Descriptor
from roadmend.sera.filters import Filters
from roadmend.sera.pattern import FailurePattern, Where, Who, Why

_SAME = 1e-6  # scores that differ by less are equal


@dataclass(frozen=True)
class Latencies:
    """Times of single searches on one thread [s], the embedding of the pattern included."""

    wall: NDArray[np.float64]
    processor: NDArray[np.float64]

    def milliseconds(self) -> dict[str, float]:
        """Percentiles of both clocks."""
        result = {}
        for clock, seconds in (("", self.wall), ("cpu_", self.processor)):
            for share in (50, 95, 99):
                result[f"{clock}p{share}_ms"] = round(1e3 * float(np.percentile(seconds, share)), 3)
        return result


def draw_patterns(count: int, seed: int) -> list[FailurePattern]:
    """Failure patterns as an analysis gives them: a hazard and whom it came from, and some of what was around it."""
    generator = random.Random(seed)
    return [draw_pattern(entry.descriptor, generator) for entry in generate(count, seed)]


def draw_pattern(descriptor: Descriptor, generator: random.Random) -> FailurePattern:
    """A pattern that the scenario is an example of; what a collision does not always depend on is left open at times."""

    def sometimes(share: float) -> bool:
        return generator.random() < share

    where = Where(
        road=descriptor.road.kind,
        control=descriptor.road.control if sometimes(0.5) else None,
        density=descriptor.density if sometimes(0.3) else None,
        weather=descriptor.weather if sometimes(0.7) else None,
        light=descriptor.light if sometimes(0.5) else None,
        speed_limit=descriptor.road.speed_limit if sometimes(0.3) else None,
    )
    manoeuvre = descriptor.manoeuvre if sometimes(0.6) else None
    if not descriptor.hazards:
        return FailurePattern("drawn", what="COLLISION", where=where, why=Why(manoeuvre))
    hazard = generator.choice(descriptor.hazards)
    who = Who(hazard.participant if sometimes(0.8) else None, hazard.side if sometimes(0.7) else None)
    return FailurePattern("drawn", what="COLLISION", where=where, who=who, why=Why(manoeuvre, hazard.kind))


def time_searches(
    bank: Bank, patterns: Sequence[FailurePattern], filters: Sequence[Filters | None], count: int
) -> tuple[list[list[int]], Latencies]:
    """Search for each pattern: the numbers that were found, and what each search took."""
    found, wall, processor = [], [], []
    for pattern, each in zip(patterns, filters, strict=True):
        began, worked = time.perf_counter(), time.thread_time()
        hits = bank.search(pattern, count, each)
        processor.append(time.thread_time() - worked)
        wall.append(time.perf_counter() - began)
        found.append([hit.number for hit in hits])
    return found, Latencies(np.array(wall), np.array(processor))


def recalls(
    bank: Bank,
    patterns: Sequence[FailurePattern],
    filters: Sequence[Filters | None],
    found: Sequence[Sequence[int]],
    count: int,
) -> list[float]:
    """For each search, the share of the ``count`` best of an exact search in single precision that it found.

    Many scenarios have equal scores, and which of those come last among the best is a matter of chance. So scores are
    compared, not numbers: what was found counts if it is as good as the last of the exact search. It counts once, however
    often it was given, and not at all where the filter forbids it.
    """
    queries = np.array([bank.embed(pattern) for pattern in patterns])
    masks = {each: bank.allowed(each) for each in set(filters)}
    best = np.full((len(patterns), count), -np.inf, dtype=np.float32)
    reached = [np.full(len(numbers), -np.inf, dtype=np.float32) for numbers in found]
    wanted: dict[int, list[tuple[int, int]]] = {}
    for query, numbers in enumerate(found):
        for place, number in enumerate(dict.fromkeys(numbers)):
            wanted.setdefault(number, []).append((query, place))
    start = 0
    for chunk in chunks(bank.descriptors()):
        scores = queries @ bank.embedder.embed(chunk).T
        for query, each in enumerate(filters):
            mask = masks[each]
            if mask is not None:
                scores[query, ~mask[start : start + len(chunk)]] = -np.inf
        for row in range(len(chunk)):
            for query, place in wanted.get(start + row, ()):
                reached[query][place] = scores[query, row]
        best = -np.partition(-np.hstack([best, scores]), count - 1, axis=1)[:, :count]
        start += len(chunk)
    return [_share(exact[np.isfinite(exact)], scores) for exact, scores in zip(best, reached, strict=True)]


def _share(exact: NDArray[np.float32], reached: NDArray[np.float32]) -> float:
    if not exact.size:
        return 1.0
    return min(1.0, np.count_nonzero(reached >= exact.min() - _SAME) / exact.size)
