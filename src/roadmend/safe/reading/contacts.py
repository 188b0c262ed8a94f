"""Who touched whom, in which order, and with which sides."""

import itertools
from collections.abc import Iterator
from dataclasses import replace

from roadmend.safe.claims import ClaimSource, ContactClaim
from roadmend.safe.dsl import Side
from roadmend.safe.reading.clauses import NOBODY, STRIKES, Actor, Clause
from roadmend.safe.reading.facts import Text
from roadmend.safe.reading.lexicon import word_set
from roadmend.safe.reading.parts import NamedPart
from roadmend.safe.reading.tokens import Words

_MOVES = frozenset({"drift", "travel", "emerge", "change_lane", "turn", "reverse", "depart", "continue"})
_INTO = frozenset({"up", "under", "into", "with", "against", "vs", "versus", "along", "between", "on", "in", "of"})
_AT = frozenset({"up", "under", "in", "on", "at", "to", "into", "along", "against", "with", "of", "by"})
_PUSHED = frozenset({"into", "against", "onto", "on to", "in to"})
_VERSUS = frozenset({"vs", "versus"})
_SURE, _TOLD, _GUESSED = 0.93, 0.55, 0.7


def read_contacts(text: Text) -> tuple[ContactClaim, ...]:
    """The contacts of a text, in their order, each pair once."""
    found: dict[frozenset[int], ContactClaim] = {}
    backing = set[int]()
    for before, clause in itertools.pairwise((None, *text.clauses)):
        if clause is None:
            continue
        if clause.kind == "reverse" and clause.is_real:
            backing.update(clause.subject.vehicles)
        for told in (*_of_clause(clause, text.count), *_ends_met(before, clause)):
            pair = frozenset({told.striking, told.struck})
            backs = told.striking in backing and told.striking_side is Side.FRONT and clause.subject.part is None
            contact = replace(told, striking_side=Side.REAR) if backs else told
            found[pair] = joined(found[pair], contact) if pair in found else contact
    strong = [each for each in found.values() if each.confidence > 0.5] or list(found.values())
    return tuple(replace(each, order=place) for place, each in enumerate(strong))


def _ends_met(one: Clause | None, other: Clause) -> Iterator[ContactClaim]:
    """A contact of two parts side by side: "Passat front / Hilux right door", "my front, his rear"."""
    if one is None or one.sentence is not other.sentence or one.verb or other.verb:
        return
    ends = [(each.subject.vehicles, each.subject.part) for each in (one, other)]
    apart = any(item.low not in word_set("between_ends") for item in (*one.words, *other.words))
    if apart or any(len(vehicles) != 1 or part is None for vehicles, part in ends) or ends[0][0] == ends[1][0]:
        return
    if ends[1][1] is not None and ends[1][1].side is Side.FRONT:
        ends.reverse()  # who strikes does so with the front, as a rule
    (striking, mine), (struck, theirs) = ends
    yield _contact(other, striking[0], struck[0], mine, theirs, _GUESSED)


def joined(one: ContactClaim, other: ContactClaim) -> ContactClaim:
    """Two statements about one contact: the surer says who struck, each fills in what the other leaves open."""
    first, second = (other, one) if other.confidence > one.confidence + 0.1 else (one, other)
    sides = (second.striking_side, second.struck_side)
    mine, theirs = sides if first.striking == second.striking else sides[::-1]
    sure = min(0.97, first.confidence + 0.02)
    return replace(
        first,
        striking_side=first.striking_side or mine,
        struck_side=first.struck_side or theirs,
        confidence=sure,
    )


