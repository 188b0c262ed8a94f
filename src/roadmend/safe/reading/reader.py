"""The embedded reader: one summary in, a scenario out, with what every field rests on."""

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

from roadmend.safe.dsl import (
    Action,
    CrashScenario,
    DescribedCollision,
    DescribedEnvironment,
    DescribedRoadNetwork,
    DescribedVehicle,
    DslModel,
    Position,
    RoadType,
    Side,
)
from roadmend.safe.reading.clauses import cut_clauses
from roadmend.safe.reading.contacts import ContactStatement, cross_headings, read_contacts
from roadmend.safe.reading.directions import heading_of_the_place, read_headings, relate_headings
from roadmend.safe.reading.environment import read_time, read_weather
from roadmend.safe.reading.lanes import read_lanes
from roadmend.safe.reading.mentions import Cast, find_cast
from roadmend.safe.reading.road_type import read_road_type, read_stem, vehicles_on_ramp
from roadmend.safe.reading.speed_limits import limit_for, read_limits
from roadmend.safe.reading.text import Finding, nothing, read_sentences
from roadmend.safe.reading.turns import park_headings, read_manoeuvres, read_turns

# NMVCCS closes with the investigators' codes, which speak of vehicles in general ("other vehicle stopped").
_CODES = re.compile(
    r"\bcritical (?:pre-? ?crash )?(?:event|reason)|\bcritical reason\b|\bwas coded\b|\bassociated factors?\b"
)


@dataclass(frozen=True, slots=True)
class ReportReading:
    """What was read.

    Attributes:
        scenario: the report's, in the scenario language.
        findings: by field, as the JSON form calls it ("vehicles[0].model").
        left_out: numbers of vehicles that touched nothing.
    """

    scenario: CrashScenario
    findings: Mapping[str, Finding[Any]]
    left_out: tuple[int, ...]


def read_summary(summary: str) -> ReportReading | None:
    """Read a summary; None where it speaks of no vehicle."""
    sentences = tuple(sentence for sentence in read_sentences(summary) if not _CODES.search(sentence.plain))
    cast = find_cast(sentences)
    if not cast.vehicles:
        return None
    return _assemble(cast)


def _assemble(cast: Cast) -> ReportReading:
    sentences, numbers = cast.sentences, [described.number for described in cast.vehicles]
    clauses = cut_clauses(sentences, numbers)
    contacts = read_contacts(clauses, numbers)
    turns = read_turns(clauses, numbers)
    sides = {number: finding.value for number, finding in turns.items()}
    stated = read_headings(clauses, numbers)
    headings = relate_headings(stated, clauses, sides, [(each.striking, each.struck, each.sides) for each in contacts])
    road_type = read_road_type(sentences, clauses, len(numbers), [number for number in numbers if sides[number]])
    is_t, merging = road_type.value is RoadType.T_INTERSECTION, road_type.value is RoadType.MERGING
    at_junction = is_t or road_type.value is RoadType.INTERSECTION
    if at_junction and contacts:
        headings = cross_headings(headings, sides, contacts[0])
    else:
        headings = park_headings(headings, clauses)
    place = heading_of_the_place(clauses)
    headings = {number: finding if finding.value is not None else place for number, finding in headings.items()}
    manoeuvres = read_manoeuvres(clauses, turns, headings)

    lanes = read_lanes(sentences, merging=merging)
    known = {number: finding.value for number, finding in headings.items()}
    stem = read_stem(sentences, clauses, known, sides) if is_t else nothing("only a T-intersection has a stem")
    time, sun_is_up = read_time(sentences)
    weather = read_weather(sentences, time.value, sun_is_up=sun_is_up)
    limits = read_limits(sentences)
    if merging:  # the limit of the main road is what those who join it go for
        limits = tuple(replace(limit, axes=frozenset()) for limit in limits)

    findings: dict[str, Finding[Any]] = {"road_type": road_type, "num_lanes": lanes, "stem_direction": stem}
    vehicles = []
    on_ramp = vehicles_on_ramp(clauses)
    for index, described in enumerate(cast.vehicles):
        number = described.number
        body = described.body
        model: Finding[DslModel] = (
            nothing("the report does not say what kind of vehicle it is")
            if body is None
            else Finding(body.model, body.confidence, described.sentence, body.basis)
        )
        position = _on_merging_road(number, on_ramp, headings[number]) if merging else headings[number]
        action = _action(turns[number])
        is_truck = model.value is DslModel.SEMI_TRUCK
        limit = limit_for(number, known[number], limits, at_junction=at_junction, is_truck=is_truck)
        fields = {
            "model": model,
            "initial_position": position,
            "action": action,
            "speed_limit_mph": limit,
            "manoeuvre": manoeuvres[number],
        }
        findings |= {f"vehicles[{index}].{name}": finding for name, finding in fields.items()}
        vehicles.append(
            DescribedVehicle(model.value, position.value, action.value, limit.value, manoeuvres[number].value)
        )
    findings |= {"env.time": time, "env.weather": weather}
    road = DescribedRoadNetwork(road_type.value, lanes.value, stem.value)
    scenario = CrashScenario(
        road, tuple(vehicles), DescribedEnvironment(time.value, weather.value), _collisions(contacts, numbers)
    )
    return ReportReading(scenario, findings, cast.left_out)


def _action(turn: Finding[Side]) -> Finding[Action]:
    if turn.value is None:
        stated = turn.sentence is not None
        return Finding(Action.MOVE_FORWARD, turn.confidence if stated else 0.75, turn.sentence, turn.reason)
    action = Action.TURN_LEFT if turn.value is Side.LEFT else Action.TURN_RIGHT
    return Finding(action, turn.confidence, turn.sentence, turn.reason)


def _on_merging_road(number: int, on_ramp: Mapping[int, str], heading: Finding[Position]) -> Finding[Position]:
    if number in on_ramp:
        return Finding(Position.ON_RAMP, 0.9, on_ramp[number], "it joins from a ramp")
    return Finding(Position.MAIN_ROAD, 0.8, heading.sentence, "it is not the one that joins from a ramp")


def _collisions(contacts: Sequence[ContactStatement], numbers: Sequence[int]) -> tuple[DescribedCollision, ...]:
    place = {number: index for index, number in enumerate(numbers, start=1)}
    return tuple(
        DescribedCollision(place[each.striking], place[each.struck], each.striking_side, each.struck_side)
        for each in contacts
    )
