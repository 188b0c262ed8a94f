"""Ways that a text tells by what lies where: places whose side it explains, where its writer looks, and the sun."""

import itertools
from collections.abc import Iterator, Mapping, Sequence

from roadmend.safe.claims import Claim
from roadmend.safe.compass import opposite, turned
from roadmend.safe.dsl import Position, Side
from roadmend.safe.reading.clauses import Clause
from roadmend.safe.reading.facts import GOES, Text, claim, direction, of_vehicle, spoken_of
from roadmend.safe.reading.lexicon import word_set
from roadmend.safe.reading.tokens import Item, Sentence, Words

_REACH = 6  # words between a place and the side on which it lies
_HANDS = {"Left": Side.RIGHT, "Right": Side.LEFT}  # who comes from one hand goes to the other


def read_places(text: Text) -> Iterator[Claim]:
    """The claims of a text about ways that rest on where its places lie and where its writer looks."""
    yield from _by_sun(text)
    sides = [side for each in text.sentences if each.items.cut(0, 4).has("driveway") for side in _sides(each.items)]
    for clause in text.clauses:
        yield from _from_driveway(clause, sides)
    lie = _places(text)
    looks = _looks(text)
    for sentence in text.sentences:
        yield from _by_place(text, sentence, lie)
        if looks is not None:
            yield from _by_watcher(text, sentence, looks)


def _places(text: Text) -> Mapping[str, Position]:
    """By a place's name: the way that leads there: "the village, which is south of us", "the mill is at the north end"."""
    found: dict[str, Position] = {}
    for sentence in text.sentences:
        items = sentence.items
        for place, item in enumerate(items):
            way = direction(item)
            if way is None or not item.is_a("compass") or not _tells_side(items, place):
                continue
            near = next((at for at in range(place - 1, place - _REACH, -1) if _is_place(items, at)), None)
            if near is not None:
                found.setdefault(items[near].low, way)
    return found


def _tells_side(items: Words, place: int) -> bool:
    """Whether a compass point says where something lies: "which is south", "(east)", "so south", "at the north end"."""
    lead, before, after = items.at(place - 1), items.at(place - 2), items.at(place + 1)
    explains = lead.get("auxiliary") == "be" or lead.low == "'s"
    told = lead.low in {"(", "so"} or lead.low in word_set("that_is") or (explains and before.is_a("relative"))
    is_side = lead.low.endswith("the") and after.low in {"end", "side", "edge", "of", ""}
    return told or (is_side and before.low != "from" and (before.is_a("preposition") or lead.is_a("preposition")))


def _is_place(items: Words, at: int) -> bool:
    """Whether a word names a place: one that no table knows, or that of a yard or a house, behind an article."""
    item, before = items.at(at), items.cut(at - 2, at)
    led = before.has("determiner", "pronoun") or item.is_name or item.low in word_set("town_ways")
    is_plain = item.low.isalpha() and len(item.low) > 1 and item.kinds.keys() <= {"driveway", "verb"}
    return (
        is_plain
        and led
        and not items.at(at + 1).is_a("road")
        and (not item.is_a("verb") or items.at(at - 1).is_a("determiner"))
    )


def _by_place(text: Text, sentence: Sentence, lie: Mapping[str, Position]) -> Iterator[Claim]:
    """Who goes to a place, or comes from it."""
    items = sentence.items
    for place, item in enumerate(items):
        way = lie.get(item.low)
        led = items.cut(0, place)
        goes = led.says(word_set("goes_that_way")) or any(each.verb and each.verb.kind in GOES | {"do"} for each in led)
        leads = [each.low for each in items.cut(place - 4, place)]
        comes = any(each in word_set("leads_from") for each in leads)
        heads = any(each in word_set("leads_to") for each in leads) or item.low in word_set("town_ways")
        who = spoken_of(text, sentence, item.span) if way is not None and goes and comes is not heads else None
        if way is not None and who is not None:
            turns = any(each.verb is not None and each.verb.kind == "turn" for each in led)
            path = of_vehicle(who, "destination" if turns and heads else "initial_position")
            yield claim(path, opposite(way) if comes else way, 0.75, f"the text tells where the {item.low} lies", item)


