"""A scenario as ASAM OpenSCENARIO XML 1.2, with its road network as OpenDRIVE beside it.

What a scenario says of drivers (habits, right of way) has no words in OpenSCENARIO; a vehicle's properties carry it.
Vehicles refer to the middle of the rear axle, as the standard wants.
"""

import datetime as dt
import math
from pathlib import Path

import numpy as np
from scenariogeneration import xosc

from roadmend import __version__
from roadmend.core.errors import InputError
from roadmend.core.route import Stage
from roadmend.core.whole_file import written_beside
from roadmend.world.drivers import BODIES
from roadmend.world.network import network_file
from roadmend.world.obstacle import Obstacle
from roadmend.world.opendrive import write_opendrive
from roadmend.world.road_network import RoadNetwork, read_network
from roadmend.world.route_builder import build_route
from roadmend.world.scenario import Environment, Scenario
from roadmend.world.scenario_actors import (
    Brake,
    CutIn,
    Drift,
    Follow,
    Heedless,
    Manoeuvre,
    Pedestrian,
    RunRightOfWay,
    Trigger,
    Vehicle,
)
from roadmend.world.scenario_networks import SumoConfiguration
from roadmend.world.steering import line_through
from roadmend.world.traffic_file import traffic_xml

Pose = tuple[float, float, float]  # [m], [m], [rad]

EGO = "ego"
_MINOR_VERSION = 2
_DATE = dt.datetime(2026, 1, 1, tzinfo=dt.UTC)  # the same scenario gives the same file
_AXLE = 0.3  # share of the length from the rear axle to the middle
_HEIGHT = {"truck": 3.6, "semi_truck": 4.0, "bus": 3.2, "suv": 1.8, "minivan": 1.8, "pickup": 1.9}  # [m] else 1.5
_CATEGORY = {
    "truck": "truck",
    "semi_truck": "semitrailer",
    "bus": "bus",
    "motorcycle": "motorbike",
    "bicycle": "bicycle",
    "minivan": "van",
}
_STANDING = {  # height [m], mass [kg] and category of what stands there
    "tree": (8.0, 1000.0, "tree"),
    "pole": (8.0, 300.0, "pole"),
    "sign": (2.5, 30.0, "pole"),
    "barrier": (0.8, 3000.0, "barrier"),
    "wall": (2.0, 20_000.0, "building"),
    "ditch": (0.1, 1000.0, "patch"),
    "curb": (0.15, 1000.0, "obstacle"),
    "parked_vehicle": (4.0, 7000.0, "obstacle"),
    "animal": (1.2, 100.0, "obstacle"),
    "debris": (0.5, 50.0, "obstacle"),
}
_CLOUDS = {"cloudy": "sixOktas", "overcast": "eightOktas", "rainy": "eightOktas", "snowy": "eightOktas"}
_CUT_IN = 3.0  # [s]
_APART = 0.01  # [m] between two points of a line at least
_DRY = 0.9  # friction that OpenSCENARIO's factor of 1 stands for


def export_scenario(scenario: Scenario, folder: Path) -> tuple[Path, Path]:
    """Write NAME.xosc and NAME.xodr.

    Args:
        scenario: what to write.
        folder: where to.

    Returns:
        The two files.

    Raises:
        InputError: the scenario has traffic of its own or people on foot, or cannot be run since it names an edge, lane
            or place that is not there; or the folder cannot be written.
        SimulationError: netconvert cannot write the network.
    """
    if isinstance(scenario.network, SumoConfiguration):
        raise InputError("network", "a SUMO configuration brings its own traffic", "export a scenario with actors")
    for place, actor in enumerate(scenario.actors):
        if isinstance(actor, Pedestrian):
            raise InputError(f"actors[{place}]", "people on foot are not exported", "leave them out")
    path = network_file(scenario.network)
    network = read_network(path)
    build_route(network, scenario)  # both refuse what a simulation would
    traffic_xml(scenario, network)
    roads, story = folder / f"{scenario.name}.xodr", folder / f"{scenario.name}.xosc"
    write_opendrive(path, roads)
    described = _Description(scenario, network).build(roads.name)
    with written_beside(story) as beside:
        described.write_xml(str(beside))
    return story, roads


