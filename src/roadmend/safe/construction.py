"""Stage II of SAFE: a crash report with one of its vehicles replaced by the policy under test, as a scenario."""

import math
import random
import re
from dataclasses import dataclass, replace

from roadmend.core.errors import InputError
from roadmend.safe.dsl import STANDING, Action, CrashScenario, DescribedVehicle, DslModel, Manoeuvre, Side
from roadmend.safe.layout import Layout, Way, lay_out
from roadmend.safe.open_questions import answer, open_questions
from roadmend.safe.staging import Relation, goes_first, relation_of
from roadmend.world import scenario as world
from roadmend.world.drivers import BODIES
from roadmend.world.network import LANE_WIDTH
from roadmend.world.space import Parameters, sample

KIND: dict[DslModel, str] = {
    DslModel.SEDAN: "car",
    DslModel.SUV: "suv",
    DslModel.MINIVAN: "minivan",
    DslModel.PICKUP: "pickup",
    DslModel.SEMI_TRUCK: "semi_truck",
}
_EDGE_OF_LIFE = 25.0  # [s] an episode is over: whatever the report describes has happened by then
_BEYOND = 60.0  # [m] from the place of the crash to the ego's goal
_BEFORE_A_TURN = 14.0  # [m/s] at most at the start of who is about to turn
_GAP = 4.0  # [m] between bumpers at the start, at least
_PARKED_AHEAD = 8.0  # [m] beyond the place of the crash


@dataclass(frozen=True, slots=True)
class CrashRole:
    """A report with one of its vehicles played by the policy under test."""

    report: str  # its name
    crash: CrashScenario
    ego: int  # index of that vehicle

    @property
    def number(self) -> int:
        """The report's number of the vehicle, from 1."""
        return self.ego + 1


def draw_scenario(role: CrashRole, index: int, seed: int = 0) -> world.Scenario:
    """Draw what a report leaves open; the same report, role, index and seed give the same scenario.

    Raises:
        InputError: no road network can be built for the report.
    """
    drawn = sample(open_questions(role.crash), generator_of(role, f"{seed}/{index}"))
    return build_scenario(role, drawn, f"{role.report}-v{role.number}-{index}", seed)


def generator_of(role: CrashRole, purpose: str) -> random.Random:
    """Random numbers that depend on the report, the role and the purpose alone."""
    return random.Random(f"roadmend/safe/{role.report}/{role.number}/{purpose}")


def build_scenario(role: CrashRole, drawn: Parameters, name: str, seed: int) -> world.Scenario:
    """The scenario that a point of the open questions stands for.

    Args:
        role: the report, and who is the ego in it.
        drawn: a point of :func:`roadmend.safe.open_questions.open_questions`.
        name: of the scenario; characters that a name may not have become '-'.
        seed: of the simulator.

    Raises:
        InputError: no road network can be built for the report.
    """
    crash = answer(role.crash, drawn)
    layout = lay_out(crash, drawn)
    stage = _Stage(role, crash, layout, drawn)
    weather = crash.environment.weather
    time = crash.environment.time
    assert weather is not None
    assert time is not None
    return world.Scenario(
        name=re.sub(r"[^A-Za-z0-9_.\-]", "-", name),
        seed=seed,
        time_limit=_EDGE_OF_LIFE,
        network=layout.network,
        ego=stage.ego(),
        actors=stage.actors(),
        environment=world.Environment.model_validate({"weather": weather.lower(), "time_of_day": time.lower()}),
        origin=world.ReportOrigin(
            report=role.report, vehicle=role.number, sampled=dict(drawn), adapted=list(layout.adapted)
        ),
    )


@dataclass(frozen=True, slots=True)
class _Spot:
    """Where a vehicle is at the start."""

    edge: str
    lane: int
    front: float  # [m] along the edge, negative for those who come later
    length: float  # [m]
    speed: float  # [m/s]


