"""Who comes from a ramp, and who is on the road that it leads to."""

from collections.abc import Iterator, Mapping, Sequence

from roadmend.safe.claims import Claim, ContactClaim, DirectionClaim, WayRelation
from roadmend.safe.dsl import RoadType, Side
from roadmend.safe.reading.clauses import STRIKES, Clause
from roadmend.safe.reading.facts import Text, claim, crash_places, of_vehicle
from roadmend.safe.reading.lexicon import word_set
from roadmend.safe.reading.tokens import Item, Words

_NEAR = 5  # words
_ON_ROAD = frozenset({"", "travel", "continue", "stop", "follow"})
_JOINING = _ON_ROAD | {"approach", "emerge", "turn", "change_lane", "intend", "drift", "begin", "do", "depart", "slow"}
_LIKELY = 0.5
_TIED = 0.7  # confidence that two who wait one behind the other are on one ramp

_Ramps = dict[int, tuple[float, Item]]  # by vehicle: how surely it comes from a ramp, and the word for it


def read_ramps(text: Text, contacts: Sequence[ContactClaim], relations: Sequence[DirectionClaim]) -> Iterator[Claim]:
    """The claims of a text about who comes from a ramp, and that roads merge."""
    words = Words(item for sentence in text.sentences for item in sentence.items)
    ramps, merges = _told(text, words)
    merges |= _enters(text, words, ramps)
    on_main = {vehicle: item for clause in text.clauses for vehicle, item in _on_main(clause) if vehicle not in ramps}
    _queue(text, ramps, on_main, _pairs(contacts, relations))
    ramp = words.first("ramp")
    others = {*range(text.count)} - on_main.keys()
    if merges and not ramps and ramp is not None and on_main and len(others) == 1:
        ramps[others.pop()] = (_TIED, ramp)  # there is a ramp, and the other vehicle is not on it
    for vehicle, item in on_main.items():
        yield claim(
            of_vehicle(vehicle, "on_ramp"), value=False, confidence=0.75, reason="it is on the main road", where=item
        )
    for vehicle, (sure, ramp) in ramps.items():
        path = of_vehicle(vehicle, "on_ramp")
        yield claim(path, value=True, confidence=sure, reason="it comes from a ramp", where=ramp)
        if sure > _LIKELY:
            kind_sure = min(0.97, sure + 0.1) if merges else sure - 0.1
            yield claim("road_type", RoadType.MERGING, kind_sure, "a vehicle joins from a ramp", ramp)


def _told(text: Text, words: Words) -> tuple[_Ramps, bool]:
    """What each clause says of ramps, and whether somebody joins the traffic of another road at all."""
    ramps: _Ramps = {}
    has_off = any(item.get("ramp") == "off" for item in words)
    merges = any(item.get("ramp") == "on" for item in words)
    merges |= any(item.get("road") == "divided" for item in words) and not has_off
    joins = any(item.verb is not None and item.verb.lemma in word_set("merges") for item in words)
    for clause in text.clauses:
        ramp, vehicles = clause.words.first("ramp"), clause.subject.vehicles[:1] or _writer(clause, text)
        is_merge = clause.kind == "change_lane" and clause.lemma in word_set("merges")
        merges |= is_merge or (any(item.get("ramp") == "on" for item in clause.tail) and bool(vehicles))
        freeway = next((item for item in clause.tail.cut(1, 5) if item.get("road") == "divided"), None)
        onto = freeway is not None and clause.tail.at(0).low in word_set("turn_targets") - {"down", "to"}
        place = freeway if onto else words.first("ramp")  # there is no other way onto a freeway
        if ramp is None and is_merge and vehicles and place is not None:
            ramps.setdefault(vehicles[0], (0.7, place))
        merges |= clause.kind == "depart" and clause.lemma in {"come", "leave"} and ramp is not None
        if ramp is None or not vehicles or (has_off and not joins):
            continue
        is_off = ramp.get("ramp") == "off" and not (joins and clause.lemma in {"come", "get"})
        is_joining = clause.kind in _JOINING or (clause.kind == "see" and ramp in clause.head)
        sure = _from_ramp(clause, ramp) if is_joining and not is_off else 0.0
        if sure:
            merges |= clause.words.cut(clause.words.index(ramp) - _NEAR, clause.words.index(ramp)).says({"off", "down"})
            ramps[vehicles[0]] = max(ramps.get(vehicles[0], (0.0, ramp)), (sure, ramp), key=lambda each: each[0])
    return ramps, merges


