"""The consistency solver: the scene that satisfies the claims best, how sure each of its fields is, and what speaks against.

Every field has a few candidates. A scene takes one for each: a direction and a turn for every vehicle, a type of road, the
stem of a T. Claims give it weight, in log-odds; so do relations and contacts, by the geometry of who can have met whom,
on which side. All scenes are enumerated, vehicle by vehicle with what a contact ties together, and the sums over them
give each value's probability: exact, deterministic, and small, for a crash has few vehicles.
"""

import itertools
import math
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from roadmend.safe.claims import AnyClaim, Claim, ClaimSource, ContactClaim, DirectionClaim, WayRelation
from roadmend.safe.compass import DIRECTIONS, TOWARDS, turned
from roadmend.safe.dsl import Action, Compass, Manoeuvre, RoadType
from roadmend.safe.reading.geometry import JUNCTIONS, StatedWay, explains, fits_road, holds
from roadmend.safe.reading.weighing import JudgedField, add, evidence, judge, log_odds, shares, with_claims

_MOST_TOGETHER = 4  # vehicles whose scenes are enumerated together
_STRAIGHT_ON = 1.0  # [nats] vehicles go straight on unless something says otherwise
_SAID_STRAIGHT = 0.8  # of the weight of "meant to go on north" speaks for going straight
_HINT = 0.6  # [nats] of a manoeuvre for how two ways lie to each other
_OUT = 1.5  # [nats] that who comes out of a driveway comes across the road
_TOLD = 0.6  # confidence from which a manoeuvre hints at that
_JOINS = 3.0  # [nats] from which it is sure enough that a vehicle joins from a ramp
_PLAIN_ROAD = 0.9  # [nats] by which a straight road is likelier than the others before anything is said

_Place = tuple[RoadType, Compass | None]


def solve(claims: Sequence[AnyClaim], count: int, *, together: bool = True) -> Mapping[str, JudgedField]:
    """Judge every field of which a claim speaks, and the directions and actions of all vehicles.

    Args:
        claims: of the summary and the sketch.
        count: of vehicles in the cast.
        together: let fields decide about each other; without, each is judged by what is said of it alone.
    """
    scene = _Scene(claims, count, together=together)
    return {path: judge(about) for path, about in scene.claims.items()} | scene.judged()


def fit(claims: Sequence[AnyClaim], count: int) -> float:
    """How well one scene can satisfy all claims about ways and roads [nats]: the log of the sum over all scenes."""
    return _Scene(claims, count, together=True).weigh()[0]


