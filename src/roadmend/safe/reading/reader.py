"""The embedded reader: one summary in, a scenario out, with what every field rests on.

Text, sentences, clauses, claims, and one scene that satisfies them: see ``tokens``, ``mentions``, ``parsing``, the modules
that make claims (``ways``, ``manoeuvres``, ``contacts``, ``roads``, ``lanes``, ``limits``, ``surroundings``), and ``scene``.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

from roadmend.safe.claims import AnyClaim, CastMember, Claim, ContactClaim
from roadmend.safe.reading.assembly import ReportReading, put_together
from roadmend.safe.reading.cast import MentionedVehicle
from roadmend.safe.reading.clauses import STRIKES
from roadmend.safe.reading.contacts import read_contacts
from roadmend.safe.reading.coupling import couple, let_speak
from roadmend.safe.reading.facts import Text, claim, of_vehicle
from roadmend.safe.reading.groups import groups_of
from roadmend.safe.reading.impacts import read_impacts
from roadmend.safe.reading.lanes import read_lanes
from roadmend.safe.reading.lexicon import word_set
from roadmend.safe.reading.limits import PostedLimit, claim_limits, read_limits
from roadmend.safe.reading.manoeuvres import read_manoeuvres
from roadmend.safe.reading.mentions import Spoken, find_vehicles
from roadmend.safe.reading.naming import mentions_of, names_in
from roadmend.safe.reading.parsing import read_clauses
from roadmend.safe.reading.ramps import read_ramps
from roadmend.safe.reading.referents import Ranking
from roadmend.safe.reading.relations import read_relations
from roadmend.safe.reading.roads import read_roads
from roadmend.safe.reading.scene import fit
from roadmend.safe.reading.structure import Structure
from roadmend.safe.reading.surroundings import read_surroundings
from roadmend.safe.reading.syntax import parse
from roadmend.safe.reading.taking_part import taking_part
from roadmend.safe.reading.tokens import Sentence, read_sentences
from roadmend.safe.reading.transcripts import join_answers
from roadmend.safe.reading.ways import read_ways

_NEAR_TIE = 2.0  # [nats] by which a second choice may be behind the first to be tried
_MOST_TRIED = 8  # pronouns
_TOUCHED = 1.0  # [nats] for each vehicle that touched another, for a crash is told
_CLEARLY = 0.7  # [nats] by which it has to make the better scene

_Claims = tuple[tuple[AnyClaim, ...], tuple[ContactClaim, ...], tuple[PostedLimit, ...]]


@dataclass(frozen=True, slots=True)
class SummaryClaims:
    """What a summary says.

    Attributes:
        text: taken apart.
        cast: its vehicles.
        claims: all that it says of them and their road.
        limits: posted ones.
        kept: places in the cast of the vehicles that took part.
        others: who else was struck: "pedestrian", "animal".
    """

    text: Text
    cast: tuple[CastMember, ...]
    claims: tuple[AnyClaim, ...]
    limits: tuple[PostedLimit, ...]
    kept: tuple[int, ...]
    others: tuple[str, ...]


def read_summary(summary: str, more: Sequence[AnyClaim] = ()) -> ReportReading | None:
    """Read a summary; None where it speaks of no vehicle.

    Args:
        summary: the text.
        more: claims of another source, the sketch, about the same cast (see :func:`read_claims`).
    """
    said = read_claims(summary)
    return None if said is None else assemble(said, more)


def read_claims(summary: str) -> SummaryClaims | None:
    """What a summary says, before anything is decided; None where it speaks of no vehicle."""
    told = [sentence for sentence in read_sentences(summary) if not _is_code(sentence, summary)]
    sentences = tuple(replace(sentence, index=index) for index, sentence in enumerate(join_answers(told, summary)))
    structures, spoken = _taken_apart(sentences)
    if not spoken.roll.vehicles:
        return None
    text, claims, contacts, limits = _best(summary, sentences, structures, spoken)
    cast = tuple(_member(vehicle) for vehicle in spoken.roll.vehicles)
    return SummaryClaims(text, cast, claims, limits, taking_part(text, claims, contacts), _others(text))


def _best(
    summary: str, sentences: Sequence[Sentence], structures: Sequence[Structure], spoken: Spoken
) -> tuple[Text, tuple[AnyClaim, ...], tuple[ContactClaim, ...], tuple[PostedLimit, ...]]:
    """The reading of all pronouns that makes the best scene: the likeliest of each, unless another fits clearly better."""

    def read(picks: Mapping[int, int]) -> tuple[float, list[Ranking], Text, _Claims]:
        clauses, rankings = read_clauses(structures, spoken, picks)
        text = Text(summary, tuple(sentences), spoken, clauses)
        found = _claims(text)
        doubt = sum(
            rankings[at][min(pick, len(rankings[at]) - 1)][1] for at, pick in picks.items() if at < len(rankings)
        )
        touched = {place for each in found[1] for place in (each.striking, each.struck)}
        return fit(found[0], text.count) + _TOUCHED * len(touched) - doubt, rankings, text, found

    picks: dict[int, int] = {}
    best = read(picks)
    open_ = [at for at, ranking in enumerate(best[1]) if len(ranking) > 1 and ranking[1][1] < _NEAR_TIE]
    for at in open_[:_MOST_TRIED]:
        other = read(picks | {at: 1})
        if other[0] > best[0] + _CLEARLY:
            best, picks = other, picks | {at: 1}
    _, _, text, (claims, contacts, limits) = best
    return text, claims, contacts, limits


def _claims(text: Text) -> _Claims:
    """All claims of a text, its contacts, and the limits that it names."""
    contacts, limits = read_contacts(text), read_limits(text)
    relations = tuple(read_relations(text))
    claims: list[AnyClaim] = [
        *_models(text),
        *read_ways(text),
        *relations,
        *read_manoeuvres(text),
        *contacts,
        *read_roads(text),
    ]
    claims += [
        *read_ramps(text, contacts, relations),
        *read_lanes(text),
        *claim_limits(text, limits),
        *read_surroundings(text),
        *read_impacts(text),
    ]
    return tuple(claims), contacts, limits


def _taken_apart(sentences: Sequence[Sentence]) -> tuple[list[Structure], Spoken]:
    """The structure of each sentence, and the vehicles of the text."""
    known = names_in(sentence.items for sentence in sentences)
    found = [list(mentions_of(sentence.items, known)) for sentence in sentences]
    let_speak(sentences, found)
    for sentence, row in zip(sentences, found, strict=True):
        couple(sentence.items, row)
    groups = [groups_of(sentence.items, row) for sentence, row in zip(sentences, found, strict=True)]
    rows = zip(sentences, groups, parse(sentences, groups), strict=True)
    structures = [Structure(*each) for each in rows]
    return structures, find_vehicles(structures, found)


def assemble(said: SummaryClaims, more: Sequence[AnyClaim] = (), *, solver: bool = True) -> ReportReading:
    """Find the scene that satisfies all claims.

    Args:
        said: by the summary.
        more: claims of another source about the same cast.
        solver: let fields decide about each other.
    """
    return put_together(
        [*said.claims, *more], said.limits, said.text.sentences, said.kept, len(said.cast), solver=solver
    )


def _is_code(sentence: Sentence, summary: str) -> bool:
    """Whether it is one of the codes with which NMVCCS closes, which speak of vehicles in general."""
    low = summary[sentence.span.start : sentence.span.end].lower()
    return any(code in low for code in word_set("codes"))


def _member(vehicle: MentionedVehicle) -> CastMember:
    number = vehicle.description.number
    called = {f"vehicle {number}", f"v{number}"} if number is not None else set()
    names = sorted({*filter(None, vehicle.words), *called}, key=lambda name: (-len(name), name))
    return CastMember(number or vehicle.place + 1, tuple(names), vehicle.description.body()[0])


def _models(text: Text) -> Iterator[Claim]:
    for vehicle in text.spoken.roll.vehicles:
        body, confidence, span = vehicle.description.body()
        if body is not None:
            reason = f"it is called {vehicle.description.words}"
            yield claim(of_vehicle(vehicle.place, "model"), body, confidence, reason, span)


def _others(text: Text) -> tuple[str, ...]:
    """Who was struck and is no vehicle."""
    strikes = [clause for clause in text.clauses if clause.is_real and clause.kind in STRIKES | {"collide"}]
    words = [item for clause in strikes for item in (*clause.head, *clause.tail[:5])]
    return tuple(sorted({item.get("walker") for item in words if item.is_a("walker")}))
