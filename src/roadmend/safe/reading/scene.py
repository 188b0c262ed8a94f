"""The consistency solver: the scene that satisfies the claims best, how sure each of its fields is, and what speaks against.

Every field has a few candidates. A scene takes one for each: a direction and a turn for every vehicle, a type of road, the
stem of a T. Claims give it weight, in log-odds; so do relations and contacts, by the geometry of who can have met whom,
on which side. All scenes are enumerated, vehicle by vehicle with what a contact ties together, and the sums over them
give each value's probability: exact, deterministic, and small, for a crash has few vehicles.
"""

import itertools
import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from roadmend.safe.claims import AnyClaim, Claim, ContactClaim, DirectionClaim, Relation
from roadmend.safe.compass import DIRECTIONS, TOWARDS, opposite, origin_of, turned
from roadmend.safe.dsl import Action, Compass, Manoeuvre, Position, RoadType, Side

_ACTIONS = (Action.MOVE_FORWARD, Action.TURN_LEFT, Action.TURN_RIGHT)
_HAND = {Action.MOVE_FORWARD: None, Action.TURN_LEFT: Side.LEFT, Action.TURN_RIGHT: Side.RIGHT}
_MOST_TOGETHER = 4  # vehicles whose scenes are enumerated together
_STRAIGHT_ON = 1.0  # [nats] vehicles go straight on unless something says otherwise
_AGAIN = 0.25  # how much a second claim of the same source for the same value adds, of its own weight
_MISSING_LEG = 2.5  # [nats] that nobody comes from or goes where a T has no road
_JUNCTIONS = (RoadType.INTERSECTION, RoadType.T_INTERSECTION)
_ROADS = tuple(RoadType)


@dataclass(frozen=True, slots=True)
class Judged:
    """What the solver makes of one field.

    Attributes:
        value: the best; None where no value stands out.
        confidence: its probability.
        claims: those for it, the strongest first.
        second: the next best value, and its probability; None where there is none.
        against: claims for other values.
    """

    value: Any
    confidence: float
    claims: tuple[Claim, ...]
    second: tuple[Any, float] | None
    against: tuple[Claim, ...]


@dataclass(frozen=True, slots=True)
class _Way:
    """How one vehicle goes in a scene."""

    heading: Position
    action: Action

    @property
    def leaves(self) -> Position:
        return turned(self.heading, _HAND[self.action])


def solve(claims: Sequence[AnyClaim], count: int) -> Mapping[str, Judged]:
    """Judge every field of which a claim speaks, and the directions and actions of all vehicles.

    Args:
        claims: of the summary and the sketch.
        count: of vehicles in the cast.
    """
    plain = [each for each in claims if isinstance(each, Claim)]
    found = {
        path: judge([each for each in plain if each.path == path])
        for path in dict.fromkeys(each.path for each in plain)
    }
    found |= _Scene(claims, count).judged()
    return found


def judge(claims: Sequence[Claim], prior: Mapping[Any, float] | None = None) -> Judged:
    """Weigh the claims about one field that depends on no other.

    Args:
        claims: about it.
        prior: weight of values before any claim [nats].
    """
    weights = {**(prior or {})}
    for value, weight in _evidence(claims).items():
        weights[value] = weights.get(value, 0.0) + weight
    if not weights:
        return Judged(None, 0.0, (), None, ())
    rest = math.exp(0.0)  # something that nobody has said
    total = sum(math.exp(weight) for weight in weights.values()) + rest
    ranked = sorted(weights.items(), key=lambda each: -each[1])
    return _judged([(value, math.exp(weight) / total) for value, weight in ranked], claims)


def _judged(ranked: Sequence[tuple[Any, float]], claims: Sequence[Claim]) -> Judged:
    value, confidence = ranked[0]
    mine = tuple(sorted((each for each in claims if each.value == value), key=lambda each: -each.confidence))
    against = tuple(each for each in claims if each.value != value)
    return Judged(value, confidence, mine, ranked[1] if len(ranked) > 1 and ranked[1][1] > 0.01 else None, against)


def _log_odds(confidence: float) -> float:
    held = min(max(confidence, 0.02), 0.985)
    return math.log(held / (1 - held))


def _evidence(claims: Sequence[Claim]) -> dict[Any, float]:
    """Weight of each value [nats]: the strongest claim of a source in full, its repetitions a little."""
    found: dict[Any, float] = {}
    by_source: dict[tuple[Any, str], list[float]] = {}
    for each in claims:
        by_source.setdefault((each.value, each.source), []).append(_log_odds(each.confidence))
    for (value, _), weights in by_source.items():
        first, *rest = sorted(weights, reverse=True)
        found[value] = found.get(value, 0.0) + first + min(1.0, sum(_AGAIN * max(0.0, each) for each in rest[:3]))
    return found


