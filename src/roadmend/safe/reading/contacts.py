"""Who touched whom, in which order, and with which sides."""

from collections.abc import Iterator
from dataclasses import replace

from roadmend.safe.claims import ClaimSource, ContactClaim
from roadmend.safe.dsl import Side
from roadmend.safe.reading.clauses import STRIKES, Actor, Clause, Part
from roadmend.safe.reading.facts import Text
from roadmend.safe.reading.tokens import Item

_STRUCK_BY = frozenset({"by"})
_INTO = frozenset({"into", "with", "against", "vs", "versus", "along", "between", "on", "in", "of"})
_MOVES = frozenset({"drift", "travel", "emerge", "change_lane", "turn", "reverse", "depart", "continue"})
_PUSHES = frozenset({"push", "shove", "knock", "propel", "throw", "force", "send", "drive", "deflect", "redirect"})


def read_contacts(text: Text) -> tuple[ContactClaim, ...]:
    """The contacts of a text, in their order; each pair once, unless it is said to have touched again."""
    found: list[ContactClaim] = []
    for clause in text.clauses:
        for contact in _of_clause(clause, text.count):
            known = next(
                (
                    place
                    for place, each in enumerate(found)
                    if {each.striking, each.struck} == {contact.striking, contact.struck}
                ),
                None,
            )
            if known is None:
                found.append(contact)
            else:
                found[known] = _joined(found[known], contact)
    strong = [each for each in found if each.confidence > 0.5] or found
    return tuple(replace(each, order=place) for place, each in enumerate(strong))


def _joined(one: ContactClaim, other: ContactClaim) -> ContactClaim:
    """Two statements about one contact: the surer says who struck, each fills in what the other leaves open."""
    first, second = (other, one) if other.confidence > one.confidence + 0.1 else (one, other)
    same = first.striking == second.striking
    return replace(
        first,
        striking_side=first.striking_side or (second.striking_side if same else second.struck_side),
        struck_side=first.struck_side or (second.struck_side if same else second.striking_side),
        confidence=min(0.97, first.confidence + 0.02),
    )


def _of_clause(clause: Clause, count: int) -> Iterator[ContactClaim]:
    words = [*clause.head, *clause.tail]
    kind = clause.kind
    if not clause.is_real and not (clause.governed & {"avoid"} and clause.governed & {"fail"}):
        return
    pushed = _pushed(clause)
    if pushed is not None:
        yield pushed
        return
    if clause.is_denied or (kind not in STRIKES | {"collide"} and not _is_told(clause, words)):
        return
    me, them = clause.subject, clause.object
    if kind == "collide" and me is not None and len(me.vehicles) > 1 and them is None:
        yield _contact(me.vehicles[0], me.vehicles[1], me.part, None, clause, words, 0.8)
        return
    mine, theirs = me.part if me is not None else None, them.part if them is not None else None
    target: Actor | None = them
    for lead, actor in clause.others:
        if clause.is_passive and lead.low in _STRUCK_BY and actor.vehicles:
            target, theirs = actor, actor.part or theirs
        elif (
            actor.part is not None
            and me is not None
            and (lead.low in {"with", "using"})
            and (actor.vehicles == me.vehicles or not actor.vehicles)
        ):
            if clause.is_passive and target is not None:
                theirs = actor.part
            else:
                mine = actor.part
        elif (
            actor.part is not None
            and lead.low in {"in", "on", "at", "to", "into", "along", "against", "with", "of", "by"}
            and (
                not actor.vehicles
                or (target is not None and actor.vehicles == target.vehicles)
                or (clause.is_passive and me is not None and actor.vehicles == me.vehicles)
            )
        ):
            if clause.is_passive:
                mine = actor.part
            else:
                theirs = actor.part
                target = target or (actor if actor.vehicles else None)
        elif (
            actor.vehicles
            and lead.low in _INTO
            and target is None
            and (me is None or actor.vehicles[0] not in me.vehicles)
            and not clause.is_passive
        ):
            target, theirs = actor, actor.part
    confidence = 0.93
    if kind not in STRIKES:
        confidence = 0.75 if kind == "collide" else 0.55
    strikers = me.vehicles if me is not None else ()
    struck = target.vehicles if target is not None else ()
    if clause.is_passive:
        strikers, struck, mine, theirs = struck, strikers, theirs, mine
    hits_thing = any(item.is_a("object", "walker") for item in clause.tail[:6])
    if (
        count == 2
        and not hits_thing
        and (bool(strikers) != bool(struck))
        and (kind in STRIKES and (target is not None or mine or theirs or clause.is_passive))
    ):
        known = (strikers or struck)[0]
        strikers, struck = ((known,), (1 - known,)) if strikers else ((1 - known,), (known,))
        confidence = 0.7
    if not strikers or not struck or strikers[0] == struck[0]:
        return
    for other in struck if len(strikers) == 1 else struck[:1]:
        if other != strikers[0]:
            yield _contact(strikers[0], other, mine, theirs, clause, words, confidence)


