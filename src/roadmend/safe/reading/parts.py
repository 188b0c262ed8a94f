"""Parts of vehicles that a text names: "the left front", "passenger side door", "rear bumper"."""

from dataclasses import dataclass

from roadmend.safe.dsl import Side
from roadmend.safe.reading.lexicon import word_set
from roadmend.safe.reading.tokens import Words


@dataclass(frozen=True, slots=True)
class NamedPart:
    """A part of a vehicle.

    Attributes:
        side: where it is; None for one side, not said which.
        other: its second side: "the left front" is in front, and on the left.
        is_flank: whether it is a side rather than an end.
    """

    side: Side | None
    other: Side | None
    is_flank: bool


def read_part(items: Words, place: int, *, is_led: bool) -> tuple[NamedPart, int] | None:
    """The part that is named at a place, and its last word; None where there is none.

    Args:
        items: words of a sentence.
        place: of the first of its words.
        is_led: whether an article or an owner stands before it.
    """
    last, hands, ends, is_flank = place - 1, list[str](), list[str](), False
    for at in range(place, len(items)):
        item = items[at]
        if item.is_a("flank"):
            hands.append(item.get("flank"))
            is_flank = True
        elif item.is_a("hand") and not item.is_a("part") and (ends or is_flank or _leads_to_part(items, at + 1)):
            hands.append(item.get("hand"))
        elif item.is_a("part"):
            is_flank |= item.get("part") == "Side"
            ends += [item.get("part")] if item.get("part") in {"Front", "Rear"} else []
        elif (item.low == "sliding" or (item.low in {"most", "/", "-"} and at > place)) and items.at(at + 1).is_a(
            "part", "hand"
        ):
            continue
        else:
            break
        last = at
    if last < place or not (hands or ends or is_flank) or _is_none(items, place, last, is_led=is_led):
        return None
    if is_flank and not hands and items.cut(place - 2, place).has("compass", "bound"):
        return None  # "the north side"
    hand, end = Side(hands[-1]) if hands else None, Side(ends[-1]) if ends else None
    if is_flank and (hand or not end):
        return NamedPart(hand, end, is_flank=True), last
    return NamedPart(end, hand, is_flank=is_flank), last


def _is_none(items: Words, place: int, last: int, *, is_led: bool) -> bool:
    """Whether the words are of a lane, a seat, a road, or no part by themselves."""
    item, after = items[place], items.at(last + 1)
    single = last == place and not item.is_a("flank") and " " not in item.low
    if single and ((not is_led and after.low != "of") or item.low in word_set("weak_parts")):
        return True
    if after.is_a("lane", "curve", "road") or after.low in word_set("not_part_of"):
        return True
    of_road = items.cut(last + 2, last + 4).has("road", "shoulder", "junction", "driveway", "lane")
    return (after.is_a("person") and not after.is_a("body")) or (after.low == "of" and of_road)


def _leads_to_part(items: Words, place: int) -> bool:
    item = items.at(place)
    return item.is_a("part", "flank") or (item.is_a("hand") and _leads_to_part(items, place + 1))
