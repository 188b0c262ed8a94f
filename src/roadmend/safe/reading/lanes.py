"""How many lanes the road has in all."""

import re
from collections.abc import Sequence

from roadmend.safe.reading.text import Finding, Sentence, nothing

_COMPASS = r"(?:north|south|east|west)"
_N = r"(\d{1,2})"
_KIND = (
    r"(?:(?:travel|traffic|through|straight|straight-through|straight through|general|driving|bituminous|asphalt|"
    r"concrete|paved|dedicated|level|initial|main|marked|inbound|outbound|adjacent|designated|separate|active|"
    r"channelized|single|exclusive|turn|left|right|left-turn|right-turn|center|middle|two-way|2-way|only)[- ,]*)*"
)
_ROAD = (
    r"(?:road|roadway|trafficway|highway|street|freeway|interstate|expressway|avenue|boulevard|parkway|"
    r"thoroughfare|turnpike|route|arterial)"
)
_TOTAL = re.compile(
    rf"(?<![\w-])(?:([2-9]|1\d)[- ]lane(?:d)?\b(?! {_COMPASS}bound| (?:for|of) {_COMPASS}| in (?:each|either))|"
    rf"(1)[- ]lane(?:d)? (?:[\w-]+ ){{0,2}}{_ROAD})"
)
_HAS = re.compile(
    rf"\b{_ROAD}s?\b[^.;]{{0,40}}?(?:\b(?:has|had|having|with|of|comprising|featur\w+|contain\w+|carr\w+|"
    rf"(?:is|was|are|were)(?: (?:made up|composed)(?: of)?)?)|\() ?(?:a total of )?{_N} {_KIND}lanes\b(?! (?:in (?:each|either)|"
    rf"each|per|{_COMPASS}))"
)
_EACH = re.compile(
    rf"(?<![\w-])(?:{_N}|(a single|a|single)) {_KIND}lanes?\b(?: of (?:travel|"
    r"traffic))?(?:(?!(?<!turn )(?<!turning )\blanes?\b)[^.;\d]){0,45}?\b(?:in|for|per|going|each)\s*(?:each|"
    r"either|both|every|opposite|opposing|per)?\s*(?:travel |traffic |of the )?(?:direction|way|directions|"
    rf"side)s?\b(?: of travel)?|(?<![\w-]){_N}[- ]lanes? (?:in )?each (?:way|direction)"
)
_COUNT = rf"(?<![\w-])(?<!number )(?<!lane )(?<!no )(?<!event ){_N}"  # "lane 2" and "the number 2 lane" count nothing
_HAS_OR_IS_OF = (
    r"(?:consist\w*|(?:is|was|are|were) composed|had|has|have|contain\w*|provid\w*|of|with|featur\w*|compris\w*|"
    r"includ\w*)"
)
_DIRECTED = (
    # "2 northbound lanes", "1 northbound left-turn lane"
    re.compile(
        rf"{_COUNT} (?:[\w-]+,? ){{0,2}}?({_COMPASS})bound\b(?! (?:vehicle|car|driver|approach))(?: {_KIND}|"
        r"[- ](?:(?!\d)[\w-]+ ){0,3})lanes?"
    ),
    # "2 northbound and 3 southbound lanes", and, of lanes named before, "the 2 northbound were level"
    re.compile(rf"{_COUNT} ({_COMPASS})bound(?=,? and \d{{1,2}} {_COMPASS}bound {_KIND}lanes| (?:were|are)\b)"),
    # "2 lanes northbound", "2 through lanes for northbound traffic"
    re.compile(
        rf"{_COUNT} {_KIND}(?:through-)?lanes? (?:for |traveling |heading |running |in the |going |"
        rf"that (?:travel|run) |of )?({_COMPASS})(?:bound|erly|ern)?\b(?!/| and {_COMPASS})"
    ),
    # "the northbound roadway consists of 2 travel lanes"
    re.compile(
        rf"(?<!\d )\b({_COMPASS})bound (?:side |approach |roadway |road |direction |lanes |portion |"
        r"direction of travel |travel lanes |traffic |lane |"
        rf"leg )*(?:[\w' -]{{0,24}})?\b{_HAS_OR_IS_OF} (?:of )?(?:only )?{_N} (?:\w+ )?{_KIND}lanes?"
    ),
)
_PAIR = re.compile(rf"(?<![\w-]){_N} {_KIND}lanes? (?:for )?(?:the )?{_COMPASS}(?:bound)? and {_COMPASS}(?:bound)?\b")
_TURN_LANE = re.compile(
    rf"(?:(?<![\w-]){_N}|\ban?|\bthe) (?:[\w-]+ )?(?:center |dedicated |continuous |2-way |two-way |shared |"
    r"exclusive )*(?:left[- ]turn|turn(?:ing)?|right[- ]turn)(?:[- ]only)?(?:ing)? lanes?"
)
_CENTER_TURN_LANE = re.compile(
    r"\b(?:2-way|two-way|center|middle|continuous|shared|dedicated) (?:\w+[- ])?(?:left[- ])?turn(?:ing)? lane\b"
)
_MIDDLE_OF = re.compile(
    rf"\b(?:\w+|\d) (?:travel |through )?lane of {_N}\b|"
    rf"\b(?:left|right|middle|center|inside|outside|far left|far right) (?:\w+ )?of {_N} (?:\w+ )?lanes?|"
    rf"\b(?:left|right|middle|center) (?:travel )?lane of (?:a )?{_N}"
)
_RAMP = re.compile(r"\bramp\b")
_ONE_WAY = re.compile(r"\b(?:1|one)-?\s?way (?:street|road|roadway|traffic|asphalt|alley)|\bone-way\b|\b1-way\b")
_TWO_WAY = re.compile(
    r"\b(?:2|two)-?\s?way\b(?! (?:left|turn|radio|stop))|\bwide enough for 2\b|\bundivided\b|\bcenterline\b|"
    r"\bopposing lane\b|\boncoming (?:travel )?lane\b|\bdouble yellow\b"
)
_LANE_OF = re.compile(rf"\bin the ({_COMPASS})bound (?:travel )?lane\b")
MOST = 16


