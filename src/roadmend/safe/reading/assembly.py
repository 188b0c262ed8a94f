"""From claims to a scenario: the scene that the solver finds, in the scenario language, with what each field rests on."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

from roadmend.safe.claims import AnyClaim, Claim, ContactClaim, DirectionClaim
from roadmend.safe.compass import TOWARDS, turned
from roadmend.safe.dsl import (
    ON_THE_ROADWAY,
    Action,
    Compass,
    CrashScenario,
    DescribedCollision,
    DescribedEnvironment,
    DescribedImpact,
    DescribedRoadNetwork,
    DescribedVehicle,
    Manoeuvre,
    Position,
    RoadType,
    Side,
    Time,
    Weather,
)
from roadmend.safe.reading.contacts import joined
from roadmend.safe.reading.facts import AXES, claim, of_vehicle
from roadmend.safe.reading.impacts import ROADSIDE, STRUCK, STRUCK_WITH
from roadmend.safe.reading.limits import PostedLimit
from roadmend.safe.reading.scene import solve
from roadmend.safe.reading.tokens import Sentence
from roadmend.safe.reading.weighing import NO_VALUE, JudgedField, judge

_LEAST_WAY = 0.3  # probability below which a direction is left open; four of them are a quarter each
_LEAST_TOLD = 0.42  # that of what the text has to tell
_LEAST = 0.5  # probability of a manoeuvre that is more than driving on
_NAMED = 0.6  # confidence of weather that is told rather than hinted at
_BRIGHT = {Weather.CLEAR, Weather.SUNNY}
_WORST_FIRST = (
    *(Weather.SNOWY, Weather.RAINY, Weather.FOGGY, Weather.WINDY, Weather.OVERCAST, Weather.CLOUDY),
    *(Weather.SUNNY, Weather.CLEAR),
)
_IMPACT = ("object", "striking_side", "roadside")
_VEHICLE = ("model", "initial_position", "action", "speed_limit_mph", "manoeuvre")


@dataclass(frozen=True, slots=True)
class ReportReading:
    """What was read.

    Attributes:
        scenario: the report's, in the scenario language.
        findings: by field, as the JSON form calls it ("vehicles[0].model").
        left_out: places in the cast of vehicles that touched nothing.
    """

    scenario: CrashScenario
    findings: Mapping[str, JudgedField]
    left_out: tuple[int, ...]


def put_together(
    claims: Sequence[AnyClaim],
    limits: Sequence[PostedLimit],
    sentences: Sequence[Sentence],
    kept: Sequence[int],
    count: int,
    *,
    solver: bool = True,
) -> ReportReading:
    """Solve for the scene, and put the scenario together.

    Args:
        claims: of summary and sketch.
        limits: posted ones that the summary names.
        sentences: of the summary.
        kept: places in the cast of the vehicles that took part.
        count: vehicles in the cast.
        solver: let fields decide about each other.
    """
    left_out = tuple(place for place in range(count) if place not in kept)
    claims = [_on_ramp(each) for each in claims if not _speaks_of(each, left_out)]
    judged = solve(claims, count, together=solver)
    road_type = judged["road_type"]
    findings = {"road_type": road_type, "num_lanes": judged.get("num_lanes", NO_VALUE)}
    stem = judged["stem_direction"]
    is_tee = road_type.value is RoadType.T_INTERSECTION and stem.confidence > _LEAST_WAY
    findings["stem_direction"] = stem if is_tee else NO_VALUE
    vehicles = []
    for index, place in enumerate(kept):
        fields = _vehicle(judged, place, merging=road_type.value is RoadType.MERGING)
        ways = judged[of_vehicle(place, "initial_position")]
        heading = ways.value if ways.confidence >= _LEAST_WAY else None
        fields["speed_limit_mph"] = _limit(fields["speed_limit_mph"], limits, sentences, place, heading)
        findings |= {f"vehicles[{index}].{name}": fields[name] for name in _VEHICLE}
        vehicles.append(DescribedVehicle(*(fields[name].value for name in _VEHICLE)))
    time = judged.get("env.time", NO_VALUE)
    weather = _weather([each for each in claims if isinstance(each, Claim) and each.path == "env.weather"], time.value)
    findings |= {"env.time": time, "env.weather": weather}
    for name in ("is_divided", "bend", "control"):
        found = judged.get(name, NO_VALUE)
        if found.confidence > _LEAST_TOLD and (name != "bend" or road_type.value is RoadType.CURVE):
            findings[name] = found
    names = ("road_type", "num_lanes", "stem_direction", "is_divided", "bend", "control")
    road = DescribedRoadNetwork(*(findings.get(name, NO_VALUE).value for name in names))
    collisions = tuple(_collisions(claims, {place: index for index, place in enumerate(kept, start=1)}))
    environment = DescribedEnvironment(time.value, weather.value)
    impacts: tuple[DescribedImpact, ...] = ()
    if len(kept) == 1:  # where several vehicles touched, that is the crash
        fields = dict(_impact(judged, kept[0], vehicles[0].initial_position))
        if fields:
            findings |= {f"impacts[0].{name}": field for name, field in fields.items()}
            impacts = (DescribedImpact(1, *(fields.get(name, NO_VALUE).value for name in _IMPACT)),)
    return ReportReading(CrashScenario(road, tuple(vehicles), environment, collisions, impacts), findings, left_out)


def _on_ramp(each: AnyClaim) -> AnyClaim:
    """Where roads merge, the language has no direction but a road: to the solver that is a field of its own."""
    if isinstance(each, Claim) and each.value in {Position.ON_RAMP, Position.MAIN_ROAD}:
        path = each.path.replace("initial_position", "on_ramp")
        return replace(each, path=path, value=each.value is Position.ON_RAMP)
    return each


def _speaks_of(each: AnyClaim, places: Sequence[int]) -> bool:
    if isinstance(each, Claim):
        return any(each.path.startswith(f"vehicles[{place}].") for place in places)
    pair = (each.first, each.second) if isinstance(each, DirectionClaim) else (each.striking, each.struck)
    return bool({*pair} & {*places})


def _vehicle(judged: Mapping[str, JudgedField], place: int, *, merging: bool) -> dict[str, JudgedField]:
    fields = {name: judged.get(of_vehicle(place, name), NO_VALUE) for name in _VEHICLE}
    heading, action, manoeuvre = fields["initial_position"], fields["action"], fields["manoeuvre"]
    if merging:
        ramp = judged.get(of_vehicle(place, "on_ramp"), NO_VALUE)
        is_ramp = bool(ramp.value) and ramp.confidence > _LEAST
        on_main = JudgedField(Position.MAIN_ROAD, 0.85, heading.claims)
        fields["initial_position"] = replace(ramp, value=Position.ON_RAMP) if is_ramp else on_main
    elif heading.confidence < _LEAST_WAY:
        fields["initial_position"] = replace(heading, value=None)
    if action.value is not Action.MOVE_FORWARD:
        turn = Manoeuvre.U_TURN if manoeuvre.value is Manoeuvre.U_TURN else Manoeuvre(action.value)
        fields["manoeuvre"] = JudgedField(turn, action.confidence, action.claims)
    elif manoeuvre.confidence < _LEAST:
        fields["manoeuvre"] = JudgedField(Manoeuvre.MOVE_FORWARD, action.confidence, action.claims)
    return fields


def _impact(
    judged: Mapping[str, JudgedField], place: int, heading: Position | None
) -> Iterator[tuple[str, JudgedField]]:
    """The fields of a vehicle's first impact with what is none."""
    struck = judged.get(of_vehicle(place, STRUCK), NO_VALUE)
    if struck.value is None:
        return
    yield "object", struck
    if of_vehicle(place, STRUCK_WITH) in judged:
        yield "striking_side", judged[of_vehicle(place, STRUCK_WITH)]
    roadside = judged.get(of_vehicle(place, ROADSIDE), NO_VALUE)
    if isinstance(roadside.value, Compass):  # "the west edge" of a road is on the right of who goes south
        sides = {TOWARDS[turned(heading, side)]: side for side in (Side.LEFT, Side.RIGHT)} if heading in TOWARDS else {}
        roadside = replace(roadside, value=sides.get(roadside.value))
    if roadside.value is not None and struck.value not in ON_THE_ROADWAY:
        yield "roadside", roadside


