"""The embedded reader: one summary in, a scenario out, with what every field rests on.

Text, sentences, clauses, claims, and one scene that satisfies them: see ``tokens``, ``mentions``, ``clauses``, the modules
that make claims (``ways``, ``manoeuvres``, ``contacts``, ``roads``, ``lanes``, ``limits``, ``surroundings``), and ``scene``.
"""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

from roadmend.safe.claims import AnyClaim, CastMember, Claim, ContactClaim, DirectionClaim
from roadmend.safe.dsl import (
    Action,
    CrashScenario,
    DescribedCollision,
    DescribedEnvironment,
    DescribedRoadNetwork,
    DescribedVehicle,
    Manoeuvre,
    Position,
    RoadType,
    Time,
    Weather,
)
from roadmend.safe.reading.clauses import STRIKES, read_clauses
from roadmend.safe.reading.contacts import read_contacts
from roadmend.safe.reading.facts import AXES, Text, claim, of_vehicle
from roadmend.safe.reading.lanes import read_lanes
from roadmend.safe.reading.lexicon import word_set
from roadmend.safe.reading.limits import PostedLimit, claim_limits, read_limits
from roadmend.safe.reading.manoeuvres import read_manoeuvres
from roadmend.safe.reading.mentions import find_mentions
from roadmend.safe.reading.roads import read_roads
from roadmend.safe.reading.scene import Judged, judge, solve
from roadmend.safe.reading.surroundings import read_surroundings
from roadmend.safe.reading.tokens import read_sentences
from roadmend.safe.reading.ways import read_ways

_LEAST_WAY = 0.42  # probability below which a direction is left open; four of them are a quarter each
_LEAST = 0.5  # probability of a manoeuvre that is more than driving on
_NO_VALUE = Judged(None, 0.0, (), None, ())


@dataclass(frozen=True, slots=True)
class SummaryClaims:
    """What a summary says.

    Attributes:
        text: taken apart.
        cast: its vehicles.
        claims: all that it says of them and their road.
        contacts: those of the claims that tell of a contact.
        limits: posted ones.
        left_out: places in the cast of vehicles that touched nothing.
        others: who else was struck: "pedestrian", "animal".
    """

    text: Text
    cast: tuple[CastMember, ...]
    claims: tuple[AnyClaim, ...]
    contacts: tuple[ContactClaim, ...]
    limits: tuple[PostedLimit, ...]
    left_out: tuple[int, ...]
    others: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class ReportReading:
    """What was read.

    Attributes:
        scenario: the report's, in the scenario language.
        findings: by field, as the JSON form calls it ("vehicles[0].model").
        left_out: numbers of vehicles that touched nothing.
    """

    scenario: CrashScenario
    findings: Mapping[str, Judged]
    left_out: tuple[int, ...]


def read_summary(summary: str, more: Sequence[AnyClaim] = ()) -> ReportReading | None:
    """Read a summary; None where it speaks of no vehicle.

    Args:
        summary: the text.
        more: claims of another source, the sketch, about the same cast (see :func:`read_claims`).
    """
    said = read_claims(summary)
    return None if said is None else assemble(said, more)


def read_claims(summary: str) -> SummaryClaims | None:
    """What a summary says, before anything is decided; None where it speaks of no vehicle."""
    # NMVCCS closes with the investigators' codes, which speak of vehicles in general ("other vehicle stopped").
    sentences = tuple(
        sentence
        for sentence in read_sentences(summary)
        if not any(code in summary[sentence.span.start : sentence.span.end].lower() for code in word_set("codes"))
    )
    spoken = find_mentions(sentences)
    if not spoken.roll.vehicles:
        return None
    text = Text(summary, sentences, spoken, read_clauses(sentences, spoken))
    contacts = read_contacts(text)
    limits = read_limits(text)
    claims: list[AnyClaim] = [*_models(text), *read_ways(text), *read_manoeuvres(text), *contacts, *read_roads(text)]
    claims += [*read_lanes(text), *claim_limits(text, limits), *read_surroundings(text)]
    cast = tuple(
        CastMember(
            vehicle.description.number or vehicle.place + 1,
            tuple(
                sorted(
                    {*(word for word in vehicle.words if word), *_numbered(vehicle.description.number)},
                    key=lambda word: (-len(word), word),
                )
            ),
            vehicle.description.body()[0],
        )
        for vehicle in spoken.roll.vehicles
    )
    return SummaryClaims(text, cast, tuple(claims), contacts, limits, _outside(text, contacts), _others(text))


def _numbered(number: int | None) -> tuple[str, ...]:
    return () if number is None else (f"vehicle {number}", f"v{number}")


