"""Which scenarios of a bank to learn from: the best for each failure pattern, and a random draw to compare with."""

import hashlib
from collections.abc import Collection, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any, Literal

import numpy as np

from roadmend.core.bounded_file import read_bytes
from roadmend.core.bounds import TEXT
from roadmend.core.errors import InputError
from roadmend.core.json_text import parse_json
from roadmend.sera.bank import Bank, Hit
from roadmend.sera.filters import Filters
from roadmend.sera.pattern import FailurePattern
from roadmend.sera.reflection import EmbeddedReflector, Measures, Pick, Reflector, Swap, candidates_of, measure
from roadmend.sera.words import described
from roadmend.world.scenario import Scenario

_POOL = 50  # candidates for each place of a selection; hard scenarios are rare in a bank, and reflection must see some


@dataclass(frozen=True, slots=True)
class Recommendation:
    """Selections of one size: the first, what reflection made of it and why, and a random one."""

    initial: tuple[Pick, ...]
    refined: tuple[Pick, ...]
    random: tuple[Pick, ...]
    swaps: tuple[Swap, ...]
    measures: dict[str, Measures]  # of each of the three selections
    missing: int  # places that the bank could not fill


def recommend(
    bank: Bank,
    patterns: Sequence[FailurePattern],
    count: int | Sequence[int],
    filters: Filters | None = None,
    exclude: Collection[str | Scenario] = (),
    seed: int = 0,
    reflector: Reflector | None = None,
) -> Recommendation:
    """Select scenarios for each pattern, none twice; the same bank and arguments give the same.

    Args:
        bank: to choose from.
        patterns: what the policy fails at, at least one; earlier ones choose first.
        count: scenarios for each pattern: one number for all, or one for each (see ``shares``).
        filters: what every scenario must be.
        exclude: what must not come, of the evaluation set: scenarios, under whatever name, or digests.
        seed: of the random selection.
        reflector: makes the refined selection of the first; the embedded one if None.

    Raises:
        InputError: there is no pattern, or one says nothing that the bank knows.
        LanguageError: the reflector asks a language model, and no usable answer came.
    """
    if not patterns:
        raise InputError("patterns", "there is none", "give at least one")
    counts = [count] * len(patterns) if isinstance(count, int) else [*count]
    found = [
        bank.search(pattern, wanted * _POOL, filters, exclude) if wanted else []
        for pattern, wanted in zip(patterns, counts, strict=True)
    ]
    initial = _first_choice(found, counts)
    refined, swaps = (reflector or EmbeddedReflector()).reflect(candidates_of(bank, patterns, found), initial)
    drawn = _draw(bank, patterns, len(initial), filters, exclude, seed)
    everything = candidates_of(bank, patterns, [*found, [Hit(number, 0.0) for number, _ in drawn]])
    random = [everything.pick(number, place) for number, place in drawn]
    selections = {"initial": initial, "refined": refined, "random": random}
    return Recommendation(
        tuple(initial),
        tuple(refined),
        tuple(random),
        tuple(swaps),
        {name: measure(everything, picks) for name, picks in selections.items()},
        sum(counts) - len(initial),
    )


def shares(patterns: Sequence[FailurePattern], total: int) -> list[int]:
    """How many of ``total`` scenarios each pattern gets: one, and more the more episodes show it.

    By the rule of highest averages (D'Hondt), of equals the earlier. Patterns that nothing is left for get none, the
    last ones first.
    """
    counts = [int(place < total) for place in range(len(patterns))]
    for _ in range(total - sum(counts) if patterns else 0):
        averages = [
            max(1, len(pattern.evidence)) / (count + 1) for pattern, count in zip(patterns, counts, strict=True)
        ]
        counts[int(np.argmax(averages))] += 1
    return counts


def _first_choice(found: Sequence[Sequence[Hit]], counts: Sequence[int]) -> list[Pick]:
    taken: set[int] = set()
    picks: list[Pick] = []
    for place, (hits, count) in enumerate(zip(found, counts, strict=True)):
        fresh = [hit for hit in hits if hit.number not in taken][:count]
        taken.update(hit.number for hit in fresh)
        picks += [Pick(hit.number, place, hit.score) for hit in fresh]
    return picks


def _draw(
    bank: Bank,
    patterns: Sequence[FailurePattern],
    count: int,
    filters: Filters | None,
    exclude: Collection[str | Scenario],
    seed: int,
) -> list[tuple[int, int]]:
    """Numbers of entries, each with the pattern that it stands for."""
    allowed = bank.allowed(filters, exclude)
    numbers = np.arange(len(bank)) if allowed is None else np.flatnonzero(allowed)
    drawn = np.random.default_rng(seed).choice(numbers, count, replace=False) if count else numbers[:0]
    return [(int(number), place % len(patterns)) for place, number in enumerate(sorted(drawn))]


def content_of(found: Recommendation, patterns: Sequence[FailurePattern], bank: Bank) -> dict[str, Any]:
    """A recommendation as plain data, which ``read_selection`` takes."""
    stages = {"initial": found.initial, "refined": found.refined, "random": found.random}
    numbers = {pick.number for picks in stages.values() for pick in picks}
    numbers |= {number for swap in found.swaps for number in (swap.out, swap.into)}
    entries = {number: described(bank.entry(number)) for number in sorted(numbers)}
    return {
        **{
            stage: [
                {"pattern": patterns[pick.pattern].name, "score": round(pick.score, 4), **entries[pick.number]}
                for pick in picks
            ]
            for stage, picks in stages.items()
        },
        "swaps": [
            {
                "pattern": patterns[swap.pattern].name,
                "gain": round(swap.gain, 4),
                "reason": swap.reason,
                "out": entries[swap.out]["name"],
                "into": entries[swap.into]["name"],
            }
            for swap in found.swaps
        ],
        "measures": {name: asdict(measures) for name, measures in found.measures.items()},
        "missing": found.missing,
    }


Stage = Literal["initial", "refined", "random"]
_MEND = "give what 'roadmend sera recommend --json' printed"


@dataclass(frozen=True, slots=True)
class Selection:
    """Scenarios of a bank to learn from."""

    digests: tuple[str, ...]  # of the scenarios, each once
    digest: str  # SHA-256 of the file, hexadecimal


def read_selection(path: Path, stage: Stage) -> Selection:
    """Read one stage of a selection.

    Raises:
        InputError: the file is missing or no selection, or has nothing at this stage.
    """
    data = read_bytes(path, TEXT, _MEND)
    try:
        content: Any = parse_json(data, str(path), TEXT, _MEND)
        digests = tuple(dict.fromkeys(str(each["digest"]) for each in content[stage]))
    except (InputError, KeyError, TypeError):
        raise InputError(str(path), f"is no selection with a {stage!r} stage", _MEND) from None
    if not digests:
        raise InputError(
            str(path), f"selects nothing at the {stage!r} stage", "select from a bank that holds something"
        )
    return Selection(digests, hashlib.sha256(data).hexdigest())


def scenarios_of(selection: Selection, bank: Bank) -> list[Scenario]:
    """The scenarios of a selection, out of the bank that it was made from.

    Raises:
        InputError: the bank does not hold one of them, or only its description.
    """
    found = []
    for digest in selection.digests:
        entry = bank.find(digest)
        if entry is None:
            raise InputError(str(bank.path), f"holds no scenario {digest[:12]}", "give the bank that was selected from")
        if entry.scenario is None:
            raise InputError(str(bank.path), f"only describes {entry.name}", "select from a bank of whole scenarios")
        found.append(entry.scenario)
    return found