class _Stage:
    """Places everybody so that they meet where the report says, had nobody looked out."""

    def __init__(self, role: CrashRole, crash: CrashScenario, layout: Layout, drawn: Parameters) -> None:
        self._role, self._crash, self._layout, self._drawn = role, crash, layout, drawn
        way = self._way(role.ego)
        body = BODIES[self._kind(role.ego)]
        speed = min(min(self._of(role.ego, "speed"), 1.0) * way.limit, body.speed_max)
        if way.turn and layout.is_junction:
            speed = min(speed, _BEFORE_A_TURN)
        distance = max(speed * self._of(role.ego, "time"), way.meeting - way.length + body.length)
        distance = min(distance, way.meeting - body.length - 1.0)
        self._time = distance / max(speed, 1.0)  # [s] to the place of the crash
        front = way.meeting - distance + 0.5 * body.length
        self._ego_spot = _Spot(way.route[0], self._lane(role.ego), front, body.length, speed)

    def ego(self) -> world.Ego:
        """The vehicle under test: on the way that the report's vehicle took."""
        spot, way = self._ego_spot, self._way(self._role.ego)
        body = BODIES[self._kind(self._role.ego)]
        after = {"mainline": _BEYOND}.get(way.route[-1], way.meeting + _BEYOND if len(way.route) == 1 else 45.0)
        return world.Ego(
            route=list(way.route),
            lane=spot.lane,
            position=round(spot.front - 0.5 * spot.length, 2),
            speed=round(spot.speed, 2),
            goal=round(after, 2),
            length=body.length,
            width=body.width,
        )

    def actors(self) -> list[world.Actor]:
        """The report's other vehicles."""
        spots = [self._ego_spot]
        actors: list[world.Actor] = []
        for index in range(len(self._crash.vehicles)):
            if index == self._role.ego:
                continue
            spot, manoeuvres = self._cast(index)
            length = self._way(index).length
            spot = _make_room(replace(spot, front=min(spot.front, length - 1.0)), spots)
            if spot.front > length:
                continue  # pushed past the road's end: no room for it
            spots.append(spot)
            actors.append(self._actor(index, spot, manoeuvres))
        return actors

    def _cast(self, index: int) -> tuple[_Spot, list[world.Manoeuvre]]:
        """Where one of the others starts, and what it does."""
        relation = relation_of(self._way(self._role.ego), self._way(index))
        vehicle, way = self._crash.vehicles[index], self._way(index)
        body = BODIES[self._kind(index)]
        now = world.Trigger(time=0.0)
        waits = vehicle.manoeuvre in STANDING
        if waits and not (self._layout.is_junction and relation is Relation.CROSSING):
            lane = self._ego_spot.lane if relation is Relation.SAME else self._lane(index)
            front = way.meeting + _PARKED_AHEAD + 3.0 * self._of(index, "delay")
            return _Spot(way.route[0], lane, min(front, way.meeting), body.length, 0.0), [
                world.Heedless(when=now, speed=0.0)
            ]
        speed = min(self._of(index, "speed") * way.limit, body.speed_max)
        if way.turn and self._layout.is_junction:
            speed = min(speed, self._of(index, "turning_speed"))
        if relation is Relation.SAME:
            return self._alongside(index, vehicle, way, body.length, speed)
        due = self._time + self._of(index, "delay")
        if self._layout.is_junction and (waits or self._drawn[f"v{index + 1}.start"] == "from_stop"):
            return self._pull_out(index, way, speed, due)
        front = way.meeting - speed * due + 0.5 * body.length
        spot = _Spot(way.route[0], self._lane(index), front, body.length, speed)
        offset, begin = 0.0, due - self._of(index, "drift_time")
        if relation is Relation.ONCOMING and self._crosses_over(index):
            ego_way = self._way(self._role.ego)
            offset = (way.lane_count - spot.lane - 0.5) + (ego_way.lane_count - self._ego_spot.lane - 0.5)
        elif relation is Relation.MERGING and way.route[0] == "ramp":
            offset = self._ego_spot.lane + 1.0
            begin = max(begin, (way.length + 2.0 - front) / max(speed, 1.0) + body.length / max(speed, 1.0))
        if not offset:
            return spot, self._drive(index, now, speed)
        drift = world.Drift(
            when=world.Trigger(time=round(max(0.1, begin), 2)),
            offset=round(offset * LANE_WIDTH, 2),
            over=self._of(index, "drift_time"),
        )
        return spot, [world.Heedless(when=now, speed=round(speed, 2)), drift]

    def _pull_out(self, index: int, way: Way, speed: float, due: float) -> tuple[_Spot, list[world.Manoeuvre]]:
        """Who stands at the junction and starts so that it meets the ego ``due`` seconds after the start."""
        body = BODIES[self._kind(index)]
        way_to_go = way.meeting - way.length + 0.5 * body.length + 1.0
        building_up = 0.5 * speed * speed / body.acceleration  # [m] until it has its speed
        if way_to_go < building_up:
            needed = math.sqrt(2.0 * way_to_go / body.acceleration)
        else:
            needed = speed / body.acceleration + (way_to_go - building_up) / speed
        spot = _Spot(way.route[0], self._lane(index), way.length - 1.0, body.length, 0.0)
        go = world.Heedless(when=world.Trigger(time=round(max(0.2, due - needed), 2)), speed=round(speed, 2))
        return spot, [world.Heedless(when=world.Trigger(time=0.0), speed=0.0), go]

    def _alongside(
        self, index: int, vehicle: DescribedVehicle, way: Way, length: float, speed: float
    ) -> tuple[_Spot, list[world.Manoeuvre]]:
        """Who goes the ego's way: changes into its lane, comes from behind, or is ahead and slows down."""
        ego, now = self._ego_spot, world.Trigger(time=0.0)
        delay = self._of(index, "delay")
        lanes = [lane for lane in (ego.lane - 1, ego.lane + 1) if 0 <= lane < way.lane_count]
        if vehicle.manoeuvre in {Manoeuvre.CHANGING_LANE, Manoeuvre.MERGE} and lanes:
            lane = lanes[int(self._drawn[f"v{index + 1}.side"]) % len(lanes)]
            over = self._of(index, "drift_time")
            front = ego.front + (ego.speed - speed) * self._time - speed * delay * 0.3
            begin = round(max(0.1, self._time - over), 2)
            return _Spot(ego.edge, lane, front, length, speed), [
                world.Heedless(when=now, speed=round(speed, 2)),
                world.Drift(when=world.Trigger(time=begin), offset=(ego.lane - lane) * LANE_WIDTH, over=over),
            ]
        first = goes_first(self._role.crash, self._role.ego, index)
        behind = self._drawn[f"v{index + 1}.order"] == "behind" if first is None else not first
        lane = ego.lane if ego.lane in way.lanes else self._lane(index)
        if behind:
            closing = self._of(index, "closing")
            speed = min(ego.speed + closing, BODIES[self._kind(index)].speed_max)
            gap = max(_GAP, (speed - ego.speed) * (self._time + delay))
            return _Spot(ego.edge, lane, ego.front - ego.length - gap, length, speed), self._drive(index, now, speed)
        front = ego.front + length + 0.6 * ego.speed + 6.0 * (delay + 2.5)
        pace = min(speed, ego.speed)
        brake = world.Brake(
            when=world.Trigger(time=round(0.5 * self._time, 2)),
            speed=0.0,
            hold=8.0,
            deceleration=self._of(index, "braking"),
        )
        return _Spot(ego.edge, lane, front, length, pace), [brake]

    def _drive(self, index: int, when: world.Trigger, speed: float) -> list[world.Manoeuvre]:
        """What a vehicle does that goes its way: as if it were alone, unless it was drawn to look out."""
        if self._drawn[f"v{index + 1}.heed"] == "none":
            return [world.Heedless(when=when, speed=round(speed, 2))]
        return [world.RunRightOfWay(when=when, hold=_EDGE_OF_LIFE)]

    def _crosses_over(self, index: int) -> bool:
        """Whether an oncoming vehicle comes over the centre line: the report says so, or nothing else explains it."""
        if any(
            each.striking == self._role.number
            and each.struck == index + 1
            and each.struck_side in {Side.LEFT, Side.RIGHT}
            for each in self._crash.collisions
        ):
            return False  # it was hit from the side: the ego's vehicle came across
        others = [vehicle.manoeuvre for place, vehicle in enumerate(self._crash.vehicles) if place != index]
        vehicle = self._crash.vehicles[index]
        if vehicle.manoeuvre is Manoeuvre.ENTER_THE_WRONG_WAY:
            return True
        ahead = all(each.action is Action.MOVE_FORWARD for each in self._crash.vehicles)
        return ahead and Manoeuvre.ENTER_THE_WRONG_WAY not in others and vehicle.manoeuvre not in STANDING

    def _actor(self, index: int, spot: _Spot, manoeuvres: list[world.Manoeuvre]) -> world.Vehicle:
        way, kind = self._way(index), self._kind(index)
        inside = spot.front > spot.length + 0.5
        late = 0.0 if inside else (spot.length + 0.5 - spot.front) / max(spot.speed, 1.0)
        heedless = any(isinstance(manoeuvre, world.Heedless) for manoeuvre in manoeuvres)
        # A heedless vehicle holds the speed that it is told; the driver's own wish must only not forbid it.
        factor = 2.0 if heedless else max(0.3, min(2.0, 1.1 * spot.speed / way.limit))
        return world.Vehicle(
            id=f"v{index + 1}",
            kind=kind,
            driver="aggressive",
            route=list(way.route),
            depart=round(late, 2),
            lane=spot.lane,
            position=round(spot.front if inside else spot.length + 0.5, 2),
            speed=round(spot.speed, 2),
            speed_factor=round(factor, 3),
            manoeuvres=manoeuvres,
        )

    def _way(self, index: int) -> Way:
        return self._layout.ways[index]

    def _kind(self, index: int) -> str:
        model = self._crash.vehicles[index].model
        assert model is not None
        return KIND[model]

    def _of(self, index: int, what: str) -> float:
        return float(self._drawn[f"v{index + 1}.{what}"])

    def _lane(self, index: int) -> int:
        way = self._way(index)
        if not way.lanes:
            raise InputError(f"vehicle {index + 1}", f"no lane leads from {way.route[0]} to {way.route[-1]}", "mend it")
        return way.lanes[min(int(self._of(index, "lane") * len(way.lanes)), len(way.lanes) - 1)]


def _make_room(spot: _Spot, taken: list[_Spot]) -> _Spot:
    """The spot, moved along its lane until it is clear of the others there: forwards if it is ahead of the ego."""
    neighbours = [other for other in taken if (other.edge, other.lane) == (spot.edge, spot.lane)]
    forwards = taken[0] in neighbours and spot.front >= taken[0].front
    for other in sorted(neighbours, key=lambda other: other.front, reverse=not forwards):
        if spot.front - spot.length >= other.front + _GAP or other.front - other.length >= spot.front + _GAP:
            continue
        front = other.front + _GAP + spot.length if forwards else other.front - other.length - _GAP
        spot = replace(spot, front=front)
    return spot
