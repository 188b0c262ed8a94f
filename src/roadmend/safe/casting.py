"""Where everybody of a crash starts and what the others do, so that they meet where the report says."""

import math
from dataclasses import replace
from functools import cached_property

from roadmend.safe.alongside import Neighbour
from roadmend.safe.dsl import CROSSING_OVER, STANDING, Action, CrashScenario, DslModel, Manoeuvre, Side
from roadmend.safe.own_lines import backwards_line, u_turn_line
from roadmend.safe.spots import Casting, Spot, make_room
from roadmend.safe.staging import Relation, relation_of
from roadmend.safe.ways import Layout, Way, centre_line, chosen_lane
from roadmend.world import scenario_actors as world
from roadmend.world.drivers import BODIES
from roadmend.world.ego import GRAVITY
from roadmend.world.network import LANE_WIDTH
from roadmend.world.obstacle import Obstacle
from roadmend.world.scenario import Ego
from roadmend.world.space import Parameters

KIND: dict[DslModel, str] = {
    DslModel.SEDAN: "car",
    DslModel.SUV: "suv",
    DslModel.MINIVAN: "minivan",
    DslModel.PICKUP: "pickup",
    DslModel.SEMI_TRUCK: "semi_truck",
}
EDGE_OF_LIFE = 25.0  # [s] an episode is over: whatever the report describes has happened by then
WAITED_FOR = "waited-for"  # name of who stands before an ego that has stopped
_BEYOND = 60.0  # [m] from the place of the crash to the ego's goal
_BEFORE_A_TURN = 14.0  # [m/s] at most at the start of who is about to turn
_LATERAL = 0.38  # share of the road's grip, and of gravity, that a driver uses sideways in a turn
_STARTING = 2.5  # [m/s2] of who starts from standstill along a line of its own
_BEHIND_WHO_WAITS = 3.5  # [m] between bumpers in a queue


