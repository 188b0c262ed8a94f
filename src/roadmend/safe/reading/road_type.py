"""Shape of the road where the vehicles first collide, and the stem of a T-intersection."""

import re
from collections.abc import Mapping, Sequence

from roadmend.safe.compass import BOUND, NORTH_SOUTH, TOWARDS, origin_of, turned
from roadmend.safe.dsl import Compass, Position, RoadType, Side
from roadmend.safe.reading.clauses import Clause
from roadmend.safe.reading.text import Finding, Sentence, nothing

_RAMP = (
    r"(?:on-ramp|entrance[- ]ramp|entry[- ]ramp|access ramp|merg(?:e|ing) (?:ramp|lane)|acceleration lane|"
    r"slip road|freeway entrance|(?<!exit )(?<!off-)(?<!off )ramp)"
)
_ON_RAMP = re.compile(
    r"\b(?:on|in|from|off|along|down|up|of|using|traveling|exiting|exited|leaving|left|"
    rf"at the end of)\s+(?:of )?(?:the |an? |its |lane of )*(?:[\w-]+ ){{0,4}}?{_RAMP}\b|"
    r"\b(?:merg\w+|enter(?:ing|ed)?) (?:\w+ ){0,3}?(?:on)?to (?:the |an? )?(?:[\w-]+ ){0,4}?(?:freeway|"
    r"highway|interstate|expressway|turnpike|parkway|motorway|main ?(?:line|road|way)|traffic)\b|"
    r"\bmerg(?:e|ed|ing) (?:in|on)to\b(?! the (?:left|right|middle|center|inside|outside|adjacent|"
    r"next))[^.;]{0,40}\bfrom\b|\b(?:attempt\w*|about|try\w*|inten\w+|beginning|began|in order) to (?:enter|"
    r"merge onto|merge into|merge with|join) (?:the )?(?:same )?(?:[\w-]+ )?(?:freeway|highway|interstate|"
    r"expressway|turnpike|traffic|main)"
)
_NOT_FROM_RAMP = re.compile(
    r"\b(?:to|onto|toward|towards|for|approaching|past|enter(?:ing)?|before|exit(?:ing)? (?:to|onto|at)) (?:the |"
    rf"an? )?(?:(?!from\b)[\w-]+ ){{0,4}}?{_RAMP}\b|\bexit[- ]ramp|\boff-ramp|\bramp (?:to|signal|meter)"
)
_T = re.compile(
    r"\b[\"']?t[\"']?[- ]?(?:type )?(?:intersection|junction|shaped|intersecting)|"
    r"\b3[- ](?:leg(?:ged)?|way|arm(?:ed)?|legs?)(?: [\w-]+){0,3}? (?:intersection|junction)|"
    r"\b(?:intersection|junction) (?:with|of|has|had|having) 3 (?:legs|approaches|arms)|"
    r"\by[- ](?:intersection|junction)|\b(?:ends|ended|terminates|terminated|dead[- ]ends?) (?:in|at|into) (?:an? |"
    r"the )?(?:\"?t\"?\b|[\w-]+ (?:road|street|roadway|highway|avenue|route|arterial|boulevard|thoroughfare)|"
    r"(?:route|highway) \d+|intersection)|"
    r"\b(?:intersection|junction)[^.;]{0,30}\b(?:forms?|forming|formed|in the shape of) (?:an? |the )?\"?t\"?\b"
)
_CROSS = re.compile(
    r"\b(?:intersections?|junction|crossroads?|intersecting (?:road|roadway|street|highway)|cross-? ?streets?|"
    r"roundabout|traffic circle|4[- ]way stop|all[- ]way stop|crossing street)\b"
)
_ELSEWHERE = re.compile(
    r"\b(?:(?:just |approximately |about |immediately )?(?:north|south|east|west|prior|short|away|downstream|"
    r"upstream|past|beyond|before|feet|meters|miles?|yards) (?:of|from|to|the|off|reaching|"
    r"an?)\b[^.;,]{0,30}?\b(?:intersection|junction)|non-?[- ]?(?:intersection|junction)|"
    r"no (?:intersection|junction)s?|not (?:at|in|near) an? (?:intersection|junction)|"
    r"(?:next|previous|nearest|adjacent|another|upcoming) (?:\w+ )?(?:intersection|junction))"
)
_AT_JUNCTION = re.compile(
    r"\b(?:enter\w*|in|into|at|approach\w*|through|cross\w*|within|of|near|stopped|controlled|reach\w*|"
    r"middle of)\b[^.;]{0,50}\b(?:intersection|junction|crossroads?|roundabout|intersecting)\b|"
    r"\bintersection\b[^.;]{0,40}\b(?:was|is|controlled|of)\b"
)
_CURVE = re.compile(
    r"\bcurv(?:e|es|ed|ing|ature|y)\b|\bbend\b|\bbends\b|\bwinding\b|\bbent\b|\bswitchback\b|\bs-curve\b|"
    r"\bhairpin\b|\bcloverleaf\b|\bveers to the\b|\bturning (?:roadway|road)\b"
)
_NO_CURVE = re.compile(
    r"\b(?:no|not|without|after|past|beyond|following|prior to|before) (?:an? |the |any )?(?:\w+ )?curv\w+|"
    r"\bstraight(?:ened)? (?:out )?after|\bcurve warning signs?\b|\bcurv\w+ (?:further|farther|later)\b"
)
_NEGOTIATING = re.compile(
    r"\b(?:negotiat\w*|exit\w*|enter\w*|in|on|through|around|round\w*|driv\w+|travel\w*|maintain\w*|complet\w*|"
    r"failed)\b[^.;]{0,35}\b(?:curv\w+|bend)\b"
)
_AFTERMATH = re.compile(
    r"\b(?:came|coming|come) to (?:a )?(?:final )?rest|\bfinal rest\b|\bfacing\b[^.;]{0,20}\bat (?:final )?rest|"
    r"\badjacent (?:intersection|roadway)"
)
_ROAD = re.compile(
    r"\b(?:road|roadway|trafficway|highway|street|freeway|interstate|lane|lanes|avenue|boulevard|thoroughfare|"
    r"expressway|parkway|turnpike)\b"
)
_STRAIGHT = re.compile(r"\bstraight\b(?! (?:through|ahead|across|truck|out|on|line|at)|-)")
_PEOPLE = re.compile(r"\b(?:airbag|belt|hospital|trauma|injur\w+|spine|rail-mounted|seat)\b")