def _models(text: Text) -> Iterator[Claim]:
    for vehicle in text.spoken.roll.vehicles:
        body, confidence, span = vehicle.description.body()
        if body is not None:
            yield claim(
                of_vehicle(vehicle.place, "model"), body, confidence, f"it is called {vehicle.description.words}", span
            )


def _others(text: Text) -> tuple[str, ...]:
    """Who was struck and is no vehicle."""
    found = {
        item.kinds["walker"]
        for clause in text.clauses
        if clause.is_real and clause.kind in STRIKES | {"collide"}
        for item in (*clause.head, *clause.tail[:5])
        if item.is_a("walker")
    }
    return tuple(sorted(found))


def _outside(text: Text, contacts: Sequence[ContactClaim]) -> tuple[int, ...]:
    """Vehicles that the text speaks of, and that touched no other."""
    touched = {place for each in contacts for place in (each.striking, each.struck)}
    vehicles = text.spoken.roll.vehicles
    numbered = {vehicle.place for vehicle in vehicles if vehicle.description.number is not None}
    keep = numbered | touched or {vehicle.place for vehicle in vehicles[:2]}
    for clause in text.clauses:
        who = clause.subject.vehicles
        if len(who) == 1 and who[0] not in touched and clause.words.has("outside"):
            keep.discard(who[0])
    keep = keep or {0}
    return tuple(vehicle.place for vehicle in vehicles if vehicle.place not in keep)


def assemble(said: SummaryClaims, more: Sequence[AnyClaim] = ()) -> ReportReading:
    """Solve for the scene, and put the scenario together.

    Args:
        said: by the summary.
        more: claims of another source about the same cast.
    """
    count = len(said.cast)
    kept = [place for place in range(count) if place not in said.left_out]
    claims = [*said.claims, *(_on_ramp(each) for each in more)]
    claims = [each for each in claims if not _speaks_of(each, said.left_out)]
    judged = dict(solve(claims, count))
    road_type = judged["road_type"]
    merging = road_type.value is RoadType.MERGING
    findings: dict[str, Judged] = {"road_type": road_type, "num_lanes": judged.get("num_lanes", _NO_VALUE)}
    stem = judged.get("stem_direction", _NO_VALUE)
    findings["stem_direction"] = (
        stem if road_type.value is RoadType.T_INTERSECTION and stem.confidence > _LEAST_WAY else _NO_VALUE
    )
    vehicles = []
    for index, place in enumerate(kept):
        fields = _vehicle(judged, said, place, merging=merging)
        findings |= {f"vehicles[{index}].{name}": found for name, found in fields.items()}
        vehicles.append(
            DescribedVehicle(
                *(
                    fields[name].value
                    for name in ("model", "initial_position", "action", "speed_limit_mph", "manoeuvre")
                )
            )
        )
    time = judge([each for each in claims if isinstance(each, Claim) and each.path == "env.time"])
    weather = _weather([each for each in claims if isinstance(each, Claim) and each.path == "env.weather"], time.value)
    findings |= {"env.time": time, "env.weather": weather}
    for name in ("is_divided", "bend", "control"):
        found = judged.get(name)
        if (
            found is not None
            and found.confidence > _LEAST_WAY
            and (name != "bend" or road_type.value is RoadType.CURVE)
        ):
            findings[name] = found
    road = DescribedRoadNetwork(
        road_type.value,
        findings["num_lanes"].value,
        findings["stem_direction"].value,
        *(findings.get(name, _NO_VALUE).value for name in ("is_divided", "bend", "control")),
    )
    numbers = {place: index for index, place in enumerate(kept, start=1)}
    contacts = [each for each in claims if isinstance(each, ContactClaim)]
    scenario = CrashScenario(
        road, tuple(vehicles), DescribedEnvironment(time.value, weather.value), tuple(_collisions(contacts, numbers))
    )
    return ReportReading(scenario, findings, tuple(said.cast[place].number for place in said.left_out))


def _on_ramp(each: AnyClaim) -> AnyClaim:
    """Where roads merge, the language has no direction but a road: to the solver that is a field of its own."""
    if isinstance(each, Claim) and each.value in {Position.ON_RAMP, Position.MAIN_ROAD}:
        return replace(
            each, path=each.path.replace("initial_position", "on_ramp"), value=each.value is Position.ON_RAMP
        )
    return each


def _speaks_of(each: AnyClaim, places: Sequence[int]) -> bool:
    if isinstance(each, Claim):
        return any(each.path.startswith(f"vehicles[{place}].") for place in places)
    pair = (each.first, each.second) if isinstance(each, DirectionClaim) else (each.striking, each.struck)
    return bool({*pair} & {*places})


