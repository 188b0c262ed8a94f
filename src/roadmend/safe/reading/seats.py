"""Who sits in which vehicle, where a text leaves it to its reader: the writer's own, hers, and that of "a driver"."""

import itertools
import math
from collections.abc import Sequence
from dataclasses import replace

from roadmend.safe.reading.cast import Description, MentionedVehicle, VehicleRoll
from roadmend.safe.reading.clauses import STRIKES
from roadmend.safe.reading.lexicon import word_set
from roadmend.safe.reading.naming import Mention, MentionKind
from roadmend.safe.reading.tokens import Sentence, Words

_DRIVES = frozenset(
    {"travel", "turn", "stop", "slow", "emerge", "approach", "continue", "overtake", "follow", "change_lane"}
)
_APPOSITION = 6  # words at most between two names of one vehicle
_WITH = 5  # words between a person and the vehicle that she or he is "with"
_REACH = 6  # words between "I" and the car that I sit in
_SEAT = 8  # words between a numbered driver and the car that she or he sits in


def let_speak(sentences: Sequence[Sentence], found: Sequence[Sequence[Mention]]) -> dict[int, Mention]:
    """Who speaks as "I", by the mention's id, where drivers tell one after the other: "Driver A: I was in my Polo"."""
    speaker: Mention | None = None
    told: dict[int, Mention] = {}
    for sentence, row in zip(sentences, found, strict=True):
        first = row[0] if row else None
        is_label = first is not None and first.number is not None and first.is_person and first.first == 0
        if first is not None and is_label and sentence.items.at(first.last + 1).low == ":":
            speaker = first
        for mention in row if speaker is not None else ():
            if mention.kind is MentionKind.SELF and speaker is not None:
                told[id(mention)] = speaker
            elif mention.description is not None and mention.description.is_own and speaker is not None:
                mention.description = replace(mention.description, is_own=False, number=speaker.number)
    return told


def claim_own(items: Words, row: Sequence[Mention]) -> None:
    """Take the vehicle that the writer says to sit in for the writer's: "I was in the Civic"."""
    for one, other in itertools.pairwise(row):
        between = items.cut(one.last + 1, other.first)
        sits = 0 < len(between) < _REACH and between[-1].low in word_set("sits_in")
        sits |= (
            1 < len(between) < _REACH and between[-1].get("auxiliary") == "be" and between.has("thing")
        )  # "my vehicle is"
        sits |= len(between) == 1 and between[0].get("auxiliary") == "be"  # "I was the second car"
        bracketed = len(between) > 1 and between[-1].low == "(" and between[-2].is_a("part", "flank")
        sits |= bracketed  # "my rear door (05 Accord)"
        if sits and one.kind is MentionKind.SELF and other.description is not None and not other.number:
            other.description = replace(other.description, is_own=True)
    for place, mention in enumerate(row):  # "insured states he was operating his Buick"
        if items[mention.first].is_a("insured") and mention.kind is MentionKind.SELF:
            plain = (MentionKind.ONE, MentionKind.POSSESSIVE, MentionKind.PERSON)
            other = next((each for each in row[place + 1 :] if each.kind not in plain), mention)
            led = items.at(other.first - 1).low in word_set("sits_in") - {"'s"}
            described = other.description
            if described is not None and not other.number and (led or described.is_theirs):
                other.description = replace(described, is_own=True)


def seat_writer(sentences: Sequence[Sentence], found: Sequence[Sequence[Mention]], roll: VehicleRoll) -> None:
    """Take the vehicle that somebody sits in for the writer's, where one speaks of "me" and of no car of mine."""
    if roll.own() or not any(item.get("pronoun") in {"self", "own"} for each in sentences for item in each.items):
        return
    for sentence, row in zip(sentences, found, strict=True):
        for mention in row:
            led = sentence.items.at(mention.first - 1).low in {"in", "driving"}
            led &= not sentence.items.at(mention.first - 3).is_a("determiner")  # "the musicians in the minibus"
            seated = any(each.last < mention.first and each.kind is not MentionKind.SELF for each in row)
            if led and not seated and mention.description and mention.vehicles and not mention.is_new:
                vehicle = roll.vehicles[mention.vehicles[0]]
                vehicle.description = replace(vehicle.description, is_own=True)
                return
    hitters = {
        vehicle for sentence, row in zip(sentences, found, strict=True) for vehicle in _hits_writer(sentence.items, row)
    }
    if len(roll.vehicles) == 2 and len(hitters) == 1 and not roll.vehicles[0].description.number:
        vehicle = roll.vehicles[1 - hitters.pop()]
        vehicle.description = replace(vehicle.description, is_own=True)


