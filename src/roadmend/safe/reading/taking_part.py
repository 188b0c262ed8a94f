"""Which vehicles of a text took part in its crash, and which only stood by, drove on, or came to help."""

import itertools
import re
from collections.abc import Iterator, Sequence

from roadmend.safe.claims import AnyClaim, Claim, ContactClaim
from roadmend.safe.reading.clauses import STRIKES, Clause
from roadmend.safe.reading.facts import Text, of_vehicle
from roadmend.safe.reading.impacts import STRUCK

_COUNTS = {"single": 1, "one": 1, "1": 1, "two": 2, "2": 2, "three": 3, "3": 3, "four": 4, "4": 4, "five": 5, "5": 5}
_VEHICLES = r"(?:vehicle|veh|car|unit|truck|pickup)s?"
# "single-vehicle run-off-road", "3 car pileup", "three vehicles involved", and "Two veh," at the beginning of a line.
_TOLD = re.compile(
    rf"\b(?P<crash>{'|'.join(_COUNTS)})[- ]{_VEHICLES}\b[- ,]*(?:(?:traffic|rear[- ]?end|head[- ]?on|injury|chain) )?"
    r"(?:crash|accident|event|collision|incident|pdo|rollover|wreck|run|tc|mva|mvc|inj|pile|rear|involved|smash|shunt)"
    rf"|(?:^|[.:\n] ?)(?P<list>{'|'.join(_COUNTS)})[- ]{_VEHICLES}(?=[,.;])",
    re.IGNORECASE,
)
_NO_OTHER = re.compile(
    r"\b(?:no|without any) other (?:veh(?:icle)?s?|cars?|drivers?|part(?:y|ies)|motorists?|traffic)\b", re.IGNORECASE
)
_NOTHING = frozenset({"nothing", "nobody", "anything", "anybody", "anyone"})


def taking_part(text: Text, claims: Sequence[AnyClaim], contacts: Sequence[ContactClaim]) -> tuple[int, ...]:
    """Places in the cast of those that took part: those with a number, and those that touched another."""
    touched = {place for each in contacts for place in (each.striking, each.struck)} - {*_told_again(text, contacts)}
    vehicles = text.spoken.roll.vehicles
    numbered = {vehicle.place for vehicle in vehicles if vehicle.description.number is not None}
    away = {place for clause in text.clauses for place in _outside(clause)} - touched
    away |= {place for clause in text.clauses for place in _missed(clause)} - touched - numbered
    if _is_watched(text) and len(vehicles) > 2 and not touched & {*text.spoken.roll.own()}:
        away |= {*text.spoken.roll.own()}
    likely = [each for each in vehicles if each.place not in away] or vehicles
    keep = numbered if len(numbered) > 1 else numbered | touched
    if not keep:
        alone_hit = {each.place for each in likely if _hit_something(each.place, claims)}
        keep = alone_hit or {each.place for each in likely[:2]}
    count = _told(text.summary, len(touched))
    if count == 1 and len(numbered) == 1:
        keep = numbered
    elif count == 1:
        keep = {min(likely, key=lambda each: (not each.description.names, not each.description.bodies)).place}
    elif count > len(keep):
        more = sorted(likely, key=lambda each: (each.place not in keep, -len(each.words), each.place))
        keep = {each.place for each in more[:count]}
    return tuple(sorted(keep - away or keep)) or (0,)


def _told(summary: str, touched: int) -> int:
    """How many vehicles the text says took part; 0 where it does not say that."""
    found = _TOLD.search(summary)
    if found is not None:
        return _COUNTS[(found["crash"] or found["list"]).lower()]
    return int(touched < 2 and _NO_OTHER.search(summary) is not None)


def _outside(clause: Clause) -> tuple[int, ...]:
    """Of which vehicle a clause says that it had no part in the crash."""
    who, touches = clause.subject.vehicles, clause.kind in STRIKES | {"collide"}
    is_named = len(who) == 1 and clause.subject.span.start >= clause.sentence.span.start
    nothing = touches and clause.tail.cut(0, 4).says(_NOTHING)  # "made contact with nothing"
    return who if is_named and (nothing or clause.words.has("outside")) else ()


def _missed(clause: Clause) -> tuple[int, ...]:
    """Which vehicles a clause says were, or did, all but strike another."""
    if clause.kind == "avoid" and clause.is_passive:
        return tuple(place for lead, actor in clause.others if lead.low == "by" for place in actor.vehicles)
    denied = clause.is_denied and clause.kind in STRIKES | {"collide"} and not clause.is_passive
    missed = clause.kind == "avoid" or denied
    return clause.object.vehicles if missed and clause.object is not None else ()


def _is_watched(text: Text) -> bool:
    """Whether the writer only saw it: "it happened right ahead of me"."""
    return any(
        each.items.says({"happened", "witnessed"})
        and each.items.says({"me", "us"})
        and each.items.has("ahead", "behind")
        for each in text.sentences
    )


def _hit_something(place: int, claims: Sequence[AnyClaim]) -> bool:
    """Whether a text says that a vehicle struck something that is no vehicle."""
    path = of_vehicle(place, STRUCK)
    return any(isinstance(each, Claim) and each.path == path for each in claims)


def _told_again(text: Text, contacts: Sequence[ContactClaim]) -> Iterator[int]:
    """Vehicles of the first lines of a news story that its later lines tell again: of one body, in one contact."""
    bodies = [vehicle.description.body()[0] for vehicle in text.spoken.roll.vehicles]
    for first, again in itertools.combinations(contacts, 2):
        same = first.struck == again.struck and first.striking < again.striking
        if same and bodies[first.striking] is bodies[again.striking] is not None:
            described = text.spoken.roll.vehicles[again.striking].description
            if not described.is_other and described.number is None:
                yield first.striking
