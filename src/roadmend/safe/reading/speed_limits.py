"""Posted speed limits, each with the road that it is posted on."""

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from roadmend.safe.compass import TOWARDS
from roadmend.safe.dsl import MAX_SPEED_LIMIT, Position
from roadmend.safe.reading.text import Finding, Sentence, nothing

KMH_PER_MPH = 1.609344
_LEAST = 5  # [mph]

_LIMIT = re.compile(
    r"\bspeed (?:limits?|zone)|\bposted:? (?:at|limit|speed|\d)|\blimits?\b|(?:mph|km/h) (?:speed )?(?:zone|limit)"
)
_ADVICE = re.compile(
    r"\b(?:advisory|recommended|suggested) (?:curve )?speed(?: limit)?(?: (?:of|is|was))? \d+ (?:mph|km/h)(?: ?\(\d+ (?:mph|km/h)\))?"
)
_NO_LIMIT = re.compile(r"\b(?:advisory|recommended|speed limit sign\b(?! (?:of|for|posted))|minimum)\b")
_VALUE = re.compile(
    r"(?P<first>\d{1,3}(?:\.\d+)?) (?P<unit>mph|km/h)\.?\s*(?:[(/\[]\s*|or |"
    r", )?(?:(?P<second>\d{1,3}(?:\.\d+)?) (?P<unit2>(?!(?P=unit))(?:mph|km/h)))?"
)
_AXES = {
    "ns": re.compile(
        r"\bnorth(?:bound)?\s*(?:/|-|and|or|to)?\s*(?:and )?south(?:bound)?\b|"
        r"\bsouth(?:bound)?\s*(?:/|-|and)\s*north|\b(?:north|south)bound (?:\w+ )?(?:lanes?|roadway|"
        r"road|traffic|travel|direction|approach|street)|\b(?:north|south) (?:\w+ )?(?:lanes?|roadway)"
    ),
    "ew": re.compile(
        r"\beast(?:bound)?\s*(?:/|-|and|or|to)?\s*(?:and )?west(?:bound)?\b|"
        r"\bwest(?:bound)?\s*(?:/|-|and)\s*east|\b(?:east|west)bound (?:\w+ )?(?:lanes?|roadway|road|"
        r"traffic|travel|direction|approach|street)|\b(?:east|west) (?:\w+ )?(?:lanes?|roadway)"
    ),
}
_AXIS_OF = {Position.N2S: "ns", Position.S2N: "ns", Position.W2E: "ew", Position.E2W: "ew"}
_LABEL = re.compile(r"\b(\d+)-?\s?lane\b")
_BOTH = re.compile(r"\b(?:both|all|each|either)\b")
_VEHICLE = re.compile(r"\bv(\d)\b")
_SAME_ROAD = re.compile(
    r"\b(?:this|the same) (?:road|street|highway|trafficway)|"
    r"\bthe (?:road|roadway|trafficway|street|highway) (?:is|was|had|has|consist)|"
    r"^(?:it|there|the (?:posted )?speed limit)\b"
)
_ROAD_BEFORE_VALUE = re.compile(r"\blimits? (?:on|for|of|along|in) [^.;,]*\b(?:was|is)\s*$")
_FOR_TRUCKS = re.compile(r"[^\w.;]*(?:limit )?for (?:\w+ )?(?:trucks|tractor|commercial|heavy)")


@dataclass(frozen=True, slots=True)
class Limit:
    """A posted limit [mph] and what it holds for; what is empty holds for all."""

    mph: int
    axes: frozenset[str]
    vehicles: frozenset[int]
    labels: frozenset[int]  # a road that is told apart by its number of lanes
    towards: str | None
    sentence: str
    trucks: bool = False  # for heavy trucks alone
    by_context: bool = False  # the road is that of the sentences before


def read_limits(sentences: Sequence[Sentence]) -> tuple[Limit, ...]:
    """Every posted limit of a report."""
    limits: list[Limit] = []
    axes_of_label = _axes_of_labels(sentences)
    topic: frozenset[str] = frozenset()  # the road that the sentences before were about
    for sentence in sentences:
        plain = _ADVICE.sub("", sentence.plain)
        named = _axes(plain)
        if named:
            topic = named
        values = [
            match
            for match in _VALUE.finditer(plain)
            if not _is_speed_of_travel(plain, match) and _LEAST <= _mph(match) <= MAX_SPEED_LIMIT
        ]
        if not values or not _LIMIT.search(plain) or _NO_LIMIT.search(plain):
            if not _SAME_ROAD.search(plain) and not named:
                topic = frozenset()
            continue
        road_first = bool(_axes(plain[: values[0].start()][-80:]))  # "for the north/south road 45 mph"
        for index, match in enumerate(values):
            start = values[index - 1].end() if index else 0
            end = values[index + 1].start() if index + 1 < len(values) else len(plain)
            around = plain if len(values) == 1 else _own_part(plain, start, match, end, road_first=road_first)
            axes = _axes(around)
            labels = frozenset(int(label) for label in _LABEL.findall(around))
            by_context = False
            if not axes and len(values) == 1:
                axes = topic if _SAME_ROAD.search(plain) and len(topic) == 1 else frozenset()
                by_context = bool(axes) and plain.startswith("the ")
            if not axes and labels and len(axes_of_label) > 1:
                axes = frozenset().union(*(axes_of_label.get(label, frozenset()) for label in labels))
            vehicles = frozenset(int(number) for number in _VEHICLE.findall(around))
            if _BOTH.search(around) and len(vehicles) != 1:
                axes, vehicles = frozenset(), frozenset()
            towards = re.search(r"\b(north|south|east|west)bound\b", around)
            one_way = (
                towards[1]
                if towards and len(set(re.findall(r"\b(north|south|east|west)bound\b", around))) == 1
                else None
            )
            trucks = _FOR_TRUCKS.match(plain, match.end()) is not None
            limits.append(Limit(_mph(match), axes, vehicles, labels, one_way, sentence.text, trucks, by_context))
    return tuple(limits)