class _Description:
    """Builds one OpenSCENARIO document."""

    def __init__(self, scenario: Scenario, network: RoadNetwork) -> None:
        self._scenario, self._network = scenario, network
        self._vehicles = [actor for actor in scenario.actors if isinstance(actor, Vehicle)]

    def build(self, roads: str) -> xosc.Scenario:
        """The document; ``roads`` is the name of the OpenDRIVE file beside it."""
        ego = self._scenario.ego
        entities, init = xosc.Entities(), xosc.Init()
        init.add_global_action(xosc.EnvironmentAction(_environment(self._scenario.environment)))
        entities.add_scenario_object(EGO, _vehicle("car", ego.length, ego.width, EGO))
        init.add_init_action(EGO, xosc.TeleportAction(self._position(ego.route[0], ego.lane, ego.position, ego.length)))
        init.add_init_action(EGO, _speed(ego.speed))
        self._add_route(init, EGO, ego.route, ego.goal)
        act = xosc.Act("act", _at(0.0))
        for vehicle in self._vehicles:
            body = BODIES[vehicle.kind]
            entities.add_scenario_object(vehicle.id, _vehicle(vehicle.kind, body.length, body.width, vehicle))
            middle = vehicle.position - 0.5 * body.length
            position = self._position(vehicle.route[0], vehicle.lane, middle, body.length)
            limit = self._network.edges[vehicle.route[0]].car_lanes[vehicle.lane].speed_limit
            speed = _speed(vehicle.speed if vehicle.speed is not None else limit)
            group = xosc.ManeuverGroup(f"{vehicle.id}-group")
            group.add_actor(vehicle.id)
            script = xosc.Maneuver(f"{vehicle.id}-script")
            if vehicle.depart > 0.0:
                entry = xosc.Event(f"{vehicle.id}-enters", xosc.Priority.parallel)
                entry.add_trigger(_at(vehicle.depart))
                entry.add_action(f"{vehicle.id}-is-added", xosc.AddEntityAction(vehicle.id, position))
                entry.add_action(f"{vehicle.id}-drives", speed)
                script.add_event(entry)
            else:
                init.add_init_action(vehicle.id, xosc.TeleportAction(position))
                init.add_init_action(vehicle.id, speed)
            self._add_route(init, vehicle.id, vehicle.route, None)
            start = self._lane_line(vehicle.route[0], vehicle.lane).pose(middle)
            for number, manoeuvre in enumerate(vehicle.manoeuvres, start=1):
                at = start if _is_at_start(vehicle, number - 1) else None
                for event in _events(vehicle, manoeuvre, f"{vehicle.id}-{number}", speed, at):
                    script.add_event(event)
            if script.events:
                group.add_maneuver(script)
                act.add_maneuver_group(group)
        for obstacle in self._scenario.obstacles:
            entities.add_scenario_object(obstacle.id, _misc_object(obstacle))
            yaw = round(math.radians(obstacle.heading), 5)
            place = xosc.WorldPosition(obstacle.x, obstacle.y, 0.0, yaw, 0.0, 0.0)
            init.add_init_action(obstacle.id, xosc.TeleportAction(place))
        story = xosc.StoryBoard(init, _at(self._scenario.time_limit, point="stop"))
        if act.maneuvergroup:
            story.add_act(act)
        return xosc.Scenario(
            self._scenario.name,
            f"roadmend {__version__}",
            xosc.ParameterDeclarations(),
            entities,
            story,
            xosc.RoadNetwork(roads),
            xosc.Catalog(),
            osc_minor_version=_MINOR_VERSION,
            creation_date=_DATE,
        )

    def _position(self, edge: str, lane: int, middle: float, length: float = 0.0) -> xosc.WorldPosition:
        """Where the rear axle of a vehicle is whose middle is so many metres along an edge."""
        x, y, yaw = self._lane_line(edge, lane).pose(middle - _AXLE * length)
        return xosc.WorldPosition(round(float(x), 3), round(float(y), 3), 0.0, round(float(yaw), 5), 0.0, 0.0)

    def _lane_line(self, edge: str, lane: int) -> Stage:
        shape = np.ascontiguousarray(self._network.edges[edge].car_lanes[lane].shape, dtype=np.float64)
        return Stage(np.ascontiguousarray(shape[:, 0]), np.ascontiguousarray(shape[:, 1]), np.zeros(len(shape)))

    def _add_route(self, init: xosc.Init, name: str, edges: list[str], goal: float | None) -> None:
        """The way along edges; OpenSCENARIO wants two points at least."""
        route = xosc.Route(f"{name}-route")
        for edge in edges:
            route.add_waypoint(self._position(edge, 0, 1.0), xosc.RouteStrategy.fastest)
        last = self._network.edges[edges[-1]].car_lanes[0].length
        end = last - 1.0 if goal is None else goal
        route.add_waypoint(self._position(edges[-1], 0, end), xosc.RouteStrategy.fastest)
        init.add_init_action(name, xosc.AssignRouteAction(route))


