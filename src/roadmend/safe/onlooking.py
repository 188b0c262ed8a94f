"""Who takes part where one vehicle crashes alone: that vehicle, what it strikes, and the ego, which only looks on."""

import math

from roadmend.safe.casting import KIND, vehicle_actor
from roadmend.safe.departure import LEAVING, Departure, Struck, strike
from roadmend.safe.dsl import CrashScenario, DescribedImpact, Side, StruckObject
from roadmend.safe.spots import Spot
from roadmend.safe.ways import Layout, centre_line, chosen_lane
from roadmend.world import scenario_actors as world
from roadmend.world.drivers import BODIES
from roadmend.world.ego import GRAVITY
from roadmend.world.network import network_file
from roadmend.world.obstacle import Obstacle
from roadmend.world.road_network import read_network
from roadmend.world.scenario import Ego
from roadmend.world.scenario_networks import OpenRoadNetwork
from roadmend.world.space import Parameters
from roadmend.world.steering import line_through

_EGO = BODIES["car"]  # of the onlooker
_BEFORE_A_JUNCTION = 25.0  # [m] that its corners, stop lines and islands need
_BEYOND = 80.0  # [m] that are looked at beyond the end of a road
_PAST = 80.0  # [m] from the place of the crash to the onlooker's goal
_BEYOND_A_JUNCTION = 45.0  # [m] along the road on the other side to that goal
_BEFORE_THE_END = 4.0  # [m] from it to the end of a road that it does not go on from
_LATERAL = 0.33  # share of gravity across the way that is left for a bend
_GRIP = 0.6  # share of what the road transmits
_SAMPLE = 5.0  # [m] over which a bend's curvature is taken


