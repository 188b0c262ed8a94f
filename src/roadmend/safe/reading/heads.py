"""Noun groups that describe a vehicle: where one begins and ends, and what it says: "a silver 2004 Honda Civic sedan"."""

import re
from collections.abc import Collection, Sequence

from roadmend.safe.claims import Span
from roadmend.safe.reading.cast import Description
from roadmend.safe.reading.lexicon import BodySense, NameSense, squeeze, word_set
from roadmend.safe.reading.tokens import NOTHING, Item, Words

YEARS = range(1920, 2100)
TRAITS = ("bound", "oncoming", "parked", "stationary")
_ROAD_NUMBER = re.compile(r"(?:[a-eh-ik-npr-s]|us|sr|cr|fm|rm|sh|st|dk|dw)\d{1,3}")
_REACH = 6  # words before a noun in which its article is looked for
_CLASSED = 0.9  # confidence from which a word for a body is more than "car" or "truck"
_FILL = 4  # words between the parts of a name


def is_head(items: Words, place: int, known: Collection[str] = ()) -> bool:
    """Whether a word names a vehicle or its kind here; a name that is known from elsewhere in the text does."""
    item, before, after = items.at(place), items.at(place - 1), items.at(place + 1)
    if item.low in known and item.is_name and not after.is_a("road", "lane"):
        return True
    if _is_bare_model(items, place):
        return True
    if item.is_a("body"):
        return _is_body(items, place)
    if not item.is_a("name") or item.is_a("mph") or after.is_a("mph", "time"):
        return False
    if (
        (after.is_a("road") or (after.is_a("lane") and after.is_name))
        and not after.is_a("body")
        and not item.low[-1].isdigit()
    ):
        return False  # "Lincoln Avenue"
    if item.low.startswith("i ") and item.low[2:].isdigit() and len(item.low) == len("i 40"):
        return before.is_a("name")  # an interstate, if no make is named
    named = items.cut(place + 2, place + 4) if after.low == "'s" else items.cut(place + 1, place + 3)
    if item.low.isalpha() and named.has("road") and named.at(0).is_name and not named.has("body", "name", "verb"):
        return False  # "Cooper's Landing Road"
    senses: tuple[NameSense, ...] = item.get("name")
    is_number = (
        _ROAD_NUMBER.fullmatch(squeeze(item.low)) and not before.is_a("name") and before.get("number") not in YEARS
    )
    lead = items.at(place - 2) if before.low == "the" else before
    on_it = (lead.low in word_set("road_leads") and after.low != "'s") or after.is_a("bound", "compass", "ramp", "road")
    on_it &= not items.at(place - 2).is_a("person")  # "the driver of C30"
    if is_number and on_it:
        return False  # "the A4", "I-40"
    if not all(sense.is_everyday for sense in senses) and not item.is_a("verb", "bound", "weather"):
        return not (before.low in {"on", "along", "onto"} and item.low.isalpha() and senses[0].model is None)
    if before.get("number") in YEARS:
        return True
    if before.is_a("name") and is_head(items, place - 1) and (_joins(before, item) or item.low.isdigit()):
        return True
    other = ("descriptor", "verb", "preposition", "determiner", "part", "hand", "number", "lanekind", "oncoming")
    if after.is_a("body") and item.is_name and not item.is_a(*other):
        return True
    lead = items.at(place - 2) if before.is_a("descriptor", "name", *TRAITS) else before  # "the white Explorer"
    chain = items.cut(place - 5, place)
    if (
        len(item.kinds) == 1
        and chain.says({"in", "driving"})
        and chain.cut(1).has("determiner")
        and not chain.has("road")
    ):
        return True  # "in a beat up ranger"
    led = lead.is_a("determiner") or lead.get("pronoun") in {"own", "its", "other"} or lead.low in {"(", "'s", "her"}
    led |= before.get("pronoun") in {"own", "its"}
    if led and item.low in word_set("models_in_small_letters") and not after.is_a("road"):
        return True
    is_shown = item.is_name and not item.text.isupper()
    return led and is_shown and not item.is_a("number", "preposition", "hand", "bound", "compass", "lane", "road")


def _is_bare_model(items: Words, place: int) -> bool:
    """Whether a model that is another word, too, does what vehicles do: "Explorer turned across", "so Sonata stopped"."""
    item, before, after = items.at(place), items.at(place - 1), items.at(place + 1)
    if item.low not in word_set("models_in_small_letters") or not item.text.istitle():
        return False
    if before.is_a("preposition", "name", "compass") or (
        before.text.istitle() and before.low not in word_set("colours")
    ):
        return False
    acts = ("verb", "auxiliary", "bound", "part", "hand", "parked", "stationary")
    does = after.is_a(*acts) or after.get("person") == "driver" or after.low in word_set("after_model")
    return does and not (after.is_name and after.is_a("road", "lane", "junction", "compass"))