def limit_for(
    number: int, heading: Position | None, limits: Sequence[Limit], *, at_junction: bool, is_truck: bool = False
) -> Finding[int]:
    """The limit that holds for a vehicle.

    Args:
        number: the vehicle's.
        heading: its direction of travel, where known.
        limits: those of the report.
        at_junction: the vehicles may have been on different roads.
        is_truck: a limit for trucks holds for it.
    """
    for_trucks = [limit for limit in limits if limit.trucks]
    if is_truck and for_trucks:
        return Finding(for_trucks[0].mph, 0.9, for_trucks[0].sentence, "the limit for trucks")
    limits = [limit for limit in limits if not limit.trucks]
    if not limits:
        return nothing("no speed limit is mentioned")
    axis = _AXIS_OF.get(heading) if heading is not None else None
    own = [limit for limit in limits if number in limit.vehicles]
    if own:
        return Finding(own[0].mph, 0.9, own[0].sentence, "the limit said of this vehicle")
    others = [limit for limit in limits if not limit.vehicles or not at_junction]
    on_axis = [limit for limit in others if axis is not None and limit.axes == {axis}]
    if on_axis:
        towards = TOWARDS[heading].lower() if heading is not None else ""
        same = [limit for limit in on_axis if limit.towards == towards]
        chosen = (same or on_axis)[0]
        return Finding(chosen.mph, 0.95, chosen.sentence, "the limit of the road that it was on")
    general = [limit for limit in others if not limit.axes or len(limit.axes) == 2]
    if general:
        return Finding(general[0].mph, 0.9 if len(general) == 1 else 0.6, general[0].sentence, "the limit of the place")
    if (axis is None or not at_junction or all(limit.by_context for limit in others)) and len(
        {limit.mph for limit in others}
    ) == 1:
        return Finding(others[0].mph, 0.5, others[0].sentence, "the only limit mentioned")
    return nothing("the limits mentioned are those of another road")


def _mph(match: re.Match[str]) -> int:
    if match["unit"] == "mph":
        return round(float(match["first"]))
    if match["unit2"] == "mph":
        return round(float(match["second"]))
    return 5 * round(float(match["first"]) / KMH_PER_MPH / 5)  # posted limits are multiples of five


def _is_speed_of_travel(plain: str, match: re.Match[str]) -> bool:
    before = plain[max(0, match.start() - 45) : match.start()]
    if re.match(r"\)?,?\s*(?:posted )?(?:speed )?(?:limit|zone)\b", plain[match.end() :]):
        return False
    return bool(
        re.search(
            r"\b(?:travel\w*|going|driving|moving|estimated?|approximately|speeds? of|delta|traveling)\b[^.;]*$",
            before,
        )
    ) and not re.search(r"(?:limit|posted)[^.;]*$", before)


def _own_part(plain: str, start: int, match: re.Match[str], end: int, *, road_first: bool) -> str:
    """The words that belong to one of several values: those after it where 'for' or 'on' follows, else those before."""
    if road_first or _ROAD_BEFORE_VALUE.search(plain[start : match.start()]):
        return plain[start : match.start()]
    after = re.match(
        r"(?:[^\d]*?\b(?:for|on|in|along)\b|\s*(?=(?:north|south|east|west)\b))((?:(?!\band\b(?! (?:east|west|north|south))).)*)",
        plain[match.end() : end],
    )
    if after and "limit" not in after[1]:
        return after[1]
    return plain[start : match.start()]


def _axes(text: str) -> frozenset[str]:
    return frozenset(axis for axis, pattern in _AXES.items() if pattern.search(text))


def _axes_of_labels(sentences: Sequence[Sentence]) -> Mapping[int, frozenset[str]]:
    found: dict[int, frozenset[str]] = {}
    for sentence in sentences:
        for part in re.split(r";|,? and (?=the \d+-?\s?lane)", sentence.plain):
            axes, labels = _axes(part), set(_LABEL.findall(part))
            if len(axes) == 1 and len(labels) == 1:
                found.setdefault(int(labels.pop()), axes)
    return found