class OnlookerStage:
    """Places a vehicle that crashes alone, and the vehicle under test, which follows it or comes the other way."""

    def __init__(
        self, told: CrashScenario, crash: CrashScenario, layout: Layout, drawn: Parameters, friction: float
    ) -> None:
        """Lay out the crash.

        Args:
            told: the crash as the report has it.
            crash: the same, what was left open filled in.
            layout: the road and the vehicle's way.
            drawn: the point that it was filled in from.
            friction: of the road.
        """
        self._layout, self._drawn, self._way = layout, drawn, layout.ways[0]
        self._vehicle = crash.vehicles[0]
        assert self._vehicle.model is not None
        self._kind = KIND[self._vehicle.model]
        self._body = BODIES[self._kind]
        self._lane = chosen_lane(layout, 0, drawn)
        self._told = told.impacts[0] if told.impacts else DescribedImpact(1)
        self._overruns = layout.ends and self._told.roadside is None
        self._points = self._course()
        self._side = self._roadside()
        self._speed = min(self._of("speed") * self._way.limit, self._body.speed_max, self._in_bends(friction))
        self._crash = self._strike()
        self._time = self._time_to_crash()

    def ego(self) -> Ego:
        """The vehicle under test, which takes no part in the crash."""
        return self._oncoming() if self._comes_the_other_way else self._following()

    def actors(self) -> list[world.Actor]:
        """The report's vehicle."""
        spot = self._spot()
        follow = world.Follow(when=world.Trigger(time=0.0), points=self._crash.line, speed=round(self._speed, 2))
        return [vehicle_actor("v1", self._kind, self._way, spot, [follow])]

    def obstacles(self) -> list[Obstacle]:
        """What it strikes."""
        return [self._crash.obstacle]

    @property
    def adapted(self) -> tuple[str, ...]:
        """What was added that the report does not name, and what stands elsewhere than it says."""
        where = "comes the other way" if self._comes_the_other_way else "drives behind"
        added = [f"the ego is no vehicle of the report: it {where} and looks on"]
        if self._told.object is None:
            added.append("what was struck is not said: something beside the road")
        if self._crash.is_misplaced:
            kind = self._crash.obstacle.kind.replace("_", " ")
            added.append(f"the {kind} stands on the roadway: vehicle 1 does not come off a road as wide as this")
        return tuple(added)

    @property
    def _comes_the_other_way(self) -> bool:
        network = self._layout.network
        two_way = isinstance(network, OpenRoadNetwork) and network.backward_lanes > 0
        return two_way and self._drawn["onlooker"] == "oncoming"

    def _of(self, what: str) -> float:
        return float(self._drawn[f"v1.{what}"])

    def _course(self) -> list[tuple[float, float]]:
        """The line along which its lane leads it [m], or straight on beyond the end of its road."""
        route = self._way.route
        if not self._overruns:
            return centre_line(self._layout.network, route, self._lane)
        points = centre_line(self._layout.network, route[:1], self._lane)
        (x0, y0), (x1, y1) = points[-2:]
        share = _BEYOND / math.hypot(x1 - x0, y1 - y0)
        return [*points, (x1 + share * (x1 - x0), y1 + share * (y1 - y0))]

    def _roadside(self) -> Side:
        """To which side the vehicle leaves: as it is said, else to the outside of a bend, else to the right."""
        if self._told.roadside is not None:
            return self._told.roadside
        network = self._layout.network
        bends_right = isinstance(network, OpenRoadNetwork) and network.bend < 0.0
        return Side.LEFT if bends_right else Side.RIGHT

    def _in_bends(self, friction: float) -> float:
        """The speed [m/s] at which the way's bends leave room for steering off it, too."""
        line = line_through(self._points)
        tightest = 0.0
        for place in range(round(_SAMPLE), max(round(line.length - _SAMPLE), round(_SAMPLE) + 1), round(_SAMPLE)):
            turn = math.remainder(line.pose(place + _SAMPLE)[2] - line.pose(place - _SAMPLE)[2], math.tau)
            tightest = max(tightest, abs(turn) / (2.0 * _SAMPLE))
        lateral = min(_LATERAL, _GRIP * friction) * GRAVITY - 0.5 * LEAVING
        return math.sqrt(lateral / tightest) if tightest else math.inf

    def _strike(self) -> Struck:
        place = self._way.meeting
        if self._layout.is_junction and not self._overruns:
            place = min(place, self._way.length) - _BEFORE_A_JUNCTION
        departure = Departure(
            self._told.object or StruckObject.OTHER,
            self._told.striking_side or Side.FRONT,
            self._side,
            self._speed,
            0.0 if self._overruns else self._of("depart_angle"),
            self._of("clearance"),
        )
        return strike(self._layout.network, self._points, self._body, departure, place)

    def _time_to_crash(self) -> float:
        """Seconds from the start to the crash: as drawn, but on its lane at first, and with room for who follows."""
        crash, gap = self._crash, float(self._drawn["onlooker.gap"])
        least = (crash.station - crash.start) / self._speed + 0.5
        on_first_edge = (crash.station + 0.5 * self._body.length - self._way.length + 1.0) / self._speed
        least = max(least, on_first_edge)
        room = crash.station - 0.5 * self._body.length - _EGO.length - 2.0 - gap * self._speed
        return max(min(max(self._of("time"), least), room / self._speed), 0.5)

    def _spot(self) -> Spot:
        front = self._crash.station + 0.5 * self._body.length - self._speed * self._time
        return Spot(self._way.route[0], self._lane, front, self._body.length, self._speed)

    def _following(self) -> Ego:
        ahead = self._spot()
        front = ahead.front - ahead.length - float(self._drawn["onlooker.gap"]) * self._speed
        position = max(front - 0.5 * _EGO.length, 0.5 * _EGO.length + 0.5)
        speed = min(self._speed, self._way.limit)
        if self._layout.ends or (self._layout.is_junction and self._way.turn):  # it has seen all before it turns
            return _ego(self._way.route[:1], self._lane, position, speed, self._way.length - _BEFORE_THE_END)
        goal = self._crash.station + _PAST if len(self._way.route) == 1 else _BEYOND_A_JUNCTION
        return _ego(self._way.route, self._lane, position, speed, goal)

    def _oncoming(self) -> Ego:
        edge = read_network(network_file(self._layout.network)).edges["backward"]
        lane = len(edge.car_lanes) - 1  # the one nearest to the other direction
        speed = min(self._speed, edge.car_lanes[lane].speed_limit)
        place = edge.car_lanes[lane].length - self._crash.station
        due = self._time + float(self._drawn["onlooker.delay"])
        return _ego(("backward",), lane, max(place - speed * due, 0.5 * _EGO.length + 0.5), speed, place + _PAST)


def _ego(route: tuple[str, ...], lane: int, position: float, speed: float, goal: float) -> Ego:
    return Ego(
        route=list(route),
        lane=lane,
        position=round(position, 2),
        speed=round(speed, 2),
        goal=round(goal, 2),
        length=_EGO.length,
        width=_EGO.width,
    )