def _of_clause(clause: Clause, count: int) -> Iterator[ContactClaim]:
    kind, me = clause.kind, clause.subject
    if not clause.is_real:
        return
    if clause.lemma in word_set("pushes") and (pushed := _pushed(clause)):
        yield from pushed
        return
    shoves = clause.lemma in word_set("pushes") and clause.object is not None and not clause.is_passive
    if shoves and clause.object is not None and me.part is not None:
        for other in clause.object.vehicles[:1] if me.vehicles and clause.object.vehicles != me.vehicles else ():
            yield _contact(clause, me.vehicles[0], other, me.part, clause.object.part, _GUESSED)
        return
    if kind not in STRIKES | {"collide"} and not _is_told(clause):
        return
    between = next((actor.vehicles for lead, actor in clause.others if lead.low == "between"), ())
    if len(between) == 2 and not me.vehicles:  # "contact was made between V1 and V2"
        yield _contact(clause, between[0], between[1], None, None, _TOLD)
        return
    if clause.tail.cut(0, 4).says(word_set("own_things")) and not clause.is_passive:
        return  # "hit his head", "slammed on its brakes"
    each_other = clause.object is not None and clause.object.vehicles == me.vehicles
    met = kind == "collide" or (kind in STRIKES and clause.words.has("head_on"))
    if len(me.vehicles) > 1 and (each_other or (met and clause.object is None)):
        yield _contact(clause, me.vehicles[0], me.vehicles[1], me.part, None, 0.8)
        return
    target, mine, theirs = _parts(clause)
    strikers, struck = me.vehicles, target.vehicles if target is not None else ()
    if clause.is_passive:
        strikers, struck, mine, theirs = struck, strikers, theirs, mine
    wielded = [actor for lead, actor in clause.others if lead.low == "with" and actor.part and actor.vehicles]
    if wielded and not clause.is_passive and wielded[0].vehicles != strikers and len(wielded[0].vehicles) == 1:
        strikers, mine = wielded[0].vehicles, wielded[0].part  # "she hit him with the front of the Ford": the Ford did
        struck = struck if struck != strikers else me.vehicles
    sure = _SURE if kind in STRIKES else 0.75 if kind == "collide" else _TOLD
    hints = target is not None or mine or theirs or clause.is_passive
    of_thing = any(lead.low == "of" and actor == replace(NOBODY, span=actor.span) for lead, actor in clause.others)
    named = clause.head if clause.is_passive and not me.vehicles else clause.tail.cut(0, 6)
    walker = target is not None and not target.vehicles and target.is_person
    hits_thing = of_thing or walker or named.has("object", "walker")  # "the edge of the trailer" is no vehicle's
    if count == 2 and kind in STRIKES and hints and not hits_thing and bool(strikers) != bool(struck):
        known, sure = (strikers or struck)[0], _GUESSED  # of two, it was the other one
        strikers, struck = (strikers or (1 - known,)), (struck or (1 - known,))
    for other in (struck if len(strikers) == 1 else struck[:1]) if strikers else ():
        if other != strikers[0]:
            yield _contact(clause, strikers[0], other, mine, theirs, sure)


def _parts(clause: Clause) -> tuple[Actor | None, NamedPart | None, NamedPart | None]:
    """Who else takes part in a contact, the part of the subject, and that of the other."""
    me, target = clause.subject, clause.object
    mine, theirs = me.part, target.part if target is not None else None
    for lead, actor in clause.others:
        is_mine = not actor.vehicles or actor.vehicles == me.vehicles
        is_theirs = target is not None and actor.vehicles == target.vehicles
        # "V1 struck V2 on its left side": the side of the one that was struck
        is_theirs |= target is not None and lead.low in {"on", "in"} and is_mine and clause.kind in STRIKES
        if clause.is_passive and lead.low == "by" and actor.vehicles:
            target, theirs = actor, actor.part or theirs
        elif actor.part is not None and lead.low in {"with", "using"} and is_mine:
            mine, theirs = (mine, actor.part) if clause.is_passive and target is not None else (actor.part, theirs)
        elif actor.part is not None and lead.low in _AT and clause.is_passive and (is_mine or is_theirs):
            mine = actor.part
        elif actor.part is not None and lead.low in _AT and (not actor.vehicles or is_theirs):
            theirs = actor.part
        elif (
            actor.vehicles
            and (lead.low in _INTO or (lead.low == "to" and actor.part and mine))
            and target is None
            and actor.vehicles[0] not in me.vehicles
        ):
            target, theirs = (None, theirs) if clause.is_passive else (actor, actor.part)
    hand = _bare_hand(clause.tail) if clause.kind in STRIKES else None
    if hand is not None and clause.is_passive:
        return target, mine or hand, theirs
    return target, mine, theirs or hand