def _vehicle(kind: str, length: float, width: float, who: Vehicle | str) -> xosc.Vehicle:
    body, height = BODIES[kind], _HEIGHT.get(kind, 1.5)
    box = xosc.BoundingBox(width, length, height, round(_AXLE * length, 3), 0.0, 0.5 * height)
    wheel = 0.65  # [m]
    front = xosc.Axle(0.5, wheel, round(0.85 * width, 3), round(0.6 * length, 3), 0.5 * wheel)
    rear = xosc.Axle(0.0, wheel, round(0.85 * width, 3), 0.0, 0.5 * wheel)
    category = getattr(xosc.VehicleCategory, _CATEGORY.get(kind, "car"))
    name = who if isinstance(who, str) else who.id
    vehicle = xosc.Vehicle(f"{name}-{kind}", category, box, front, rear, body.speed_max, body.acceleration, 9.0)
    vehicle.add_property("kind", kind)
    if isinstance(who, Vehicle):
        vehicle.add_property("driver", who.driver)
        if any(isinstance(each, RunRightOfWay | Heedless | Follow) for each in who.manoeuvres):
            vehicle.add_property("disregards_right_of_way", "true")
    return vehicle


def _misc_object(obstacle: Obstacle) -> xosc.MiscObject:
    height, mass, word = _STANDING.get(obstacle.kind, (1.5, 1000.0, "obstacle"))
    box = xosc.BoundingBox(obstacle.width, obstacle.length, height, 0.0, 0.0, 0.5 * height)
    thing = xosc.MiscObject(f"{obstacle.id}-{obstacle.kind}", mass, getattr(xosc.MiscObjectCategory, word), box)
    thing.add_property("kind", obstacle.kind)
    thing.add_property("firm", "true" if obstacle.firm else "false")
    return thing


def _environment(environment: Environment) -> xosc.Environment:
    weather, at_night = environment.weather, environment.time_of_day == "nighttime"
    clouds = getattr(xosc.FractionalCloudCover, _CLOUDS.get(weather, "zeroOktas"))
    kind = {"rainy": xosc.PrecipitationType.rain, "snowy": xosc.PrecipitationType.snow}
    intensity = {"rainy": 4.0, "snowy": 2.0}  # [mm/h]
    sky = xosc.Weather(
        cloudstate=clouds,
        fog=xosc.Fog(round(environment.effective_range, 1)),
        precipitation=xosc.Precipitation(kind.get(weather, xosc.PrecipitationType.dry), intensity.get(weather, 0.0)),
        sun=xosc.Sun(0.0 if at_night else 50_000.0, math.pi, -0.5 if at_night else 0.9),
        wind=xosc.Wind(0.0, 10.0 if weather == "windy" else 0.0),
    )
    hour = 23 if at_night else 12
    clock = xosc.TimeOfDay(False, 2026, 1, 1, hour, 0, 0)
    road = xosc.RoadCondition(round(environment.effective_friction / _DRY, 3))
    return xosc.Environment(weather, clock, sky, road)


def _is_at_start(vehicle: Vehicle, place: int) -> bool:
    """Whether a vehicle still is where it begins when the manoeuvre with an index does: at once, or it has stood."""
    when = vehicle.manoeuvres[place].when.time
    before = vehicle.manoeuvres[:place]
    stood = vehicle.speed == 0.0 and before and all(isinstance(each, Heedless) and not each.speed for each in before)
    return (when is not None and when <= vehicle.depart) or bool(stood)