def _among(weights: Mapping[Any, float], count: int) -> dict[Any, float]:
    """Weights of values of which there are more than two: a claim is against each of the others a share of its doubt."""
    return {value: weight + math.log(count - 1) * min(1.0, max(0.0, weight)) for value, weight in weights.items()}


class _Scene:
    """Enumerates the scenes of the vehicles on each type of road."""

    def __init__(self, claims: Sequence[AnyClaim], count: int) -> None:
        plain = [each for each in claims if isinstance(each, Claim)]
        self.count = count
        self.claims = {path: [each for each in plain if each.path == path] for path in {each.path for each in plain}}
        self.relations = [
            each for each in claims if isinstance(each, DirectionClaim) and max(each.first, each.second) < count
        ]
        self.contacts = [
            each for each in claims if isinstance(each, ContactClaim) and max(each.striking, each.struck) < count
        ]
        self.has_driveway = bool(self.claims.get("driveway"))
        self.unary = [{way: self._of_way(vehicle, way) for way in self._ways(vehicle)} for vehicle in range(count)]

    def _of(self, vehicle: int, field: str) -> list[Claim]:
        return self.claims.get(f"vehicles[{vehicle}].{field}", [])

    def _ways(self, vehicle: int) -> list[_Way]:
        said = {each.value for each in self._of(vehicle, "action")}
        aims = bool(self._of(vehicle, "destination"))
        actions = [
            action for action in _ACTIONS if action is Action.MOVE_FORWARD or action in said or aims or "any" in said
        ]
        return [_Way(heading, action) for heading in DIRECTIONS for action in actions]

    def _of_way(self, vehicle: int, way: _Way) -> float:
        weight = _among(_evidence(self._of(vehicle, "initial_position")), len(DIRECTIONS)).get(way.heading, 0.0)
        weight += _evidence(self._of(vehicle, "action")).get(way.action, 0.0)
        weight += _STRAIGHT_ON if way.action is Action.MOVE_FORWARD else 0.0
        weight += _evidence(self._of(vehicle, "destination")).get(way.leaves, 0.0)
        straight = _evidence(self._of(vehicle, "heading_on")).get(way.leaves, 0.0)
        return weight + straight + (0.8 * max(0.0, straight) if way.action is Action.MOVE_FORWARD else 0.0)

    def judged(self) -> dict[str, Judged]:
        roads = self._roads()
        sums: dict[str, dict[Any, float]] = {}
        groups = list(self._groups())
        stems: list[Compass | None] = [*Compass]
        for road, stem in (
            (kind, at) for kind in _ROADS for at in (stems if kind is RoadType.T_INTERSECTION else [None])
        ):
            score = roads[road] + (
                _evidence(self.claims.get("stem_direction", [])).get(stem, 0.0) - math.log(len(Compass))
                if stem is not None
                else 0.0
            )
            marginals: list[tuple[str, dict[Any, float]]] = []
            for group in groups:
                total, fields = self._enumerate(group, road, stem)
                score += total
                marginals += fields
            _add(sums, "road_type", road, score)
            if stem is not None:
                _add(sums, "stem_direction", stem, score)
            for path, values in marginals:
                for value, share in values.items():
                    _add(sums, path, value, score + share)
        return {path: self._judge(path, values) for path, values in sums.items()}

    def _judge(self, path: str, logs: Mapping[Any, float]) -> Judged:
        top = max(logs.values())
        total = sum(math.exp(each - top) for each in logs.values())
        ranked = sorted(
            ((value, math.exp(weight - top) / total) for value, weight in logs.items()),
            key=lambda each: (-each[1], str(each[0])),
        )
        return _judged(ranked, self.claims.get(path, []))

    def _roads(self) -> dict[RoadType, float]:
        said = _among(_evidence(self.claims.get("road_type", [])), len(_ROADS))
        weights = {road: said.get(road, 0.0) - 0.9 for road in _ROADS}
        weights[RoadType.STRAIGHT] += 0.9
        if max(said.get(road, 0.0) for road in _JUNCTIONS) > 0:
            weights[RoadType.STRAIGHT] -= max(0.0, said.get(RoadType.STRAIGHT, 0.0))  # straight roads cross, too
        if RoadType.T_INTERSECTION in said and RoadType.INTERSECTION in said:
            weights[RoadType.INTERSECTION] -= min(
                said[RoadType.INTERSECTION], said[RoadType.T_INTERSECTION], 2.5
            )  # a T is one
        if said.get(RoadType.CURVE, 0.0) > 0 and said.get(RoadType.STRAIGHT, 0.0) > 0:
            weights[RoadType.CURVE] += 0.7  # a bend in a road that is straight elsewhere
        u_turns = any(
            each.value is Manoeuvre.U_TURN for vehicle in range(self.count) for each in self._of(vehicle, "manoeuvre")
        )
        weights[RoadType.STRAIGHT] += 0.4 if u_turns else 0.0
        if self.has_driveway and max(said.get(road, 0.0) for road in _JUNCTIONS) <= 0:
            weights[RoadType.STRAIGHT] += 1.2
        if RoadType.MERGING in said and not any(self._of(vehicle, "on_ramp") for vehicle in range(self.count)):
            weights[RoadType.MERGING] -= 2.0
        return weights

    def _groups(self) -> Iterator[tuple[int, ...]]:
        """Vehicles that contacts and relations tie together."""
        left, ties = (
            set(range(self.count)),
            [
                *((each.first, each.second) for each in self.relations),
                *((each.striking, each.struck) for each in self.contacts),
            ],
        )
        while left:
            group = [min(left)]
            for vehicle in group:
                group += [other for tie in ties if vehicle in tie for other in tie if other not in group]
            for start in range(0, len(group), _MOST_TOGETHER):
                yield tuple(group[start : start + _MOST_TOGETHER])
            left -= set(group)

    def _enumerate(
        self, group: Sequence[int], road: RoadType, stem: Compass | None
    ) -> tuple[float, list[tuple[str, dict[Any, float]]]]:
        """Log of the sum over all scenes of a group, and of the shares of each field's values."""
        scores: list[tuple[tuple[_Way, ...], float]] = []
        pairs = [
            pair for pair in itertools.combinations(range(len(group)), 2) if self._tied(*(group[at] for at in pair))
        ]
        known: dict[tuple[int, int, _Way, _Way], float] = {}
        options = [
            [
                (
                    way,
                    self.unary[vehicle][way]
                    + _on_road(way, road, stem, may_turn=self._may_turn(vehicle))
                    + self._on_stem(vehicle, way, stem),
                )
                for way in self.unary[vehicle]
            ]
            for vehicle in group
        ]
        for chosen in itertools.product(*options):
            weight = sum(each[1] for each in chosen)
            for one, other in pairs:
                key = (one, other, chosen[one][0], chosen[other][0])
                if key not in known:
                    first, second = group[one], group[other]
                    known[key] = self._related(first, second, *key[2:]) + self._met(first, second, *key[2:], road)
                weight += known[key]
            scores.append((tuple(each[0] for each in chosen), weight))
        top = max(weight for _, weight in scores)
        total = top + math.log(sum(math.exp(weight - top) for _, weight in scores))
        fields: list[tuple[str, dict[Any, float]]] = []
        for place, vehicle in enumerate(group):
            for name in ("heading", "action"):
                values: dict[Any, float] = {}
                for ways, weight in scores:
                    value = getattr(ways[place], name)
                    values[value] = values.get(value, 0.0) + math.exp(weight - top)
                path = f"vehicles[{vehicle}].{'initial_position' if name == 'heading' else 'action'}"
                fields.append(
                    (path, {value: math.log(max(share, 1e-300)) + top - total for value, share in values.items()})
                )
        return total, fields

    def _may_turn(self, vehicle: int) -> bool:
        """Whether it can turn where no roads meet."""
        return self.has_driveway or any(each.value is Manoeuvre.U_TURN for each in self._of(vehicle, "manoeuvre"))

    def _on_stem(self, vehicle: int, way: _Way, stem: Compass | None) -> float:
        """What it weighs that a vehicle is said to come along the road that ends."""
        weight = _evidence(self._of(vehicle, "on_stem")).get(True, 0.0)
        if stem is None or not weight:
            return 0.0
        runs_through = way.action is Action.MOVE_FORWARD and origin_of(way.heading) is stem
        return (weight if origin_of(way.heading) is stem else -weight) + (_MISSING_LEG * 0.7 if runs_through else 0.0)

    def _tied(self, one: int, other: int) -> bool:
        return any({each.first, each.second} == {one, other} for each in self.relations) or any(
            {each.striking, each.struck} == {one, other} for each in self.contacts
        )

    def _related(self, one: int, other: int, first: _Way, second: _Way) -> float:
        weight = 0.0
        for each in self.relations:
            if {each.first, each.second} != {one, other}:
                continue
            mine, theirs = (first, second) if each.first == one else (second, first)
            holds = _holds(each.relation, mine.heading, theirs.heading)
            weight += _log_odds(each.confidence) if holds else 0.0
        return weight

    def _met(self, one: int, other: int, first: _Way, second: _Way, road: RoadType) -> float:
        for each in self.contacts:
            if {each.striking, each.struck} == {one, other}:
                mine, theirs = (first, second) if each.striking == one else (second, first)
                return _contact_weight(
                    mine, theirs, each.striking_side, each.struck_side, crosses=road in _JUNCTIONS or self.has_driveway
                )
        return 0.0


