"""What a sketch says about a crash, for the solver that decides between it and the summary."""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from roadmend.safe.claims import Box, Cast, Claim, ClaimSource
from roadmend.safe.compass import DIRECTIONS, HEADING, NORTH_SOUTH
from roadmend.safe.dsl import DslModel, Position, Time, Weather
from roadmend.safe.sketch.conditions import SketchCondition, conditions
from roadmend.safe.sketch.limits import LimitScope, SketchLimit
from roadmend.safe.sketch.poses import Approach, angle_between
from roadmend.safe.sketch.reading import SketchReading

_OFF_AXIS = 36.0  # [deg] further from each direction of the compass, none is claimed
_SKEWED = 20.0  # [deg] from here on a road may be called by either of two directions
_TRUST_IN_SKEWED = 0.85
_TRUST = ((3.0, 0.9), (1.0, 0.85), (0.4, 0.75))  # confidence in a way, by how much more speaks for it than against it
_WITHOUT_SCOPE = 0.8  # what is left where several vehicles might be meant, and the limit is said to be for some road


@dataclass(frozen=True, slots=True)
class SketchWay:
    """Where a vehicle of a sketch drives, by the compass.

    Attributes:
        position: direction of travel.
        confidence: from 0 to 1.
    """

    position: Position
    confidence: float


def claims_of(reading: SketchReading, cast: Cast) -> tuple[Claim, ...]:
    """The claims of a sketch that was read, about the vehicles of a cast; where is in pixels of the file."""
    ways = {number: way for number, approach in reading.approaches.items() if (way := way_of(reading, approach))}
    claims = [*_limit_claims(reading, cast, ways), *_environment_claims(conditions(reading.words))]
    for place, member in enumerate(cast):
        way = ways.get(member.number)
        if way is not None:
            approach = reading.approaches[member.number]
            claims.append(
                Claim(
                    f"vehicles[{place}].initial_position",
                    way.position,
                    way.confidence,
                    ClaimSource.SKETCH,
                    f"drawn as vehicle {member.number} heading {way.position}: {', '.join(approach.reasons)}",
                    approach.pose.outline.box(),
                )
            )
    return tuple(_in_file(claim, reading.picture.scale) for claim in claims)


def way_of(reading: SketchReading, approach: Approach) -> SketchWay | None:
    """The direction of travel of an approach; None without north, between two directions, or with little support."""
    if reading.north is None:
        return None
    heading = approach.heading - reading.north.heading + 90.0  # counter-clockwise from east
    position = min(DIRECTIONS, key=lambda direction: angle_between(heading, HEADING[direction]))
    off = angle_between(heading, HEADING[position])
    trust = next((value for support, value in _TRUST if approach.support >= support), None)
    if trust is None or off > _OFF_AXIS:
        return None
    confidence = trust * (_TRUST_IN_SKEWED if off > _SKEWED else 1.0)
    # A number and a north that were not read for certain take their part.
    confidence *= math.sqrt(max(0.25, approach.pose.confidence)) * reading.north.confidence**0.25
    return SketchWay(position, min(1.0, confidence))


def _limit_claims(reading: SketchReading, cast: Cast, ways: dict[int, SketchWay]) -> Iterator[Claim]:
    for place, member in enumerate(cast):
        way = ways.get(member.number)
        fitting = [
            (limit, trust) for limit in reading.limits if (trust := _fit(limit, member.number, member.model, way)) > 0
        ]
        special = [(limit, trust) for limit, trust in fitting if limit.scope is not LimitScope.ALL]
        chosen = special or fitting
        if len({limit.mph for limit, _ in chosen}) != 1:  # several for one vehicle, and nothing says which
            continue
        limit, trust = max(chosen, key=lambda pair: pair[0].confidence * pair[1])
        others = {other.mph for other in reading.limits} != {limit.mph}
        if trust < 1.0 and others:
            continue
        yield Claim(
            f"vehicles[{place}].speed_limit_mph",
            limit.mph,
            limit.confidence * trust,
            ClaimSource.SKETCH,
            f"the sketch says {limit.text!r}",
            limit.box,
        )


def _fit(limit: SketchLimit, number: int, model: DslModel | None, way: SketchWay | None) -> float:
    """How far a limit is a vehicle's, from 0 to 1."""
    if limit.scope is LimitScope.VEHICLE:
        return 1.0 if limit.vehicle == number else 0.0
    if limit.scope in {LimitScope.CARS, LimitScope.TRUCKS}:
        if model is None:
            return 0.0
        return 1.0 if (model is DslModel.SEMI_TRUCK) == (limit.scope is LimitScope.TRUCKS) else 0.0
    if limit.scope in {LimitScope.NORTH_SOUTH, LimitScope.EAST_WEST}:
        if way is None:
            return _WITHOUT_SCOPE
        return 1.0 if (way.position in NORTH_SOUTH) == (limit.scope is LimitScope.NORTH_SOUTH) else 0.0
    return 0.0 if limit.scope is LimitScope.RAMP else 1.0


def _environment_claims(found: Sequence[SketchCondition]) -> Iterator[Claim]:
    light = next((condition.value for condition in found if isinstance(condition.value, Time)), None)
    for condition in found:
        value: Time | Weather = condition.value
        if value is Weather.CLEAR and light is Time.DAYTIME:
            value = Weather.SUNNY  # what the scenario language calls a clear sky by day
        path = "env.time" if isinstance(value, Time) else "env.weather"
        reason = f"the sketch says {condition.text!r}"
        yield Claim(path, value, condition.confidence, ClaimSource.SKETCH, reason, condition.box)


def _in_file(claim: Claim, scale: float) -> Claim:
    box = claim.where
    if scale == 1.0 or not isinstance(box, Box):
        return claim
    where = Box(box.left / scale, box.top / scale, box.right / scale, box.bottom / scale)
    return Claim(claim.path, claim.value, claim.confidence, claim.source, claim.reason, where)