class _Scene:
    """Enumerates the scenes of the vehicles on each type of road."""

    def __init__(self, claims: Sequence[AnyClaim], count: int, *, together: bool) -> None:
        self.count = count
        self.together = together
        self.claims: dict[str, list[Claim]] = {}
        for each in claims:
            if isinstance(each, Claim):
                self.claims.setdefault(each.path, []).append(each)
        self.relations = [each for each in claims if together and isinstance(each, DirectionClaim)]
        self.contacts = [each for each in claims if together and isinstance(each, ContactClaim)]
        self.has_driveway = "driveway" in self.claims
        self.alone = [{way: self._of_way(vehicle, way) for way in self._ways(vehicle)} for vehicle in range(count)]

    def _of(self, vehicle: int, field: str) -> list[Claim]:
        return self.claims.get(f"vehicles[{vehicle}].{field}", [])

    def _ways(self, vehicle: int) -> list[StatedWay]:
        said = {Action.MOVE_FORWARD, *(each.value for each in self._of(vehicle, "action"))}
        actions = Action if self._of(vehicle, "destination") else [action for action in Action if action in said]
        return [StatedWay(heading, action) for heading in DIRECTIONS for action in actions]

    def _of_way(self, vehicle: int, way: StatedWay) -> float:
        """What the claims about one vehicle weigh for a way."""
        straight = evidence(self._of(vehicle, "heading_on")).get(way.leaves, 0.0)
        weight = evidence(self._of(vehicle, "initial_position"), len(DIRECTIONS)).get(way.heading, 0.0)
        weight += evidence(self._of(vehicle, "action")).get(way.action, 0.0)
        weight += evidence(self._of(vehicle, "destination")).get(way.leaves, 0.0) + straight
        return weight + (_STRAIGHT_ON + _SAID_STRAIGHT * max(0.0, straight)) * way.is_straight

    def judged(self) -> dict[str, JudgedField]:
        """The fields that hang together: type of road, stem, directions and actions."""
        return {
            path: with_claims(shares(values), self.claims.get(path, [])) for path, values in self.weigh()[1].items()
        }

    def weigh(self) -> tuple[float, dict[str, dict[Any, float]]]:
        """Log of the sum over all scenes, and of the part of it that has each value of each field."""
        whole: dict[str, float] = {}
        sums: dict[str, dict[Any, float]] = {}
        roads, stems, groups = self._roads(), evidence(self.claims.get("stem_direction", [])), list(self._groups())
        places: list[_Place] = [(road, None) for road in RoadType if road is not RoadType.T_INTERSECTION]
        places += [(RoadType.T_INTERSECTION, stem) for stem in Compass]
        for road, stem in places:
            score = roads[road] + (stems.get(stem, 0.0) - math.log(len(Compass)) if stem is not None else 0.0)
            marginals: list[tuple[str, Any, float]] = []
            for group in groups:
                total, fields = self._enumerate(group, (road, stem))
                score += total
                marginals += [(path, value, weight - total) for path, value, weight in fields]
            add(whole, "", score)
            add(sums.setdefault("road_type", {}), road, score)
            if stem is not None:
                add(sums.setdefault("stem_direction", {}), stem, score)
            for path, value, share in marginals:
                add(sums.setdefault(path, {}), value, score + share)
        return whole[""], sums

    def _roads(self) -> dict[RoadType, float]:
        """What weighs for each type of road before the vehicles are looked at."""
        said = evidence(self.claims.get("road_type", []), len(RoadType))
        weights = {road: said.get(road, 0.0) - _PLAIN_ROAD * (road is not RoadType.STRAIGHT) for road in RoadType}
        straight, tee, cross = (said.get(road, 0.0) for road in (RoadType.STRAIGHT, *reversed(JUNCTIONS)))
        u_turn = any(each.value is Manoeuvre.U_TURN for at in range(self.count) for each in self._of(at, "manoeuvre"))
        weights[RoadType.STRAIGHT] += 0.4 * u_turn
        if max(tee, cross) > 0:
            weights[RoadType.STRAIGHT] -= max(0.0, straight)  # straight roads cross, too
        elif self.has_driveway:
            weights[RoadType.STRAIGHT] += 1.2
        if tee > 0:
            weights[RoadType.INTERSECTION] -= max(0.0, min(cross, tee, 2.5))  # a T is an intersection
        if min(said.get(RoadType.CURVE, 0.0), straight) > 0:
            weights[RoadType.CURVE] += 0.7  # a bend in a road that is straight elsewhere
        if said.get(RoadType.MERGING, 0.0) > _JOINS:  # ramps bend, main roads are straight, and both cross others
            for road in (RoadType.CURVE, RoadType.STRAIGHT, *JUNCTIONS):
                weights[road] -= max(0.0, said.get(road, 0.0))
        if not any(self._of(vehicle, "on_ramp") for vehicle in range(self.count)):
            weights[RoadType.MERGING] -= 2.0 * (RoadType.MERGING in said)
        return weights

    def _ties(self) -> Iterator[frozenset[int]]:
        yield from (frozenset({each.first, each.second}) for each in self.relations)
        yield from (frozenset({each.striking, each.struck}) for each in self.contacts)
        if not self.contacts and self.count == 2:
            yield frozenset({0, 1})

    def _groups(self) -> Iterator[tuple[int, ...]]:
        """Vehicles that contacts and relations tie together."""
        left, ties = set(range(self.count)), list(self._ties())
        while left:
            group = [min(left)]
            for vehicle in group:
                group += sorted({each for tie in ties if vehicle in tie for each in tie} - {*group})
            for start in range(0, len(group), _MOST_TOGETHER):
                yield tuple(group[start : start + _MOST_TOGETHER])
            left -= {*group}

    def _enumerate(self, group: Sequence[int], place: _Place) -> tuple[float, list[tuple[str, Any, float]]]:
        """Log of the sum over all scenes of a group, and of the part of it that each field's values have."""
        ties = set(self._ties())
        pairs = [pair for pair in itertools.combinations(range(len(group)), 2) if {*(group[at] for at in pair)} in ties]
        known: dict[tuple[int, int, StatedWay, StatedWay], float] = {}
        sums: dict[tuple[str, Any], float] = {}
        total: dict[str, float] = {}
        options = [[(way, self._alone(vehicle, way, place)) for way in self.alone[vehicle]] for vehicle in group]
        for chosen in itertools.product(*options):
            weight = sum(each for _, each in chosen)
            for one, other in pairs:
                key = (group[one], group[other], chosen[one][0], chosen[other][0])
                if key not in known:
                    known[key] = self._together(*key, road=place[0])
                weight += known[key]
            add(total, "", weight)
            for vehicle, (way, _) in zip(group, chosen, strict=True):
                add(sums, (f"vehicles[{vehicle}].initial_position", way.heading), weight)
                add(sums, (f"vehicles[{vehicle}].action", way.action), weight)
        return total[""], [(path, value, weight) for (path, value), weight in sums.items()]

    def _alone(self, vehicle: int, way: StatedWay, place: _Place) -> float:
        if not self.together:
            return self.alone[vehicle][way]
        u_turns = any(each.value is Manoeuvre.U_TURN for each in self._of(vehicle, "manoeuvre"))
        on_stem = evidence(self._of(vehicle, "on_stem")).get(True, 0.0)
        may_turn = self.has_driveway or u_turns
        hands = evidence(self._of(vehicle, "stem_hand"))
        on_hand = sum(weight for hand, weight in hands.items() if TOWARDS[turned(way.heading, hand)] is place[1])
        return self.alone[vehicle][way] + on_hand + fits_road(way, *place, may_turn=may_turn, on_stem=on_stem)

    def _by_manoeuvre(self, one: int, other: int, first: StatedWay, second: StatedWay) -> float:
        """Who changes lane meets somebody of the same way, who comes over the centre line somebody who comes towards it."""
        done = {
            each.value for vehicle in (one, other) for each in self._of(vehicle, "manoeuvre") if each.confidence > _TOLD
        }
        same = bool(done & {Manoeuvre.CHANGING_LANE, Manoeuvre.MERGE, Manoeuvre.OVERTAKE}) and holds(
            WayRelation.SAME, first.heading, second.heading
        )
        astray = Manoeuvre.ENTER_THE_WRONG_WAY in done
        out = (
            sum(each.value is Manoeuvre.LEAVE_DRIVEWAY for at in (one, other) for each in self._of(at, "manoeuvre"))
            == 1
        )
        crosses = out and holds(WayRelation.CROSSING, first.heading, second.heading)
        return _OUT * crosses + _HINT * (same + (astray and holds(WayRelation.OPPOSITE, first.heading, second.heading)))

    def _together(self, one: int, other: int, first: StatedWay, second: StatedWay, *, road: RoadType) -> float:
        """What the relations and the first contact of two vehicles weigh for their ways."""
        ways, weight = {one: first, other: second}, 0.0
        for each in self.relations:
            if {each.first, each.second} == {one, other}:
                held = holds(each.relation, ways[each.first].heading, ways[each.second].heading)
                weight += log_odds(each.confidence) * held
        if not any(
            {each.first, each.second} == {one, other} and each.source is not ClaimSource.TRAINED
            for each in self.relations
        ):
            weight += self._by_manoeuvre(one, other, first, second)
        contact = next((each for each in self.contacts if {each.striking, each.struck} == {one, other}), None)
        if contact is None and not self.contacts and self.count == 2:  # somehow they met
            return weight + explains(first, second, None, None, crosses=road in JUNCTIONS or self.has_driveway)
        if contact is None:
            return weight
        sides, crosses = (contact.striking_side, contact.struck_side), road in JUNCTIONS or self.has_driveway
        return weight + explains(ways[contact.striking], ways[contact.struck], *sides, crosses=crosses)