def _writer(clause: Clause, text: Text) -> tuple[int, ...]:
    """The writer's own vehicle, where a clause that names no vehicle, or has no subject, is of what "I" did or saw."""
    is_own = any(item.get("pronoun") in {"self", "own"} for item in clause.sentence.items)
    is_merge = clause.kind == "change_lane" and clause.lemma in word_set("merges") and clause.sentence.index == 0
    return text.spoken.roll.own() if is_own or is_merge else ()


def _from_ramp(clause: Clause, ramp: Item) -> float:
    """How surely a clause with a word for a ramp has its subject come from it; it may only pass it, or go there."""
    place = clause.words.index(ramp)
    led = {each.low for each in clause.words.cut(place - _NEAR, place)}
    if led & word_set("near_ramp") or ("by" in led and "lane" in led):
        return 0.0
    led |= {"on"} if clause.lemma == "be" and clause.kind == "travel" and place <= _NEAR else set()
    enters = bool(led & word_set("ramp_entered")) and not led & {"from", "on", "along", "of"}
    uses = bool(led & word_set("ramp_used")) or (not enters and "lane" in led)
    uses |= "of" in led and bool(led & {"end", "top", "foot", "tip", "bottom"})
    enters |= clause.kind == "approach" and not uses
    return 0.35 if enters else 0.9 if ramp.get("ramp") == "on" else 0.75


def _enters(text: Text, words: Words, ramps: _Ramps) -> bool:
    """Whether somebody is said to enter a road where there is a ramp; who does so comes from it."""
    near, found = words.first("ramp"), False
    if near is None or near.get("ramp") == "off":
        return False
    for clause in text.clauses:
        tail = clause.tail
        onto = not tail.cut(0, 1).has("junction") and (tail.cut(0, 3).has("road") or tail.at(0).low in {"", ","})
        if clause.lemma == "enter" and onto and clause.subject.vehicles:
            ramps.setdefault(clause.subject.vehicles[0], (0.72, near))
            found = True
    return found


def _on_main(clause: Clause) -> Iterator[tuple[int, Item]]:
    """Who is said to travel on the road that a ramp leads to."""
    words = clause.words
    if clause.kind not in _ON_ROAD | STRIKES or not clause.is_real or words.has("ramp") or not clause.subject.vehicles:
        return
    for place, item in enumerate(words):
        if item.low == "already" and words.at(place + 1).low in {"on", "in", "travelling", "traveling"}:
            yield clause.subject.vehicles[0], item
        main = item.get("road") == "divided" or item.low.startswith("main ") or words.at(place - 1).low == "main"
        before = words.cut(place - 7, place)
        if (
            main
            and item.is_a("road")
            and before.says({"on", "along", "down", "in"})
            and not before.says({"onto", "to"})
        ):
            yield clause.subject.vehicles[0], item


def _pairs(contacts: Sequence[ContactClaim], relations: Sequence[DirectionClaim]) -> list[tuple[int, int]]:
    """Vehicles of which one is behind the other."""
    rear = [(each.striking, each.struck) for each in contacts if each.struck_side is Side.REAR]
    return rear + [(each.first, each.second) for each in relations if each.relation is WayRelation.SAME]


def _queue(text: Text, ramps: _Ramps, on_main: Mapping[int, Item], pairs: Sequence[tuple[int, int]]) -> None:
    """Who is behind one that waits on a ramp is on it, too, and so is who waits ahead of one that comes along it."""
    afterwards, halted = crash_places(text.clauses), set[int]()
    for place, clause in enumerate(text.clauses):
        if clause.kind in {"stop", "slow"} and not (clause.is_passive or afterwards[place]):
            halted.update(clause.subject.vehicles)
    for pair in (each for each in pairs if halted & {*each}):
        for one, other in (pair, pair[::-1]):
            if one in ramps and ramps[one][0] > _LIKELY and other not in ramps and other not in on_main:
                ramps[other] = (_TIED, ramps[one][1])