def _limit(
    known: JudgedField,
    limits: Sequence[PostedLimit],
    sentences: Sequence[Sentence],
    place: int,
    heading: Position | None,
) -> JudgedField:
    """The limit for one vehicle: what is posted for it, for its way, for the road of so many lanes, or for all."""
    claims = [*known.claims, *known.against]
    one = len({limit.mph for limit in limits}) == 1
    for limit in limits:
        if limit.vehicles or limit.names or not (limit.ways or limit.lanes):
            continue
        ways = limit.ways or _ways_of_lanes(sentences, limit.lanes)
        sure = 0.7 if one else 0.4
        if heading is not None and ways:
            on_axis = any(heading in axis and ways & axis for axis in AXES.values())
            elsewhere = (0.9 if on_axis else 0.45) if one else 0.1
            sure = 0.93 if heading in ways else elsewhere if limit.ways or not one else sure
        path = of_vehicle(place, "speed_limit_mph")
        claims.append(claim(path, limit.mph, sure, "the limit posted for its way", limit.span))
    found = judge(claims)
    return found if found.confidence > _LEAST_TOLD else replace(found, value=None)


def _ways_of_lanes(sentences: Sequence[Sentence], lanes: int | None) -> frozenset[Position]:
    """The axis of the road that is called by its number of lanes: "the two-lane roadway (east and westbound lanes)"."""
    for sentence in sentences:
        for place, item in enumerate(sentence.items):
            if item.get("number") == lanes and sentence.items.at(place + 1).low == "lane":
                found = sentence.items.cut(place + 2, place + 8).first("axis", "number")
                if found is not None and found.is_a("axis"):
                    return AXES[found.get("axis")]
    return frozenset()


def _weather(claims: Sequence[Claim], time: Time | None) -> JudgedField:
    """One word for the weather: falling water comes before clouds, and a clear sky is sunny by day."""
    found = judge(claims)
    named = {each.value for each in claims if each.confidence > _NAMED}
    value = next((each for each in _WORST_FIRST if each in named), found.value)
    if value in _BRIGHT and time is not None:
        value = Weather.SUNNY if time is Time.DAYTIME else Weather.CLEAR
    same = [each for each in claims if each.value is value or {each.value, value} <= _BRIGHT]
    if not same:
        return found
    best = sorted(same, key=lambda each: -each.confidence)
    against = tuple(each for each in claims if each not in same)
    return JudgedField(value, best[0].confidence, tuple(best), None, against)


def _collisions(claims: Sequence[AnyClaim], numbers: Mapping[int, int]) -> Iterator[DescribedCollision]:
    """The contacts, each pair once: two sources complete each other."""
    pairs: dict[frozenset[int], ContactClaim] = {}
    for each in claims:
        if isinstance(each, ContactClaim):
            pair = frozenset({each.striking, each.struck})
            pairs[pair] = joined(pairs[pair], each) if pair in pairs else each
    for each in sorted(pairs.values(), key=lambda contact: contact.order):
        sides = (each.striking_side, each.struck_side)
        yield DescribedCollision(numbers[each.striking], numbers[each.struck], *sides)