def _hits_writer(items: Words, row: Sequence[Mention]) -> tuple[int, ...]:
    """Who strikes or faces "me" in a sentence: "an F-150 facing me ... T-boned me"."""
    for place, mention in enumerate(row):
        verb = items.at(mention.first - 1).verb
        if mention.kind is MentionKind.SELF and verb is not None and (verb.kind in STRIKES or verb.lemma == "face"):
            named = [each for each in row[:place] if each.description is not None and len(each.vehicles) == 1]
            return named[-1].vehicles if named else ()
    return ()


def add_writer(sentences: Sequence[Sentence], found: Sequence[Sequence[Mention]], roll: VehicleRoll) -> None:
    """Give the writer a vehicle where the text tells that the writer drove, and of no vehicle of the writer's."""
    if roll.own() or len(roll.vehicles) != 1 or roll.vehicles[0].description.number is not None:
        return
    drives = any(
        mention.kind is MentionKind.SELF and (_drives(sentence.items, mention) or _is_struck(sentence.items, mention))
        for sentence, row in zip(sentences, found, strict=True)
        for mention in row
    )
    if not drives:
        return
    others = (each.description for row in found for each in row if each.description and each.vehicles)
    like = next((each.bodies for each in others if "another" in each.marks or each.is_other), ())
    roll.vehicles.append(MentionedVehicle(len(roll.vehicles), Description(bodies=like, is_own=True, words="vehicle")))


def _drives(items: Words, mention: Mention) -> bool:
    after = items.cut(mention.last + 1, mention.last + 5)
    told = any(item.verb is not None and item.verb.kind in _DRIVES for item in after.cut(0, 3))
    return after.at(0).get("auxiliary") is not None and (told or after.has("bound", "lane"))


def _is_struck(items: Words, mention: Mention) -> bool:
    before = items.at(mention.first - 1)
    return items[mention.first].low == "me" and before.verb is not None and before.verb.kind in STRIKES


def lead_in(
    sentences: Sequence[Sentence], found: Sequence[Sequence[Mention]], headlines: Sequence[bool], roll: VehicleRoll
) -> None:
    """Let "a driver" who strikes one of two vehicles in the first sentence be the other's."""
    if len(roll.vehicles) != 2:
        return
    rows = zip(sentences, found, headlines, strict=True)
    sentence, row = next(((each, row) for each, row, is_title in rows if not is_title and row), (None, ()))
    struck = next((each for each in row if each.description is not None and len(each.vehicles) == 1), None)
    person = row[0] if row else None
    if sentence is None or struck is None or person is None or person.kind is not MentionKind.PERSON or person.vehicles:
        return
    between = sentence.items.cut(person.last + 1, struck.first)
    strikes = any(item.verb is not None and item.verb.kind in STRIKES for item in between)
    if (
        strikes
        and not between.has("conjunction")
        and sentence.items[person.last].get("person") in {"driver", "someone"}
    ):
        person.vehicles = (1 - struck.vehicles[0],)


def _is_of_writer(items: Words, row: Sequence[Mention]) -> bool:
    """Whether a sentence begins with what the writer does behind the wheel, with "I" or without: "Got on the freeway"."""
    opens = items.at(0)
    if opens.verb is not None and opens.verb.form in {"past", "both", "ing"} and opens.verb.kind != "own":
        return True
    if opens.get("auxiliary") == "be" and items.cut(1, 6).has("lane", "road", "verb", "bound"):
        return True
    if not row or row[0].kind is not MentionKind.SELF:
        return False
    verb = items.at(row[0].last + 1).verb
    return _drives(items, row[0]) or (verb is not None and verb.kind in _DRIVES)