def read_lanes(sentences: Sequence[Sentence], *, merging: bool) -> Finding[int]:
    """The lanes of the road, both directions together; of the largest one where there are several.

    Args:
        sentences: of the report.
        merging: leave out what is said of ramps.
    """
    usable = [sentence for sentence in sentences if not (merging and _only_of_ramp(sentence.plain))]
    candidates = [*_totals(usable), *_per_direction(usable), *_sums(usable)]
    plausible = [finding for finding in candidates if finding.value is not None and 1 <= finding.value <= MOST]
    if plausible:
        sure = [finding for finding in plausible if finding.confidence >= 0.75]
        return max(sure or plausible, key=lambda finding: (finding.value or 0, finding.confidence))
    return _guess(usable)


def _only_of_ramp(plain: str) -> bool:
    return bool(_RAMP.search(plain)) and not re.search(
        r"freeway|highway|interstate|expressway|main|turnpike|parkway", plain
    )


def _without_ramp(plain: str) -> str:
    return re.sub(r"\b\d[- ]lane (?:\w+ )?(?:on-?|off-?|entrance |exit |access |interchange )?ramp", " ", plain)


def _totals(sentences: Sequence[Sentence]) -> list[Finding[int]]:
    found = []
    for sentence in sentences:
        found += [
            Finding(int(match[1] or match[2]), 0.95, sentence.text, "the road is called so")
            for match in _TOTAL.finditer(_without_ramp(sentence.plain))
        ]
        for match in _HAS.finditer(sentence.plain):
            one_way = re.search(rf"\b{_COMPASS}bound\b", match[0]) is not None
            found.append(Finding(int(match[1]), 0.5 if one_way else 0.8, sentence.text, "the lanes the road has"))
    return found


def _per_direction(sentences: Sequence[Sentence]) -> list[Finding[int]]:
    found = []
    for sentence in sentences:
        for match in _EACH.finditer(sentence.plain):
            count = 2 * int(match[1] or match[3] or 1)
            if re.search(r"\bboth directions\b", match[0]) and count >= 8:
                count //= 2  # "eight lanes in both directions" counts them together
            count += 2 * len(re.findall(r"\band (?:a|1) (?:\w+ )?(?:left|right)?[- ]?turn(?:ing)? lane", match[0]))
            extra = 1 if _CENTER_TURN_LANE.search(sentence.plain) else 0
            found.append(Finding(count + extra, 0.9, sentence.text, "the lanes of each direction, twice"))
    return found