def _bare_hand(words: Words) -> NamedPart | None:
    """The side of what is struck "on the left"."""
    for place, item in enumerate(words):
        led = words.at(place - 1).low == "the" and words.at(place - 2).low in {"on", "from"}
        ends = words.at(place + 1).low in {"", ",", ";", "and", "by", "as"}
        if item.is_a("hand") and not item.is_a("part") and led and ends:
            return NamedPart(Side(item.get("hand")), None, is_flank=True)
    return None


def _pushed(clause: Clause) -> list[ContactClaim]:
    """One vehicle that is pushed into another, and who pushes it: "V1 shoved V2 into an SUV"."""
    into = next((actor for lead, actor in clause.others if lead.low in _PUSHED and actor.vehicles), None)
    moved = (clause.subject if clause.is_passive or clause.object is None else clause.object).vehicles[:1]
    if into is None or not moved or moved[0] == into.vehicles[0]:
        return []
    side, found = into.part.side if into.part is not None else None, list[ContactClaim]()
    pairs = [(moved[0], into.vehicles[0], Side.FRONT if side is Side.REAR else None, side)]
    if clause.object is not None and not clause.is_passive and clause.subject.vehicles[:1] not in {(), moved}:
        pairs.insert(0, (clause.subject.vehicles[0], moved[0], Side.FRONT, None))
    for striking, struck, mine, theirs in pairs:
        reason = "the one was pushed into the other"
        found.append(ContactClaim(striking, struck, mine, theirs, 0, 0.85, ClaimSource.SUMMARY, reason, clause.span))
    return found


def _is_told(clause: Clause) -> bool:
    """Whether a clause without a verb of contact tells of one: "V1 was in a crash with V2", "V2 front vs V1 side"."""
    leads = {lead.low for lead, actor in clause.others if actor.vehicles}
    into_part = any(
        lead.low in {"into", "in", "up", "under"} and actor.vehicles and actor.part for lead, actor in clause.others
    )
    if any(lead.low in _VERSUS for lead, _ in clause.others) or (clause.kind in _MOVES and leads & {"into", "against"}):
        return True
    told = clause.kind in {"", "own", "do", "avoid"} and clause.words.has("collision", "head_on", "end_on")
    ends_meet = clause.subject.part and any(
        lead.low == "to" and actor.vehicles and actor.part for lead, actor in clause.others
    )
    if ends_meet and clause.kind == "":
        return True  # "V1 front to V2 left side"
    return (told and bool(leads & {"with", "between", "by", "into"})) or (into_part and clause.kind in {"", "travel"})


def _contact(
    clause: Clause, striking: int, struck: int, mine: NamedPart | None, theirs: NamedPart | None, sure: float
) -> ContactClaim:
    one, other = mine.side if mine is not None else None, theirs.side if theirs is not None else None
    kind = clause.kind
    if kind == "strike_rear" or clause.words.says({"from behind", "from the rear"}):
        one, other = one or Side.FRONT, other or Side.REAR
    elif other is Side.REAR and kind != "strike_swipe":
        one = one or Side.FRONT
    elif clause.words.has("head_on"):
        one, other = one or Side.FRONT, other or Side.FRONT
    elif kind == "strike_side" or (other is not None and kind == "strike"):
        one = one or Side.FRONT
    reason = f"the text says that they touched ({clause.lemma or 'told'})"
    return ContactClaim(striking, struck, one, other, 0, sure, ClaimSource.SUMMARY, reason, clause.span)