def _add(sums: dict[str, dict[Any, float]], path: str, value: Any, weight: float) -> None:
    values = sums.setdefault(path, {})
    old = values.get(value)
    if old is None:
        values[value] = weight
    else:
        top = max(old, weight)
        values[value] = top + math.log(math.exp(old - top) + math.exp(weight - top))


def _holds(kind: Relation, mine: Position, theirs: Position) -> bool:
    match kind:
        case Relation.SAME:
            return mine is theirs
        case Relation.OPPOSITE:
            return mine is opposite(theirs)
        case Relation.CROSSING:
            return theirs in {turned(mine, Side.LEFT), turned(mine, Side.RIGHT)}
        case Relation.FROM_LEFT:
            return theirs is turned(mine, Side.RIGHT)
    return theirs is turned(mine, Side.LEFT)


def _on_road(way: _Way, road: RoadType, stem: Compass | None, *, may_turn: bool) -> float:
    """How well a way fits a road: turns want a junction, and a T has one leg less."""
    weight = 0.0
    if way.action is not Action.MOVE_FORWARD and road not in _JUNCTIONS and not may_turn:
        weight -= 0.5
    if stem is not None:
        missing = TOWARDS[_towards(stem)]
        weight -= _MISSING_LEG if origin_of(way.heading) is missing else 0.0
        weight -= _MISSING_LEG * 0.7 if TOWARDS[way.leaves] is missing else 0.0
        weight += 0.3 if origin_of(way.heading) is stem or TOWARDS[way.leaves] is stem else 0.0
    return weight