def _events(
    vehicle: Vehicle, manoeuvre: Manoeuvre, name: str, speed: xosc.AbsoluteSpeedAction, at: Pose | None
) -> list[xosc.Event]:
    """A manoeuvre as events; running the right of way is a property of the vehicle instead.

    Args:
        vehicle: that does it.
        manoeuvre: what it does.
        name: of the event.
        speed: that the vehicle begins with.
        at: where its middle is [m] and how it is turned [rad] when the manoeuvre begins, where that is known.
    """
    event = xosc.Event(name, xosc.Priority.parallel)
    event.add_trigger(_trigger(vehicle, manoeuvre.when, name))
    match manoeuvre:
        case Heedless():
            event.add_action(f"{name}-speed", _speed(manoeuvre.speed))
        case Drift():
            sideways = round(0.5 * math.pi**2 * abs(manoeuvre.offset) / manoeuvre.over**2, 3)  # [m/s2] at its most
            # Of the vehicle itself: ours counts from where it is, which after another drift is not the lane's centre.
            action = xosc.RelativeLaneOffsetAction(
                manoeuvre.offset, vehicle.id, xosc.DynamicsShapes.sinusoidal, sideways, continuous=False
            )
            event.add_action(f"{name}-drift", action)
        case Follow():
            event.add_action(f"{name}-speed", _speed(-manoeuvre.speed if manoeuvre.backwards else manoeuvre.speed))
            event.add_action(f"{name}-follow", _trajectory(vehicle, manoeuvre, name, at))
        case CutIn():
            lane, entity = {"left": (1, vehicle.id), "right": (-1, vehicle.id), "ego": (0, EGO)}[manoeuvre.direction]
            within = xosc.TransitionDynamics(xosc.DynamicsShapes.sinusoidal, xosc.DynamicsDimension.time, _CUT_IN)
            event.add_action(f"{name}-cut-in", xosc.RelativeLaneChangeAction(lane, entity, within))
        case Brake():
            rate = xosc.TransitionDynamics(
                xosc.DynamicsShapes.linear, xosc.DynamicsDimension.rate, manoeuvre.deceleration
            )
            event.add_action(f"{name}-brake", xosc.AbsoluteSpeedAction(manoeuvre.speed, rate))
            again = xosc.Event(f"{name}-over", xosc.Priority.parallel)
            ended = xosc.StoryboardElementStateCondition(
                xosc.StoryboardElementType.event, name, xosc.StoryboardElementState.completeState
            )
            again.add_trigger(xosc.ValueTrigger(f"{name}-held", manoeuvre.hold, xosc.ConditionEdge.none, ended))
            again.add_action(f"{name}-go", speed)
            return [event, again]
        case _:
            return []
    return [event]


def _trajectory(vehicle: Vehicle, follow: Follow, name: str, at: Pose | None) -> xosc.FollowTrajectoryAction:
    """A line of one's own; its points are those of the rear axle, as the standard wants.

    It begins where the vehicle is: a player puts it on the line's first point, and ours may begin far behind it.
    """
    behind = _AXLE * BODIES[vehicle.kind].length * (-1.0 if follow.backwards else 1.0)
    line = line_through(follow.points)
    begin = 0.0 if at is None else line.project(at[0], at[1], 0.5 * line.length, line.length)[0]
    places = []
    for along in (begin, *line.s[line.s > begin + _APART]):
        x, y, yaw = line.pose(float(along))
        x, y = x - behind * math.cos(yaw), y - behind * math.sin(yaw)
        facing = math.remainder(yaw + (math.pi if follow.backwards else 0.0), math.tau)
        places.append(xosc.WorldPosition(round(x, 3), round(y, 3), 0.0, round(facing, 5), 0.0, 0.0))
    way = xosc.Trajectory(f"{name}-line", closed=False)
    way.add_shape(xosc.Polyline([], places))
    return xosc.FollowTrajectoryAction(way, xosc.FollowingMode.position)


def _trigger(vehicle: Vehicle, when: Trigger, name: str) -> xosc.ValueTrigger | xosc.EntityTrigger:
    if when.time is not None:
        return _at(max(when.time, vehicle.depart))  # counted from the episode's start, but who is not there waits
    assert when.ego_distance is not None
    near = xosc.RelativeDistanceCondition(
        when.ego_distance, xosc.Rule.lessThan, xosc.RelativeDistanceType.euclidianDistance, EGO, freespace=False
    )
    return xosc.EntityTrigger(f"{name}-near", 0.0, xosc.ConditionEdge.none, near, vehicle.id)


def _at(time: float, point: str = "start") -> xosc.ValueTrigger:
    """A trigger at a time [s]."""
    condition = xosc.SimulationTimeCondition(time, xosc.Rule.greaterOrEqual)
    return xosc.ValueTrigger(f"at-{time:g}", 0.0, xosc.ConditionEdge.none, condition, point)


def _speed(speed: float) -> xosc.AbsoluteSpeedAction:
    """Have a speed [m/s] at once."""
    at_once = xosc.TransitionDynamics(xosc.DynamicsShapes.step, xosc.DynamicsDimension.time, 0.0)
    return xosc.AbsoluteSpeedAction(round(speed, 3), at_once)