def _sums(sentences: Sequence[Sentence]) -> list[Finding[int]]:
    """Add the lanes of north- and southbound traffic, and those of east- and westbound traffic."""
    lanes: dict[str, tuple[int, Sentence]] = {}
    extras: dict[str, int] = {}
    for sentence in sentences:
        plain = re.sub(
            r"\((?!\d+ (?:lanes )?(?:north|south|east|west)|1 |\d (?:[\w-]+ ){0,2}(?:north|south|east|west))[^)]*\)",
            " ",
            sentence.plain,
        )
        counts: dict[str, list[tuple[int, int]]] = {}
        for pattern in _DIRECTED:
            for match in pattern.finditer(plain):
                number, compass = (match[1], match[2]) if match[1].isdigit() else (match[2], match[1])
                span = match.start(1) if match[1].isdigit() else match.start(2)
                if int(number) <= 8 and all(span != place for _, place in counts.get(compass, [])):
                    counts.setdefault(compass, []).append((int(number), span))
        for compass, several in counts.items():
            # "one eastbound right-turn lane, one eastbound left-turn lane": parts of one count
            total = sum(count for count, _ in several)
            if compass not in lanes or total > lanes[compass][0]:
                lanes[compass] = total, sentence
        for first, second in (("north", "south"), ("east", "west")):
            if first in counts and second in counts:
                turn = [
                    match
                    for match in _TURN_LANE.finditer(plain)
                    if not re.search(r"(?:north|south|east|west)bound", match[0]) and not _part_of(plain, match)
                ]
                extras[first] = max(extras.get(first, 0), sum(int(match[1] or 1) for match in turn))
    found = []
    for first, second in (("north", "south"), ("east", "west")):
        if first in lanes and second in lanes:
            total = lanes[first][0] + lanes[second][0] + extras.get(first, 0)
            found.append(
                Finding(total, 0.9, lanes[first][1].text, f"the {first}- and the {second}bound lanes together")
            )
        elif first in lanes or second in lanes:
            count, sentence = lanes.get(first) or lanes[second]
            if count > 1:
                found.append(Finding(count, 0.5, sentence.text, "only the lanes of one direction are counted"))
    found += [
        Finding(int(match[1]), 0.6, sentence.text, "the lanes of both directions")
        for sentence in sentences
        for match in _PAIR.finditer(sentence.plain)
    ]
    return found


def _part_of(plain: str, match: re.Match[str]) -> bool:
    """Whether a turn lane is one of those that were counted before: 'three lanes with the first as a turn lane'."""
    return bool(
        re.search(
            r"\b(?:including|include|with the|composed of|are|as|being|one of)\b[^,;.]{0,40}$", plain[: match.start()]
        )
    ) and not re.search(r"\blanes? with $", plain[: match.start()])


def _guess(sentences: Sequence[Sentence]) -> Finding[int]:
    counted = [
        (int(next(filter(None, match.groups()))), sentence)
        for sentence in sentences
        for match in _MIDDLE_OF.finditer(sentence.plain)
    ]
    if counted:
        count, where = max(counted, key=lambda pair: pair[0])
        return Finding(count, 0.4, where.text, "the lanes of one direction, the other is not counted")
    ways = {match[1] for sentence in sentences for match in _LANE_OF.finditer(sentence.plain)}
    for sentence in sentences:
        if _ONE_WAY.search(sentence.plain):
            return Finding(1, 0.4, sentence.text, "a one-way road with no lanes counted")
    for sentence in sentences:
        if _TWO_WAY.search(sentence.plain):
            return Finding(2, 0.5, sentence.text, "a road for both directions with no lanes counted")
    if {"north", "south"} <= ways or {"east", "west"} <= ways:
        return Finding(2, 0.5, None, "one lane is mentioned of each direction")
    return nothing("the lanes are not counted")