def _towards(stem: Compass) -> Position:
    """The way that leads from a stem straight on."""
    return next(position for position in DIRECTIONS if origin_of(position) is stem)


def _contact_weight(mine: _Way, theirs: _Way, front: Side | None, side: Side | None, *, crosses: bool) -> float:
    """How well two ways explain a contact, the first running into the second [nats]."""
    weight = 0.0
    same, facing = mine.heading is theirs.heading, mine.heading is opposite(theirs.heading)
    crossing = not same and not facing
    turns = mine.action is not Action.MOVE_FORWARD or theirs.action is not Action.MOVE_FORWARD
    if crossing:
        weight += 0.3 if crosses else -2.2
    if facing and not turns and crosses:
        weight -= 0.4
    if front is Side.FRONT and side is Side.REAR:
        weight += 2.0 if same else 0.6 if mine.leaves is theirs.leaves and crossing and turns else -1.5
    elif front is Side.FRONT and side is Side.FRONT:
        weight += 1.2 if facing else -0.3 if crossing else -1.8
    elif front is Side.FRONT and side in {Side.LEFT, Side.RIGHT}:
        weight += _broadside(mine, theirs, side)
    elif {front, side} <= {Side.LEFT, Side.RIGHT} and None not in {front, side}:
        weight += (0.9 if same else 0.0) if front is not side else (0.9 if facing else -0.6 if same else 0.0)
    elif front is Side.REAR and side is Side.FRONT:
        weight += 0.8 if same else -0.5
    return weight


def _broadside(mine: _Way, theirs: _Way, side: Side) -> float:
    """A front meets a side: the one who strikes comes from that side of the other, at some moment of the other's turn."""
    comes_from = opposite(mine.heading)
    faces = {turned(heading, side) for heading in (theirs.heading, theirs.leaves)}
    if comes_from in faces:
        return 1.3
    if mine.heading is opposite(theirs.heading) and theirs.action is not Action.MOVE_FORWARD:
        # A vehicle that turns across the path of an oncoming one shows it its inner flank no more than its outer one.
        hit = Side.RIGHT if theirs.action is Action.TURN_LEFT else Side.LEFT
        return 1.0 if side is hit else -0.4
    if mine.heading is theirs.heading:
        return -0.2
    return -1.0 if theirs.action is Action.MOVE_FORWARD else -0.5