class MeetingStage:
    """Places everybody so that they meet where the report says, had nobody looked out."""

    def __init__(
        self, told: CrashScenario, ego: int, crash: CrashScenario, layout: Layout, drawn: Parameters, friction: float
    ) -> None:
        """Place the ego.

        Args:
            told: the crash as the report has it.
            ego: index of the vehicle whose place the ego takes.
            crash: the same, what was left open filled in.
            layout: the roads and everybody's way.
            drawn: the point that it was filled in from.
            friction: of the road.
        """
        self._told, self._ego, self._crash, self._layout, self._drawn = told, ego, crash, layout, drawn
        self._lateral = _LATERAL * min(friction / 0.5, 1.0) * GRAVITY
        way = self._way(ego)
        body = BODIES[self._kind(ego)]
        self._waits = crash.vehicles[ego].manoeuvre in STANDING or drawn.get(f"v{ego + 1}.waits") == "yes"
        speed = min(min(self._of(ego, "speed"), 1.0) * way.limit, body.speed_max)
        if way.turn and layout.is_junction:
            speed = min(speed, _BEFORE_A_TURN)
        distance = max(speed * self._of(ego, "time"), way.meeting - way.length + body.length)
        distance = min(distance, way.meeting - body.length - 1.0)
        self._time = distance / max(speed, 1.0)  # [s] to the place of the crash
        front = way.meeting - distance + 0.5 * body.length
        if self._waits and self._is_hit_from_behind():
            speed, self._time = 0.0, self._of(ego, "time")
            front = min(way.meeting, way.length - 1.0) - 2.0 * body.length - _BEHIND_WHO_WAITS
        self._ego_spot = Spot(way.route[0], self._lane(ego), front, body.length, speed)

    def ego(self) -> Ego:
        """The vehicle under test: on the way that the report's vehicle took."""
        spot, way = self._ego_spot, self._way(self._ego)
        body = BODIES[self._kind(self._ego)]
        last = centre_line(self._layout.network, way.route[-1:], 0)
        room = math.dist(last[0], last[-1]) - body.length
        after = {"mainline": _BEYOND}.get(way.route[-1], way.meeting + _BEYOND if len(way.route) == 1 else 45.0)
        return Ego(
            route=list(way.route),
            lane=spot.lane,
            position=round(spot.front - 0.5 * spot.length, 2),
            speed=round(spot.speed, 2),
            goal=round(min(after, max(room, 5.0)) if len(way.route) > 1 else after, 2),
            length=body.length,
            width=body.width,
        )

    def obstacles(self) -> list[Obstacle]:
        """Nothing: vehicles meet."""
        return []

    def actors(self) -> list[world.Actor]:
        """The report's other vehicles, and whom a vehicle that has stopped waits for."""
        return self._placed[0]

    @cached_property
    def _placed(self) -> tuple[list[world.Actor], list[int]]:
        """Everybody but the ego, and the numbers of vehicles for which there is no room."""
        spots = [self._ego_spot]
        actors: list[world.Actor] = []
        left_out = []
        if self._waits and self._is_hit_from_behind():
            ahead = self._queue_head()
            spots.append(ahead)
            still: list[world.Manoeuvre] = [world.Heedless(when=world.Trigger(time=0.0), speed=0.0)]
            actors.append(vehicle_actor(WAITED_FOR, "car", self._way(self._ego), ahead, still))
        for index in range(len(self._crash.vehicles)):
            if index == self._ego:
                continue
            spot, manoeuvres = self._cast(index)
            length = self._way(index).length
            spot = make_room(replace(spot, front=min(spot.front, length - 1.0)), spots)
            if spot.front > length:  # pushed past the road's end
                left_out.append(index + 1)
                continue
            spots.append(spot)
            actors.append(vehicle_actor(f"v{index + 1}", self._kind(index), self._way(index), spot, manoeuvres))
        return actors, left_out

    @property
    def adapted(self) -> tuple[str, ...]:
        """What was added that the report does not name, and which of its vehicles are not there."""
        waits = self._waits and self._is_hit_from_behind()
        added = ("a vehicle stands before the ego, which had stopped",) if waits else ()
        return (*added, *(f"vehicle {number}: no room on its road, left out" for number in self._placed[1]))

    def _is_hit_from_behind(self) -> bool:
        """Whether who meets the ego goes its way: then it may stand in a queue without that being in between."""
        ways = [way for index, way in enumerate(self._layout.ways) if index != self._ego]
        return any(relation_of(self._way(self._ego), way) is Relation.SAME for way in ways)

    def _queue_head(self) -> Spot:
        """Who stands before the ego: a vehicle that has stopped has something to wait for."""
        ego, body = self._ego_spot, BODIES["car"]
        return Spot(ego.edge, ego.lane, ego.front + _BEHIND_WHO_WAITS + body.length, body.length, 0.0)

    def _cast(self, index: int) -> Casting:
        """Where one of the others starts, and what it does."""
        relation = relation_of(self._way(self._ego), self._way(index))
        way, vehicle = self._way(index), self._crash.vehicles[index]
        body = BODIES[self._kind(index)]
        now = world.Trigger(time=0.0)
        speed = min(self._of(index, "speed") * way.limit, body.speed_max)
        turns = bool(way.turn) and self._layout.is_junction
        if turns:
            speed = min(speed, self._of(index, "turning_speed"), math.sqrt(self._lateral * way.corner))
        due = self._time + self._of(index, "delay")
        if vehicle.manoeuvre is Manoeuvre.U_TURN:
            return self._turning_round(index, due)
        if vehicle.manoeuvre is Manoeuvre.REVERSE and relation is Relation.SAME:
            return self._backing(index, due)
        if relation is Relation.SAME:
            neighbour = Neighbour(
                self._told,
                self._ego,
                index,
                way,
                self._ego_spot,
                self._time,
                self._lane(index),
                body.length,
                speed,
                self._drawn,
            )
            spot, manoeuvres = neighbour.cast()
            return replace(spot, speed=min(spot.speed, body.speed_max)), manoeuvres
        waits = vehicle.manoeuvre in STANDING
        if waits and not (self._layout.is_junction and relation is Relation.CROSSING):
            front = way.meeting + 8.0 + 3.0 * self._of(index, "delay")
            spot = Spot(way.route[0], self._lane(index), min(front, way.meeting), body.length, 0.0)
            return spot, [world.Heedless(when=now, speed=0.0)]
        if self._layout.is_junction and (waits or self._drawn[f"v{index + 1}.start"] == "from_stop"):
            return self._pull_out(index, way, speed, due)
        front = way.meeting - speed * due + 0.5 * body.length
        spot = Spot(way.route[0], self._lane(index), front, body.length, speed)
        if turns:
            return spot, [self._along(index, spot, now, speed)]
        offset, begin = 0.0, due - self._of(index, "drift_time")
        if relation is Relation.ONCOMING and self._crosses_over(index):
            ego_way = self._way(self._ego)
            offset = (way.lane_count - spot.lane - 0.5) + (ego_way.lane_count - self._ego_spot.lane - 0.5)
            offset = offset * LANE_WIDTH + self._layout.median
        elif relation is Relation.MERGING and way.route[0] == "ramp":
            offset = (self._ego_spot.lane + 1.0) * LANE_WIDTH
            begin = max(begin, (way.length + 2.0 - front) / max(speed, 1.0) + body.length / max(speed, 1.0))
        if not offset:
            return spot, self._drive(index, now, speed)
        drift = world.Drift(
            when=world.Trigger(time=round(max(0.1, begin), 2)),
            offset=round(offset, 2),
            over=self._of(index, "drift_time"),
        )
        return spot, [world.Heedless(when=now, speed=round(speed, 2)), drift]

    def _along(self, index: int, spot: Spot, when: world.Trigger, speed: float) -> world.Follow:
        """Drive along one's way, through the junction as a body on tyres does."""
        points = centre_line(self._layout.network, self._way(index).route, spot.lane)
        return world.Follow(when=when, points=points, speed=round(speed, 2))

    def _pull_out(self, index: int, way: Way, speed: float, due: float) -> Casting:
        """Who stands at the junction and starts so that it meets the ego ``due`` seconds after the start."""
        body = BODIES[self._kind(index)]
        building = _STARTING if way.turn else body.acceleration  # [m/s2]
        way_to_go = way.meeting - way.length + 0.5 * body.length + 1.0
        building_up = 0.5 * speed * speed / building  # [m] until it has its speed
        if way_to_go < building_up:
            needed = math.sqrt(2.0 * way_to_go / building)
        else:
            needed = speed / building + (way_to_go - building_up) / speed
        spot = Spot(way.route[0], self._lane(index), way.length - 1.0, body.length, 0.0)
        when = world.Trigger(time=round(max(0.2, due - needed), 2))
        still = world.Heedless(when=world.Trigger(time=0.0), speed=0.0)
        if way.turn:
            return spot, [still, self._along(index, spot, when, speed)]
        return spot, [still, world.Heedless(when=when, speed=round(speed, 2))]

    def _turning_round(self, index: int, due: float) -> Casting:
        """Who makes a U-turn, from standstill, across the ego's way."""
        way, body = self._way(index), BODIES[self._kind(index)]
        lane = centre_line(self._layout.network, way.route[:1], self._lane(index))
        start = min(way.meeting, way.length - 30.0)
        line = u_turn_line(lane, start - 0.5 * body.length)
        speed = self._of(index, "turning_speed")
        begin = max(0.2, due - 2.0 - 0.5 * speed / _STARTING)
        spot = Spot(way.route[0], self._lane(index), start, body.length, 0.0)
        return spot, [
            world.Heedless(when=world.Trigger(time=0.0), speed=0.0),
            world.Follow(when=world.Trigger(time=round(begin, 2)), points=line, speed=round(speed, 2)),
        ]

    def _backing(self, index: int, due: float) -> Casting:
        """Who comes backwards towards the ego, ahead in its lane."""
        way, body = self._way(index), BODIES[self._kind(index)]
        spot = Spot(way.route[0], self._ego_spot.lane, min(way.meeting + 12.0, way.length - 1.0), body.length, 0.0)
        lane = centre_line(self._layout.network, way.route[:1], spot.lane)
        line = backwards_line(lane, spot.front - 0.5 * body.length)
        begin = max(0.2, due - 4.0)
        return spot, [
            world.Heedless(when=world.Trigger(time=0.0), speed=0.0),
            world.Follow(when=world.Trigger(time=round(begin, 2)), points=line, speed=3.0, backwards=True),
        ]

    def _drive(self, index: int, when: world.Trigger, speed: float) -> list[world.Manoeuvre]:
        """What a vehicle does that goes its way: as if it were alone, unless it was drawn to look out."""
        if self._drawn[f"v{index + 1}.heed"] == "none":
            return [world.Heedless(when=when, speed=round(speed, 2))]
        return [world.RunRightOfWay(when=when, hold=EDGE_OF_LIFE)]

    def _crosses_over(self, index: int) -> bool:
        """Whether an oncoming vehicle comes over the centre line: the report says so, or nothing else explains it."""
        if any(
            each.striking == self._ego + 1 and each.struck == index + 1 and each.struck_side in {Side.LEFT, Side.RIGHT}
            for each in self._told.collisions
        ):
            return False  # it was hit from the side: the ego's vehicle came across
        others = [vehicle.manoeuvre for place, vehicle in enumerate(self._crash.vehicles) if place != index]
        vehicle = self._crash.vehicles[index]
        if vehicle.manoeuvre in CROSSING_OVER:
            return True
        ahead = all(each.action is Action.MOVE_FORWARD for each in self._crash.vehicles)
        free = vehicle.manoeuvre not in {*STANDING, Manoeuvre.RUN_OFF}
        return ahead and free and not any(other in CROSSING_OVER for other in others)

    def _way(self, index: int) -> Way:
        return self._layout.ways[index]

    def _kind(self, index: int) -> str:
        model = self._crash.vehicles[index].model
        assert model is not None
        return KIND[model]

    def _of(self, index: int, what: str) -> float:
        return float(self._drawn[f"v{index + 1}.{what}"])

    def _lane(self, index: int) -> int:
        return chosen_lane(self._layout, index, self._drawn)


def vehicle_actor(name: str, kind: str, way: Way, spot: Spot, manoeuvres: list[world.Manoeuvre]) -> world.Vehicle:
    """One of a report's vehicles as it enters the scenario, from a spot, on its way."""
    inside = spot.front > spot.length + 0.5
    late = 0.0 if inside else (spot.length + 0.5 - spot.front) / max(spot.speed, 1.0)
    told = any(isinstance(manoeuvre, world.Heedless | world.Follow) for manoeuvre in manoeuvres)
    # A heedless vehicle holds the speed that it is told; the driver's own wish must only not forbid it.
    factor = 2.0 if told else max(0.3, min(2.0, 1.1 * spot.speed / way.limit))
    return world.Vehicle(
        id=name,
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
