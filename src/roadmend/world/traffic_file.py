"""The actors of a scenario as a SUMO route file."""

from xml.etree import ElementTree as ET

from roadmend.core.errors import InputError
from roadmend.world.drivers import entry_speed, ignores_others, pedestrian_type, type_name, vehicle_type
from roadmend.world.road_network import RoadNetwork
from roadmend.world.route_builder import check_edge
from roadmend.world.scenario import Scenario
from roadmend.world.scenario_actors import Pedestrian, Vehicle

EGO = "ego"


def traffic_xml(scenario: Scenario, network: RoadNetwork) -> str:
    """The text of the route file: vehicle types, vehicles and persons in order of departure.

    Raises:
        InputError: names the actor whose route, lane or position does not exist.
    """
    root = ET.Element("routes")
    types: set[str] = set()
    departures = sorted(enumerate(scenario.actors), key=lambda item: (item[1].depart, item[0]))
    for place, actor in departures:
        if isinstance(actor, Vehicle):
            _add_vehicle(root, types, scenario, network, actor, f"actors[{place}]")
        else:
            _add_pedestrian(root, network, actor, f"actors[{place}]")
    return ET.tostring(root, encoding="unicode")


def _add_vehicle(
    root: ET.Element, types: set[str], scenario: Scenario, network: RoadNetwork, vehicle: Vehicle, where: str
) -> None:
    for step, name in enumerate(vehicle.route):
        check_edge(network, name, f"{where}.route[{step}]")
    ignoring = ignores_others(vehicle, scenario.seed)
    attributes = vehicle_type(vehicle, scenario.environment, ignoring=ignoring)
    for step, (name, following) in enumerate(zip(vehicle.route, vehicle.route[1:], strict=False)):
        if not _leads(network, name, following, attributes["vClass"]):
            raise InputError(
                f"{where}.route[{step + 1}]",
                f"no lane leads from {name!r} to {following!r} that is open to a {vehicle.kind}",
                "choose edges that connect",
            )
    edge = network.edges[vehicle.route[0]]
    if vehicle.lane >= len(edge.car_lanes):
        raise InputError(
            f"{where}.lane", f"{edge.id} has {len(edge.car_lanes)} lanes for cars", "count from 0 at the right"
        )
    lane_number = edge.lane_number(vehicle.lane)
    if vehicle.position > edge.lanes[lane_number].length:
        raise InputError(
            f"{where}.position", f"{vehicle.position:g} m is past the end of {edge.id}", "choose a smaller one"
        )
    if not edge.lanes[lane_number].admits(attributes["vClass"]):  # SUMO would end the drive in its first step
        raise InputError(
            f"{where}.lane", f"{vehicle.lane} of {edge.id} is closed to a {vehicle.kind}", "choose another lane or edge"
        )
    name = type_name(vehicle, ignoring=ignoring)
    if name not in types:
        types.add(name)
        ET.SubElement(root, "vType", {"id": name} | attributes)
    limit = edge.lanes[lane_number].speed_limit
    element = ET.SubElement(
        root,
        "vehicle",
        {
            "id": vehicle.id,
            "type": name,
            "depart": f"{vehicle.depart:.2f}",
            "departLane": str(lane_number),
            "departPos": f"{vehicle.position:.2f}",
            "departSpeed": entry_speed(vehicle, float(attributes["speedFactor"]), limit),
        },
    )
    ET.SubElement(element, "route", edges=" ".join(vehicle.route))


def _leads(network: RoadNetwork, name: str, following: str, vehicle_class: str) -> bool:
    """Whether vehicles of SUMO's class come from one edge to the other."""
    begins, ends = network.edges[name].lanes, network.edges[following].lanes
    return any(
        link.to_edge == following and lane.admits(vehicle_class) and ends[link.to_lane].admits(vehicle_class)
        for number, lane in enumerate(begins)
        for link in network.connections.get((name, number), [])
    )


def _add_pedestrian(root: ET.Element, network: RoadNetwork, person: Pedestrian, where: str) -> None:
    for step, name in enumerate(person.route):
        edge = network.edges.get(name)
        if edge is None or edge.function != "normal":
            check_edge(network, name, f"{where}.route[{step}]")
        elif not any(lane.for_pedestrians_only for lane in edge.lanes):
            raise InputError(
                f"{where}.route[{step}]",
                f"edge {name!r} has no sidewalk",
                "set network.crossings: true or choose another edge",
            )
    if person.position > network.edges[person.route[0]].lanes[0].length:
        raise InputError(
            f"{where}.position", f"{person.position:g} m is past the end of {person.route[0]}", "choose a smaller one"
        )
    name = f"pedestrian_{person.id}"
    ET.SubElement(root, "vType", {"id": name} | pedestrian_type(person.driver, person.speed))
    element = ET.SubElement(
        root, "person", id=person.id, type=name, depart=f"{person.depart:.2f}", departPos=f"{person.position:.2f}"
    )
    ET.SubElement(element, "walk", {"from": person.route[0], "to": person.route[-1]})