def _looks(text: Text) -> Position | None:
    """The way in which the writer looks or walks, where the text tells one."""
    ways = {
        way
        for sentence in text.sentences
        for place, item in enumerate(sentence.items)
        if (way := direction(item)) is not None
        and any(each.get("pronoun") == "self" for each in sentence.items[:place])
        and sentence.items.cut(place - _REACH, place).says(word_set("bystanders_do"))
    }
    return ways.pop() if len(ways) == 1 else None


def _by_watcher(text: Text, sentence: Sentence, looks: Position) -> Iterator[Claim]:
    """Ways as a bystander tells them: "from our left", "coming toward me", "the same way I was walking"."""
    items = sentence.items
    for place, item in enumerate(items):
        way, mine = None, items.cut(place - 2, place)
        if item.is_a("hand") and items.at(place - 1).low in {"my", "our"} and mine.says({"from"}):
            way = turned(looks, _HANDS[item.get("hand")])
        elif item.is_a("oncoming") and item.low.endswith((" me", " us")):
            way = opposite(looks)
        elif item.is_a("same_way") and items.cut(place, place + 5).says({"i", "we", "me", "us"}):
            way = looks
        who = (
            spoken_of(text, sentence, items[place - 2 if item.is_a("hand") else place].span)
            if way is not None
            else None
        )
        if who is not None:
            yield claim(of_vehicle(who, "initial_position"), way, 0.8, "as the writer looks", item)


def _from_driveway(clause: Clause, sides: Sequence[Item]) -> Iterator[Claim]:
    """Who comes out of a driveway on the east side of a street heads west."""
    words = clause.words
    place = next((place for place, item in enumerate(words) if item.is_a("driveway")), None)
    backs = any(item.verb is not None and item.verb.kind == "reverse" for item in words)
    if place is None or backs or clause.kind not in {"emerge", "travel", "depart"}:
        return
    if words.cut(place - 3, place).says({"into", "to", "toward"}):
        return
    for item in _sides(words) or sides:
        way = direction(item)
        for vehicle in clause.subject.vehicles[:1] if way is not None else ():
            path = of_vehicle(vehicle, "initial_position")
            yield claim(path, way and opposite(way), 0.85, f"it comes from the {item.low} side", item)


def _sides(items: Words) -> list[Item]:
    """Sides of a road that are named: "on the east side"."""
    pairs = itertools.pairwise(items)
    return [one for one, after in pairs if one.is_a("compass") and direction(one) and after.low in {"side", "edge"}]


def _by_sun(text: Text) -> Iterator[Claim]:
    """Who has the sun in his eyes in the morning heads east; who has it on his right then heads north."""
    low = text.summary.lower()
    early, late = (any(word in low for word in word_set(name)) for name in ("early_sun", "late_sun"))
    sunward = Position.W2E if early else Position.E2W
    for clause in text.clauses if early is not late else ():
        words = clause.sentence.items
        sun = next((at for at, item in enumerate(words) if item.is_a("weather") and "sun" in item.low), None)
        if sun is None:
            continue
        ahead = words.says({"eyes", "ahead", "blinded", "facing"}) or any("eyes" in item.low for item in words)
        behind = any(item.low in {"behind", "back"} for item in words)
        hand = words.cut(sun, sun + 10).first("hand")
        ways = {sunward if ahead else opposite(sunward)} if ahead is not behind else set()
        if hand is not None and not ways and clause.kind in GOES | {""}:
            ways = {turned(sunward, Side.LEFT if hand.get("hand") == "Right" else Side.RIGHT)}
        near = spoken_of(text, clause.sentence, words[sun].span)
        who = clause.subject.vehicles[:1] or (() if near is None or hand is None else (near,))
        for vehicle, way in itertools.product(who, ways):
            yield claim(of_vehicle(vehicle, "initial_position"), way, 0.66, "the sun tells its way", clause.span)