def _pushed(clause: Clause) -> ContactClaim | None:
    """One vehicle that is pushed into another: "shoved it into an SUV"."""
    if clause.verb is None or clause.verb.lemma not in _PUSHES or clause.subject is None:
        return None
    into = next((actor for lead, actor in clause.others if lead.low == "into" and actor.vehicles), None)
    moved = clause.object.vehicles if clause.object is not None else clause.subject.vehicles
    if into is None or not moved or moved[0] == into.vehicles[0]:
        return None
    struck_side = into.part.side if into.part is not None else None
    mine = Side.FRONT if struck_side is Side.REAR else None
    return ContactClaim(
        moved[0],
        into.vehicles[0],
        mine,
        struck_side,
        0,
        0.85,
        ClaimSource.SUMMARY,
        "the one was pushed into the other",
        clause.span,
    )


def _is_told(clause: Clause, words: list[Item]) -> bool:
    """Whether a clause without a verb of contact tells of one: "V1 was involved in a crash with V2", "V2 front vs V1 side"."""
    if any(lead.low in {"vs", "versus"} for lead, _ in clause.others):
        return True
    if clause.kind in _MOVES and any(
        lead.low in {"into", "against"} and actor.vehicles for lead, actor in clause.others
    ):
        return True
    crash = any(item.is_a("collision", "head_on", "end_on") for item in words)
    with_whom = any(lead.low in {"with", "between", "by", "into"} and actor.vehicles for lead, actor in clause.others)
    in_back = any(
        lead.low in {"into", "in"} and actor.vehicles and actor.part is not None for lead, actor in clause.others
    )
    return (crash and with_whom and clause.kind in {"", "own", "do", "avoid"}) or (
        in_back and clause.kind in {"", "travel"} and clause.subject is not None
    )


def _contact(
    striking: int,
    struck: int,
    mine: Part | None,
    theirs: Part | None,
    clause: Clause,
    words: list[Item],
    confidence: float,
) -> ContactClaim:
    one, other = mine.side if mine is not None else None, theirs.side if theirs is not None else None
    if clause.kind == "strike_rear" or any(item.low in {"from behind", "from the rear"} for item in words):
        one, other = one or Side.FRONT, other or Side.REAR
    elif other is Side.REAR and clause.kind != "strike_swipe":
        one = one or Side.FRONT
    elif any(item.is_a("head_on") for item in words):
        one, other = one or Side.FRONT, other or Side.FRONT
    elif clause.kind == "strike_side" or (
        other is not None and one is None and clause.kind == "strike" and not clause.is_passive
    ):
        one = one or Side.FRONT
    return ContactClaim(
        striking,
        struck,
        one,
        other,
        0,
        confidence,
        ClaimSource.SUMMARY,
        f"the text says that they touched ({clause.verb.lemma if clause.verb else 'told'})",
        clause.span,
    )
