"""Who is meant: of the vehicles of a text, the one that a pronoun or "the driver" most likely stands for, and the next best.

Each vehicle gets a weight from what speaks for it here: how lately it was spoken of, whether it was the subject before,
what is known of who drives it. The solver may prefer a reader's second choice where the first makes no scene.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from enum import StrEnum

from roadmend.safe.reading.clauses import NOBODY, STRIKES, Actor
from roadmend.safe.reading.naming import Mention, MentionKind
from roadmend.safe.reading.tokens import Words

# The vehicles that a mention may mean, the likeliest first, with how far each is behind it [nats].
Ranking = tuple[tuple[int, float], ...]

_PLURAL = frozenset({"were", "are", "both", "had both"})
_DOUBT = 3.0  # [nats] how far behind the best a vehicle may be to be looked at by the solver
_CLOSE = 1.0  # [nats] how near the best another may be for "the guy with the sign" to tell nobody's gender
_WEIGHTS = {  # [nats]
    "rank": -0.7,  # for each vehicle that was spoken of since
    "unheard": -1.6,  # not spoken of so far
    "focus": 1.4,  # subject of the clause before, for a subject
    "self": -3.5,  # subject of this clause, for another part of it
    "self_owner": 1.6,  # subject of this clause, for "its" and "his"
    "gender": 2.5,
    "other_gender": -4.0,
    "own": -3.5,  # the writer's own, for "he"
    "own_it": -0.7,
    "thing": 0.9,  # the last one spoken of that was no person, for "it"
}


class Role(StrEnum):
    """The part that a noun group has in its clause."""

    SUBJECT = "subject"
    OBJECT = "object"
    OTHER = "other"
    TOOL = "tool"  # what "with" brings in


@dataclass(slots=True)
class Referents:
    """Remembers who was spoken of, and tells who is meant next.

    Attributes:
        count: of vehicles.
        own: the writer's, if there is one.
        speaks: whether the writer says "I".
        people: vehicles by the names of who drives them.
        picks: by number of an open mention: which of its ranked vehicles to take, where it is not the first.
        rankings: of each open mention so far.
    """

    count: int
    own: tuple[int, ...]
    speaks: bool
    people: Mapping[str, int]
    picks: Mapping[int, int] = field(default_factory=dict)
    rankings: list[Ranking] = field(default_factory=list)
    focus: Actor = NOBODY  # the last subject
    thing: tuple[int, ...] = ()  # the last one spoken of that is no person
    recent: list[int] = field(default_factory=list)
    walks: bool = False  # whether somebody on foot or on a cycle was spoken of since the last driver
    is_road: bool = False  # whether the last thing that did something was a road
    genders: dict[int, str] = field(default_factory=dict)

    def __post_init__(self) -> None:
        if self.own and self.speaks:
            self.focus = replace(NOBODY, vehicles=self.own, is_person=True)

    def resolve(self, mention: Mention, items: Words, role: Role, subject: Actor = NOBODY, kind: str = "") -> Actor:
        """Which vehicles a mention means.

        Args:
            mention: of the sentence.
            items: its words.
            role: in its clause.
            subject: of the clause, where the mention is another part of it.
            kind: of the clause's verb.
        """
        word = items.cut(mention.first, mention.last + 1).first("gender")
        gender = word.get("gender") if word is not None else ""
        before = len(self.rankings)
        vehicles = mention.vehicles or self._meant(mention, items, role, subject, kind, gender)
        is_sure = len(self.rankings) == before or all(doubt > _CLOSE for _, doubt in self.rankings[-1][1:])
        if len(vehicles) == 1 and gender and is_sure:
            self.genders.setdefault(vehicles[0], gender)
        actor = Actor(vehicles, None, mention.is_person, mention.span, gender)
        if vehicles and mention.is_person:
            self.walks = False
        if vehicles:
            self.thing = self.thing if mention.is_person else vehicles[:1]
            self.recent += vehicles
        return actor

    def _meant(
        self, mention: Mention, items: Words, role: Role, subject: Actor, kind: str, gender: str
    ) -> tuple[int, ...]:
        first = items[mention.first]
        after = items.at(mention.last + 1)
        if mention.kind is MentionKind.IT and mention.last > mention.first and after.is_a("ahead", "behind"):
            return ()  # "the vehicle in front of him"
        if mention.kind is MentionKind.BOTH and first.is_a("number") and self.recent:
            return ()  # "waited for two vehicles to pass"
        if mention.kind is MentionKind.BOTH or (
            first.low == "they" and (kind == "collide" or items.at(mention.last + 1).low in _PLURAL)
        ):
            return self._both()
        if self.walks and mention.kind is MentionKind.ONE and role is Role.OBJECT:
            return ()  # the cyclist, the pedestrian
        if mention.kind is MentionKind.OTHER:
            before = subject.vehicles or self.focus.vehicles or tuple(self.recent[-1:])
            rest = [each for each in range(self.count) if each not in before]
            return (rest[0],) if len(rest) == 1 or (rest and self.count > 2) else ()
        if first.get("pronoun") in {"former", "latter"}:
            last = list(dict.fromkeys(reversed(self.recent)))
            at = 0 if first.get("pronoun") == "latter" else 1
            return (last[at],) if at < len(last) else ()
        if mention.kind in {MentionKind.SELF, MentionKind.NAMED} or (
            mention.kind is MentionKind.PERSON and mention.is_new
        ):
            return ()
        return self._likeliest(mention, role, subject, kind, gender)

    def _both(self) -> tuple[int, ...]:
        if self.count <= 2:
            return tuple(range(self.count))
        mine = {*self.own} if self.speaks else set[int]()
        ranked = dict.fromkeys([*reversed(self.recent), *range(self.count)])
        last = sorted(ranked, key=lambda each: each in mine)
        return tuple(sorted(last[:2]))

    def _likeliest(self, mention: Mention, role: Role, subject: Actor, kind: str, gender: str) -> tuple[int, ...]:
        if not self.count:
            return ()
        last = list(dict.fromkeys(reversed(self.recent)))
        weights = {
            vehicle: self._weight(vehicle, last, mention, role, subject, kind, gender) for vehicle in range(self.count)
        }
        ranked = sorted(weights, key=lambda each: -weights[each])
        close = tuple((each, weights[ranked[0]] - weights[each]) for each in ranked)
        close = tuple(each for each in close if each[1] < _DOUBT)
        self.rankings.append(close)
        pick = self.picks.get(len(self.rankings) - 1, 0)
        return (close[min(pick, len(close) - 1)][0],)

    def _weight(
        self, vehicle: int, last: Sequence[int], mention: Mention, role: Role, subject: Actor, kind: str, gender: str
    ) -> float:
        told = [_WEIGHTS["rank"] * last.index(vehicle) if vehicle in last else _WEIGHTS["unheard"]]
        is_owner = mention.kind is MentionKind.POSSESSIVE
        if role is Role.SUBJECT or not subject.vehicles:
            told += [_WEIGHTS["focus"]] * (vehicle in self.focus.vehicles)
        elif is_owner and (kind not in STRIKES or role is Role.TOOL):
            told += [_WEIGHTS["self_owner"]] * (vehicle in subject.vehicles)
        elif not is_owner or kind in STRIKES:
            told += [_WEIGHTS["self"]] * (vehicle in subject.vehicles)
        if gender and vehicle in self.genders:
            told.append(_WEIGHTS["gender" if self.genders[vehicle] == gender else "other_gender"])
        if self.speaks and (vehicle,) == self.own:
            told.append(_WEIGHTS["own" if mention.is_person else "own_it"])
        if not mention.is_person:
            told += [_WEIGHTS["thing"]] * (vehicle in self.thing)
        return math.fsum(told)