_STEM = re.compile(
    r"\b(?:stem|terminating (?:road|leg|street|roadway)|"
    r"(?:side|intersecting|minor|cross|ending|connecting|adjoining) (?:street|road|roadway|leg|"
    r"highway))\b(?:(?!\b(?:arterial|highway|freeway|meets?|v\d)\b)[^.;]){0,40}\b(?:(?:to|on|from|toward|at) the |"
    r"lies |lay |extend\w* |leads? |leads? off to the )(north|south|east|west)(?:ward)?\b(?!\s*(?:and|/|-|to\b))|"
    r"\b(?:road|roadway|street|highway) (?:that |which )?(?:leads?|leading|extends?|extending) (?:off |out )?(?:to the )?"
    r"(north|south|east|west)\b(?!\s*(?:and|/|-|to\b))|"
    r"\b(?:ends|ended|terminates|terminated) (?:in|at|into) [^.;]{0,40}?\bfrom the (north|south|east|west)\b|"
    r"\b(?:to|on|from) the (north|south|east|west)\b(?: side)?[^.;]{0,20}\b(?:is|was|lies|lay) the (?:stem|"
    r"side (?:road|street))|\b(north|south|east|west)(?:ern)? (?:leg|stem) (?:of|is|was|form)"
)
_STEM_CONTROL = re.compile(
    r"\bstop sign\w*\b[^.;]{0,40}\b(north|south|east|west)bound\b|"
    r"\b(north|south|east|west)bound\b[^.;]{0,60}\b(?:controlled by|had|has|with|facing|"
    r"regulated by) (?:an? )?(?:\w+ )?(?:stop|yield)"
)
_HAS_TO_WAIT = re.compile(r"\b(?:stop|yield) sign\b")


def vehicles_on_ramp(clauses: Sequence[Clause]) -> dict[int, str]:
    """The vehicles that come from a ramp to join a road, each with the sentence that says so."""
    found: dict[int, str] = {}
    for clause in clauses:
        text = _NOT_FROM_RAMP.sub(" ", clause.text)
        if len(clause.subjects) == 1 and _ON_RAMP.search(text) and not _AFTERMATH.search(text):
            entered_by_accident = re.search(
                r"\b(?:lost control|rotat|drifted|veer|departed|spun|skid|slid|swerv|steer)", text
            )
            if not entered_by_accident:
                found.setdefault(clause.subjects[0], clause.sentence)
    return found


def read_road_type(
    sentences: Sequence[Sentence], clauses: Sequence[Clause], count: int, turning: Sequence[int]
) -> Finding[RoadType]:
    """The road type.

    Args:
        sentences: of the report.
        clauses: of the report.
        count: of the vehicles in contact.
        turning: numbers of the vehicles that turn.
    """
    on_ramp = vehicles_on_ramp(clauses)
    relevant = [sentence for sentence in sentences if not _AFTERMATH.search(sentence.plain)]
    junction = _junction(relevant, turning)
    # One that merges and nobody else on the road is no merging of two roads' traffic.
    if (
        on_ramp
        and (count > 1 or _through_lane_is_named(relevant))
        and not (junction is not None and junction.confidence > 0.85)
    ):
        return Finding(RoadType.MERGING, 0.9, next(iter(on_ramp.values())), "a vehicle joins from a ramp")
    if junction is not None:
        return junction
    curve = _curve(relevant)
    if curve is not None:
        return curve
    for sentence in sentences:
        if _STRAIGHT.search(sentence.plain) and _ROAD.search(sentence.plain):
            return Finding(RoadType.STRAIGHT, 0.95, sentence.text, "the road is called straight")
    for sentence in sentences:
        if _ROAD.search(sentence.plain) and not _PEOPLE.search(sentence.plain):
            return Finding(RoadType.STRAIGHT, 0.7, sentence.text, "neither a junction nor a curve is mentioned")
    return nothing("the road is not described")