def put_in_order(
    sentences: Sequence[Sentence], found: Sequence[Sequence[Mention]], headlines: Sequence[bool], roll: VehicleRoll
) -> None:
    """Put the vehicles into the order in which they come up, the writer's with the first "I"."""
    own, first = roll.own(), dict[int, int]()
    if any(each.description.number is not None for each in roll.vehicles):
        return
    for is_title, row in zip(headlines, found, strict=True):
        for mention in () if is_title else row:
            for place in (
                mention.vehicles[:1]
                if mention.description is not None or (row[0] is mention and mention.kind is MentionKind.PERSON)
                else ()
            ):
                first.setdefault(place, mention.span.start)
    starts = [each.span.start for row in found for each in row if each.kind is MentionKind.SELF]
    rest = [place for place in range(len(roll.vehicles)) if (place,) != own]
    body = [each for is_title, row in zip(headlines, found, strict=True) for each in row if not is_title]
    others = [each.span.start for each in body if each.kind is MentionKind.OTHER and not each.vehicles]
    others += [row[0].span.start for row in found[:1] if row and row[0].kind is MentionKind.ONE and not row[0].vehicles]
    if own and len(rest) == 1 and others and min(others) < min(starts, default=math.inf) and rest[0] in first:
        first[rest[0]] = min(first[rest[0]], *others)
    unnamed = own if own and own[0] not in first else ()
    titled = any(
        each.vehicles == own for is_title, row in zip(headlines, found, strict=True) for each in row if is_title
    )
    acts = [at for at, sentence in enumerate(sentences) if _is_of_writer(sentence.items, found[at])]
    if own and titled:
        first[own[0]] = -1
    elif unnamed and starts:
        first[own[0]] = starts[0]
    elif own and acts:
        first[own[0]] = min(first[own[0]], sentences[acts[0]].span.start)
    old = sorted(range(len(roll.vehicles)), key=lambda place: (first.get(place, math.inf), place))
    new = {place: at for at, place in enumerate(old)}
    roll.vehicles = [roll.vehicles[place] for place in old]
    for at, vehicle in enumerate(roll.vehicles):
        vehicle.place = at
    for mention in (each for row in found for each in row):
        mention.vehicles = tuple(new[place] for place in mention.vehicles)


def seat_people(sentences: Sequence[Sentence], found: Sequence[Sequence[Mention]]) -> None:
    """Put a person into the vehicle that the same sentence calls hers or his: "a teacher was turning in her Corsa"."""
    for sentence, row in zip(sentences, found, strict=True):
        theirs = next((each for each in row if each.description is not None and each.description.is_theirs), None)
        for mention in row if theirs is not None else ():
            item = sentence.items[mention.last]
            someone = item.get("person") == "someone" or item.low in word_set("relatives")
            if mention.kind is MentionKind.PERSON and not mention.vehicles and someone and theirs is not None:
                mention.vehicles = theirs.vehicles if mention.last < theirs.first else ()


def possess(sentences: Sequence[Sentence], found: Sequence[Sequence[Mention]]) -> None:
    """Give a "she" with whom a text begins the vehicle that it calls hers: "drifted into her Altima"."""
    rows = [(place, mention) for place, row in enumerate(found) for mention in row]
    described = [(place, each) for place, each in rows if each.description is not None]
    hers = next(((place, each) for place, each in described if each.description and each.description.is_theirs), None)
    for place, mention in rows if hers is not None else ():
        early = mention.span.start < described[0][1].span.start
        someone = mention.kind is MentionKind.PERSON and sentences[place].items[mention.last].get("person") == "someone"
        is_one = mention.kind is MentionKind.ONE or someone
        if hers is not None and early and place <= hers[0] and is_one and not mention.vehicles:
            mention.vehicles = hers[1].vehicles