def _vehicle(judged: Mapping[str, Judged], said: SummaryClaims, place: int, *, merging: bool) -> dict[str, Judged]:
    def of(field: str) -> Judged:
        return judged.get(of_vehicle(place, field), _NO_VALUE)

    heading = of("initial_position")
    heading = heading if heading.confidence >= _LEAST_WAY else replace(heading, value=None)
    position = heading
    if merging:
        ramp = of("on_ramp")
        is_ramp = bool(ramp.value) and ramp.confidence > 0.5
        position = (
            replace(ramp, value=Position.ON_RAMP)
            if is_ramp
            else Judged(Position.MAIN_ROAD, 0.85, heading.claims, None, ())
        )
    action, manoeuvre = of("action"), of("manoeuvre")
    if action.value is not Action.MOVE_FORWARD:
        manoeuvre = Judged(
            Manoeuvre.U_TURN if manoeuvre.value is Manoeuvre.U_TURN else Manoeuvre(action.value),
            action.confidence,
            action.claims,
            None,
            (),
        )
    elif manoeuvre.value is None or manoeuvre.confidence < _LEAST:
        manoeuvre = Judged(Manoeuvre.MOVE_FORWARD, action.confidence, action.claims, None, ())
    return {
        "model": of("model"),
        "initial_position": position,
        "action": action,
        "speed_limit_mph": _limit(said, of("speed_limit_mph"), place, heading.value),
        "manoeuvre": manoeuvre,
    }


def _limit(said: SummaryClaims, known: Judged, place: int, heading: Position | None) -> Judged:
    """The limit for one vehicle: what is posted for it, for its way, for the road of so many lanes, or for all."""
    claims: list[Claim] = [*known.claims, *known.against]
    values = {limit.mph for limit in said.limits}
    for limit in said.limits:
        if limit.vehicles or not (limit.ways or limit.lanes) or limit.names:
            continue
        confidence = 0.7 if len(values) == 1 else 0.4
        if limit.ways:
            confidence = (
                confidence
                if heading is None
                else 0.93
                if heading in limit.ways
                else 0.9
                if len(values) == 1 and _same_axis(heading, limit.ways)
                else 0.45
                if len(values) == 1
                else 0.1
            )
        elif limit.lanes and heading is not None:
            ways = _ways_of_lanes(said, limit.lanes)
            confidence = 0.9 if ways and heading in ways else 0.15 if ways and len(values) > 1 else confidence
        claims.append(
            claim(
                of_vehicle(place, "speed_limit_mph"), limit.mph, confidence, "the limit posted for its way", limit.span
            )
        )
    found = judge(claims)
    return found if found.confidence > _LEAST_WAY else replace(found, value=None)


def _same_axis(heading: Position, ways: Iterable[Position]) -> bool:
    return any(heading in axis and way in axis for axis in AXES.values() for way in ways)


def _ways_of_lanes(said: SummaryClaims, lanes: int) -> frozenset[Position]:
    """The axis of the road that is called by its number of lanes: "the two-lane roadway (east and westbound lanes)"."""
    for sentence in said.text.sentences:
        items = sentence.items
        for place in range(len(items) - 1):
            if (
                items[place].kinds.get("number") == lanes
                and items[place + 1].is_a("lane")
                and items[place + 1].low == "lane"
            ):
                for item in items[place + 2 : place + 8]:
                    if item.is_a("axis"):
                        return AXES[item.kinds["axis"]]
                    if item.is_a("number"):
                        break
    return frozenset()


def _weather(claims: Sequence[Claim], time: Time | None) -> Judged:
    """One word for the weather: falling water comes before clouds, and a clear sky is sunny by day."""
    rank = [
        Weather.SNOWY,
        Weather.RAINY,
        Weather.FOGGY,
        Weather.WINDY,
        Weather.OVERCAST,
        Weather.CLOUDY,
        Weather.SUNNY,
        Weather.CLEAR,
    ]
    found = judge(
        [replace(each, confidence=min(0.99, each.confidence * (1 - 0.02 * rank.index(each.value)))) for each in claims]
    )
    if found.value is None:
        return found
    named = {each.value for each in claims if each.confidence > 0.6}
    value = next((each for each in rank if each in named), found.value)
    bright = {Weather.CLEAR, Weather.SUNNY}
    if value in bright and time is not None:
        value = Weather.SUNNY if time is Time.DAYTIME else Weather.CLEAR
    same = bright if value in bright else {value}
    sure = max((each.confidence for each in claims if each.value in same), default=found.confidence)
    return replace(found, value=value, confidence=sure, claims=found.claims or tuple(claims))


def _collisions(contacts: Sequence[ContactClaim], numbers: Mapping[int, int]) -> Iterator[DescribedCollision]:
    for each in sorted(contacts, key=lambda contact: contact.order):
        if each.striking in numbers and each.struck in numbers:
            yield DescribedCollision(numbers[each.striking], numbers[each.struck], each.striking_side, each.struck_side)