def _is_body(items: Words, place: int) -> bool:
    item, before, after = items.at(place), items.at(place - 1), items.at(place + 1)
    numbered = items.at(place - 2).is_a("thing") or items.at(place - 2).low == "#"
    if (
        before.get("number") in range(2, 20)
        and not item.low.endswith("s")
        and not numbered
        and not after.is_a("name", "body")
    ):
        return False  # "a 3-car crash"
    if item.low == "trailer" and before.get("determiner") != "the" and before.low != "'s":
        return False  # a truck's, not a vehicle of its own
    if item.low == "cab" and items.says(word_set("hauling")):
        return False  # a truck's
    if item.is_a("verb") and not before.is_a("determiner", "descriptor", "name", "number"):
        return False  # "to crossover the road"
    if item.is_a("part") and (
        before.is_a("part") or before.get("pronoun") in {"its", "own"} or before.low in {"'s", "her"}
    ):
        return False  # "his rear hatch"
    is_compound = after.low in word_set("compound_second") or after.is_a("object")
    return not (is_compound and item.low in word_set("compound_first"))


def _joins(make: Item, model: Item) -> bool:
    makes = {sense.make for sense in make.get("name")}
    return any(sense.make in makes for sense in model.get("name"))


def _is_filler(item: Item) -> bool:
    if item.is_a("preposition", "auxiliary", "conjunction") or (item.is_a("verb") and not item.is_a("body")):
        return False
    return item.is_a("descriptor") or item.get("number") in range(10) or (item.is_name and not item.kinds)


def read_group(items: Words, place: int) -> tuple[int, int, Item, Description]:
    """The noun group around a head.

    Returns:
        Its first and its last word, its article (``NOTHING`` where it has none), and what it says.
    """
    last, names, bodies = _right_of(items, place)
    first, article = _left_of(items, place)
    before = items.cut(first, place)
    owner = article.get("pronoun")
    is_other = owner == "other" or any(item.get("pronoun") == "other" for item in before)
    owned = items.at(first - 1).low == "'s"  # "the woman's Ford", "my wife's Honda"
    who = items.cut(first - 4, first - 1)
    side, yours = who.at(len(who) - 1).get("insured"), who.cut(len(who) - 2).says({"your"})
    mine = owned and not yours and (who.says({"my", "our"}) or side == "Self")
    theirs = owned and (yours or side == "Other")
    is_new = article.get("determiner") in {"a", "some"} or (article is NOTHING and bool(names) and not owned)
    is_new |= is_other and before.says({"another"})
    is_new |= article is NOTHING and items.at(first - 1).low == "one"  # "one white van came"
    marks = word_set("marks") | word_set("colours")
    description = Description(
        year=next((item.get("number") for item in before if item.get("number") in YEARS), None),
        names=names,
        bodies=bodies,
        is_own=owner == "own" or mine,
        is_theirs=owner in {"its", "one"},
        is_other=is_other or theirs,
        words=" ".join(item.low for item in items.cut(place, last + 1)),
        span=items.span(place, last),
        is_definite=not is_new,
        marks=frozenset(item.low for item in before if item.low in marks or item.is_a("parked")),
    )
    return first, last, article, description


def _right_of(items: Words, place: int) -> tuple[int, tuple[NameSense, ...], tuple[tuple[BodySense, Span], ...]]:
    last, names, bodies = place, list[NameSense](), list[tuple[BodySense, Span]]()
    at, told = place, -2
    while at < len(items) and (is_head(items, at) or _leads_on(items, at)):
        item = items[at]
        if is_head(items, at):
            last = at
            chosen = _chosen(item, names)
            if chosen is not None and not (item.is_a("body") and names):
                names.append(chosen)
            elif item.is_a("body"):
                if bodies and at == told + 1 and item.get("body").confidence >= _CLASSED:
                    bodies.pop()  # "a utility pickup" is a pickup
                bodies.append((item.get("body"), item.span))
                told = at
        at += 1
    return last, tuple(names), tuple(bodies)


def _leads_on(items: Words, place: int) -> bool:
    """Whether fillers alone stand before the next head."""
    for at in range(place, min(place + _FILL, len(items))):
        if at > place and is_head(items, at):
            return True
        if not _is_filler(items[at]):
            return False
    return False


def _chosen(item: Item, names: Sequence[NameSense]) -> NameSense | None:
    found: tuple[NameSense, ...] = item.get("name") or ()
    makes = {name.make for name in names}
    same = [sense for sense in found if sense.make in makes]
    return same[0] if same else found[0] if found and not names else None


def _left_of(items: Words, place: int) -> tuple[int, Item]:
    """Where a group begins, and its article."""
    for back in range(place - 1, max(-1, place - 1 - _REACH), -1):
        item = items[back]
        if item.is_a("determiner") or item.get("pronoun") in {"own", "its", "other"} or item.low == "her":
            return back, item
        if item.is_a("preposition", "conjunction", "auxiliary", "relative", "person"):
            break
        acts = item.verb is not None and item.verb.form not in {"ing", "both", "participle"}
        if item.low in word_set("group_ends") or (acts and not item.is_a("descriptor", *TRAITS)):
            break
    short_year = items.at(place - 1).low.isdigit() and len(items.at(place - 1).low) == 2 and items[place].is_a("name")
    first = place - short_year  # "09 Ford F150"
    while first and _is_attribute(items[first - 1]):
        first -= 1
    return first, NOTHING


def _is_attribute(item: Item) -> bool:
    is_plain = item.is_a("descriptor") and not item.is_a("verb")
    return is_plain or item.is_a("bound", "parked", "stationary") or item.get("number") in YEARS