def seat_persons(items: Words, row: Sequence[Mention]) -> None:
    """Put a person into the vehicle that it is said to sit in: "he's in a Dodge Ram"."""
    for one, other in itertools.pairwise(row):
        between = items.cut(one.last + 1, other.first)
        sits = 0 < len(between) <= 3 and between[-1].low in word_set("sits_in") - {"'s"}
        verb = next((item.verb.kind for item in between if item.verb is not None), "travel")
        sits |= (
            0 < len(between) <= _WITH and between[-1].low == "with" and verb == "travel"
        )  # "the driver went with a lorry"
        described = other.description
        if described is None or described.is_own or one.vehicles:
            continue
        if sits and one.kind in {MentionKind.ONE, MentionKind.PERSON}:
            one.vehicles = other.vehicles
    for place, one in enumerate(row):  # "the woman who hit me was in a Nissan"
        if one.kind is MentionKind.PERSON and not one.vehicles and items.at(one.last + 1).is_a("relative"):
            seats = [each for each in row[place + 1 :] if each.description and each.vehicles]
            led = items.cut(seats[0].first - 2, seats[0].first) if seats else Words()
            if led.says(word_set("sits_in")) and led.at(0).get("auxiliary") == "be":
                one.vehicles = seats[0].vehicles


def couple(items: Words, row: Sequence[Mention]) -> None:
    """Give two names of one vehicle that stand side by side one description: "Vehicle 1, a 2004 Honda Civic"."""
    for one, other in itertools.pairwise(row):
        bracketed = items.at(other.first - 1).low == "(" and items.at(other.last + 1).low == ")"
        if bracketed and one.description is not None and items[other.first].is_a("insured"):
            is_self = other.kind is MentionKind.SELF
            one.description = replace(one.description, is_own=one.description.is_own or is_self)
            other.kind, other.twin = MentionKind.NAMED, one  # "a Hilux (claimant) that was entering"
    for one, other in itertools.pairwise([each for each in row if each.description is not None]):
        between = items.cut(one.last + 1, other.first)
        if one.description is None or other.description is None or (one.number and other.number):
            continue
        named_again = bool(between) and all(item.is_a("thing") for item in between)
        named_again |= _is_placed(items, between, one, other) or _sits_in_new(between, one, other)
        if not named_again and (len(between) > _APPOSITION or not _is_apposition(between, other)):
            continue
        numbered = one.number or other.number
        if not numbered and (not other.is_new or one.description.contradicts(other.description)):
            continue
        one.description = other.description = one.description.merged(other.description)
        other.is_new, other.twin = one.is_new, one


def _is_placed(items: Words, between: Words, one: Mention, other: Mention) -> bool:
    """Whether a name stands behind where the vehicle was: "the car in front of me, a Toyota Highlander, stopped"."""
    plain = one.description is not None and not one.description.names and one.number is None
    named = other.is_new and other.description is not None and bool(other.description.names)
    placed = 1 < len(between) <= _APPOSITION and between[0].is_a("ahead", "behind", "beside", "oncoming")
    ends = items.at(other.last + 1).low in {",", "", ")", ";", "-"} or items.at(other.last + 1).is_a(
        "auxiliary", "verb"
    )
    return plain and named and placed and between[-1].low == "," and ends


def _sits_in_new(between: Words, one: Mention, other: Mention) -> bool:
    """Whether a numbered driver sits in a vehicle that has no number: "D1 Harlan was s/b in a Dodge Ram"."""
    fresh = other.description is not None and (other.is_new or other.description.is_theirs) and other.number is None
    bare = one.number is not None and one.description is not None and not one.description.names
    led = 0 < len(between) <= _SEAT and between[-1].low in word_set("sits_in") - {"'s"}
    return fresh and bare and led and not between.has("relative") and not between.says({",", ";"} & {between.at(0).low})


def _is_apposition(between: Words, other: Mention) -> bool:
    if not between:
        return True
    is_copula = all(item.get("auxiliary") == "be" or item.low == ")" for item in between)
    has_mark = between.says(word_set("apposition_marks"))
    plain = all(item.low in word_set("apposition") or item.is_a("thing", "descriptor") for item in between)
    unknown = len(between) <= 2 and all(not item.kinds and item.low.isalpha() for item in between)  # "veh 1 unk pickup"
    return (is_copula and other.is_new) or (plain and has_mark) or unknown