def _through_lane_is_named(sentences: Sequence[Sentence]) -> bool:
    return any(re.search(r"\bmerging (?:area|section|road)", sentence.plain) for sentence in sentences)


def _junction(sentences: Sequence[Sentence], turning: Sequence[int]) -> Finding[RoadType] | None:
    for sentence in sentences:
        plain = _ELSEWHERE.sub(" ", sentence.plain)
        match = _T.search(plain)
        if match and not _is_elsewhere(sentence.plain, match[0]):
            return Finding(RoadType.T_INTERSECTION, 0.95, sentence.text, f"the words '{match[0].strip()}'")
    for sentence in sentences:
        plain = _ELSEWHERE.sub(" ", sentence.plain)
        match = _CROSS.search(plain)
        if (
            match
            and not _is_elsewhere(sentence.plain, match[0])
            and (_AT_JUNCTION.search(plain) or re.search(r"\b(?:leg|way)\w* intersection\b", plain))
        ):
            return Finding(RoadType.INTERSECTION, 0.9, sentence.text, "an intersection is the place")
    for sentence in sentences:
        if turning and re.search(
            r"\b(?:cross[- ]street|traffic (?:control )?(?:signal|light)|stop sign|red light|green light)\b",
            sentence.plain,
        ):
            return Finding(RoadType.INTERSECTION, 0.7, sentence.text, "a turn where traffic is controlled")
    return None


def _is_elsewhere(plain: str, words: str) -> bool:
    """Whether a T-intersection is only a landmark: 'a three-leg intersection just south of the point of impact'."""
    tail = plain[plain.find(words) + len(words) :] if words in plain else ""
    return bool(
        re.match(
            r"[^.;]{0,50}?\b(?:north|south|east|west|feet|meters|beyond|past|short) (?:of|"
            r"from) the (?:\w+ )?(?:point|impact|crash|collision|scene)",
            tail,
        )
    )


def _curve(sentences: Sequence[Sentence]) -> Finding[RoadType] | None:
    for sentence in sentences:
        if _PEOPLE.search(sentence.plain) and "curtain" in sentence.plain:
            continue
        plain = _NO_CURVE.sub(" ", sentence.plain)
        if _CURVE.search(plain):
            sure = bool(_NEGOTIATING.search(plain))
            return Finding(RoadType.CURVE, 0.9 if sure else 0.8, sentence.text, "the road is curved there")
    return None


def read_stem(
    sentences: Sequence[Sentence],
    clauses: Sequence[Clause],
    headings: Mapping[int, Position | None],
    turns: Mapping[int, Side | None],
) -> Finding[Compass]:
    """Where the stem of a T-intersection lies.

    Args:
        sentences: of the report.
        clauses: of the report.
        headings: of the vehicles, where known.
        turns: the sides to which they turn, None for straight on or unknown.
    """
    for sentence in sentences:
        match = _STEM.search(sentence.plain)
        if match:
            return Finding(
                TOWARDS[BOUND[next(filter(None, match.groups()))]], 0.9, sentence.text, "the report says where it lies"
            )
    for sentence in sentences:
        match = _STEM_CONTROL.search(sentence.plain)
        ways = set(re.findall(r"\b(north|south|east|west)bound\b", sentence.plain))
        if match and len(ways) == 1 and not re.search(r"\b(?:all|both|no stop)\b", sentence.plain):
            compass = next(filter(None, match.groups()))
            return Finding(
                origin_of(BOUND[compass]), 0.8, sentence.text, f"traffic that comes {compass}bound has to stop"
            )
    straight = {number for number, heading in headings.items() if heading is not None and turns.get(number) is None}
    for number, side in turns.items():
        heading = headings.get(number)
        if side is None or heading is None:
            continue
        across = [other for other in straight if (headings[other] in NORTH_SOUTH) != (heading in NORTH_SOUTH)]
        along = [other for other in straight if other not in across]
        if across:
            return Finding(origin_of(heading), 0.75, None, f"v{number} turns, and v{across[0]} goes on across its way")
        if along:
            return Finding(
                TOWARDS[turned(heading, side)], 0.7, None, f"v{number} turns off the road on which v{along[0]} goes on"
            )
        return Finding(origin_of(heading), 0.4, None, f"v{number} turns there")
    for clause in clauses:
        if len(clause.subjects) == 1 and _HAS_TO_WAIT.search(clause.text):
            heading = headings.get(clause.subjects[0])
            if heading is not None:
                return Finding(origin_of(heading), 0.7, clause.sentence, f"v{clause.subjects[0]} has to stop there")
    return nothing("the report does not say where the road that ends there lies")
