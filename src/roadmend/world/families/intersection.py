"""S1 left turn, S2 right turn, S3 crossing: an intersection that the ego reaches from the south."""

from roadmend.core.errors import InputError
from roadmend.world.drivers import BODIES
from roadmend.world.families.traffic import (
    DRIVER,
    WEATHER,
    Counts,
    LanePlace,
    body_length,
    count_of,
    environment,
    make_room,
    manoeuvres,
    slot_manoeuvre,
)
from roadmend.world.scenario import Ego, Scenario
from roadmend.world.scenario_actors import Actor, Pedestrian, Vehicle
from roadmend.world.scenario_networks import Arm, IntersectionNetwork
from roadmend.world.space import Choice, Dimension, Parameters, Uniform, Whole

VEHICLES = 22  # slots
PEDESTRIANS = 8  # slots
_ARM_LENGTH = 160.0  # [m]
_JUNCTION_RADIUS = 16.0  # [m] upper bound, so that positions stay on the arm whatever netconvert cuts off
_BEARINGS = {"south": -90.0, "east": 0.0, "north": 90.0, "west": 180.0}
_TARGETS = {"S1": "west", "S2": "east", "S3": "north"}
_KIND = Choice({"car": 0.62, "truck": 0.12, "bus": 0.04, "motorcycle": 0.12, "bicycle": 0.1})
_ARM = Choice({"south": 0.12, "east": 0.28, "north": 0.32, "west": 0.28})


def _vehicle_slot(slot: str) -> dict[str, Dimension]:
    dimensions: dict[str, Dimension] = {
        f"{slot}.kind": _KIND,
        f"{slot}.driver": DRIVER,
        f"{slot}.from": _ARM,
        f"{slot}.turn": Whole(0, 2),
        f"{slot}.arrival": Uniform(0.5, 22.0),
        f"{slot}.speed": Uniform(0.6, 1.1),
    }
    return dimensions | slot_manoeuvre(slot, {"none": 0.62, "brake": 0.1, "run": 0.28})


def _pedestrian_slot(slot: str) -> dict[str, Dimension]:
    return {
        f"{slot}.driver": DRIVER,
        f"{slot}.from": Choice(dict.fromkeys(_BEARINGS, 0.25)),
        f"{slot}.turn": Whole(0, 2),
        f"{slot}.arrival": Uniform(0.0, 20.0),
        f"{slot}.speed": Uniform(0.8, 2.2),
    }


SPACE: dict[str, Dimension] = {
    "layout": Choice({"cross": 0.65, "tee": 0.35}),
    "third_arm": Whole(0, 1),
    **{f"skew_{name}": Uniform(-14.0, 14.0) for name in ("east", "north", "west")},
    "lanes": Whole(1, 2),
    "cross_lanes": Whole(1, 2),
    "speed_limit": Choice({8.33: 0.2, 11.11: 0.2, 13.89: 0.45, 16.67: 0.15}),
    "control": Choice(
        {"minor": 0.3, "major": 0.25, "right_before_left": 0.12, "allway_stop": 0.08, "traffic_light": 0.25}
    ),
    "cycle": Uniform(30.0, 50.0),
    "crossings": Choice({True: 0.5, False: 0.5}),
    "density": Choice({"light": 0.3, "medium": 0.4, "dense": 0.3}),
    "fill": Uniform(0.0, 1.0),
    "ego_distance": Uniform(30.0, 90.0),
    "ego_speed": Uniform(0.5, 1.0),
    "ego_lane": Whole(0, 1),
    **WEATHER,
    **{key: value for index in range(VEHICLES) for key, value in _vehicle_slot(f"v{index}").items()},
    **{key: value for index in range(PEDESTRIANS) for key, value in _pedestrian_slot(f"p{index}").items()},
}
VEHICLE_COUNTS: Counts = {"light": (2, 5), "medium": (6, 12), "dense": (13, VEHICLES)}
PEDESTRIAN_COUNTS: Counts = {"light": (0, 2), "medium": (1, 5), "dense": (3, PEDESTRIANS)}


def build_intersection(family: str, parameters: Parameters, name: str, seed: int) -> Scenario:
    """The scenario that a point of the space stands for.

    Raises:
        InputError: the family is none of S1, S2, S3.
    """
    if family not in _TARGETS:
        raise InputError("family", f"{family!r} has no intersection", "choose S1, S2 or S3")
    target = _TARGETS[family]
    arms = _arms(parameters, target)
    control = str(parameters["control"])
    network = IntersectionNetwork(
        arms=[_arm(parameters, arm, target) for arm in arms],
        control="priority" if control in ("minor", "major") else control,
        crossings=bool(parameters["crossings"]),
        cycle=float(parameters["cycle"]),
    )
    limit = float(parameters["speed_limit"])
    lanes = int(parameters["lanes"])
    lane = {"S1": lanes - 1, "S2": 0, "S3": min(int(parameters["ego_lane"]), lanes - 1)}[family]
    distance = float(parameters["ego_distance"])
    ego = Ego(
        route=["south_in", f"{target}_out"],
        lane=lane,
        position=_ARM_LENGTH - _JUNCTION_RADIUS - distance,
        speed=round(float(parameters["ego_speed"]) * limit, 2),
        goal=50.0,
    )
    here = LanePlace("ego", ("south", lane), ego.position + 0.5 * ego.length, ego.speed, ego.length)
    actors = [*_vehicles(parameters, arms, here), *_pedestrians(parameters, arms)]
    return Scenario(
        name=name,
        family=family,
        seed=seed,
        time_limit=90.0,
        network=network,
        ego=ego,
        actors=actors,
        environment=environment(parameters),
    )


def _arms(parameters: Parameters, target: str) -> list[str]:
    """The arms, the ego's first. At a T-junction one of the two that the ego does not need is missing."""
    if parameters["layout"] == "cross":
        return list(_BEARINGS)
    spare = [arm for arm in _BEARINGS if arm not in ("south", target)]
    return ["south", target, spare[int(parameters["third_arm"])]]


def _is_main_road(arm: str) -> bool:
    return arm in ("south", "north")


def _lanes(parameters: Parameters, arm: str) -> int:
    return int(parameters["lanes" if _is_main_road(arm) else "cross_lanes"])


def _arm(parameters: Parameters, name: str, target: str) -> Arm:
    ego_major = parameters["control"] == "major"
    if parameters["layout"] == "tee" and target != "north":
        # The major road bends: with the ego's arm it takes the arm opposite to the third one.
        major = name in ("south", target) if ego_major else name != "south"
    else:
        major = _is_main_road(name) == ego_major
    return Arm(
        name=name,
        bearing=_BEARINGS[name] + (float(parameters[f"skew_{name}"]) if name != "south" else 0.0),
        lanes=_lanes(parameters, name),
        speed_limit=float(parameters["speed_limit"]),
        length=_ARM_LENGTH,
        major=major,
    )


def _turn(arms: list[str], arm: str, turn: int) -> str:
    """The arm that a driver from ``arm`` leaves by: turns count right, straight, left of those that exist."""
    order = ["south", "east", "north", "west"]
    start = order.index(arm)
    ways = [order[(start + step) % 4] for step in (1, 2, 3)]
    there = [way for way in ways if way in arms]
    return there[turn % len(there)]


def _vehicles(parameters: Parameters, arms: list[str], ego: LanePlace) -> list[Actor]:
    limit = float(parameters["speed_limit"])
    places = []
    ways: dict[str, str] = {}
    for slot in (f"v{index}" for index in range(count_of(VEHICLE_COUNTS, parameters))):
        arm = str(parameters[f"{slot}.from"])
        if arm not in arms:
            arm = arms[1 + sum(map(ord, slot)) % (len(arms) - 1)]
        ways[slot] = _turn(arms, arm, int(parameters[f"{slot}.turn"]))
        kind = str(parameters[f"{slot}.kind"])
        speed = min(float(parameters[f"{slot}.speed"]) * limit, BODIES[kind].speed_max)
        lane = _lane_for(parameters, arm, ways[slot])
        ahead = _ARM_LENGTH - _JUNCTION_RADIUS - float(parameters[f"{slot}.arrival"]) * speed
        places.append(LanePlace(slot, (arm, lane), ahead, speed, body_length(kind)))
    actors: list[Actor] = []
    for place in sorted(make_room(places, ego), key=lambda place: int(place.slot[1:])):
        if place.ahead > _ARM_LENGTH - _JUNCTION_RADIUS:
            continue  # pushed into the junction: no room for it
        arm, lane = place.lane
        started = place.ahead > place.length + 0.5
        actors.append(
            Vehicle(
                id=place.slot,
                kind=str(parameters[f"{place.slot}.kind"]),
                driver=str(parameters[f"{place.slot}.driver"]),
                route=[f"{arm}_in", f"{ways[place.slot]}_out"],
                depart=0.0 if started else round((place.length + 0.5 - place.ahead) / max(place.speed, 1.0), 2),
                lane=lane,
                position=round(place.ahead if started else place.length + 0.5, 2),
                speed=round(min(place.speed, limit), 2),
                manoeuvres=manoeuvres(parameters, place.slot),
            )
        )
    return actors


def _lane_for(parameters: Parameters, arm: str, way: str) -> int:
    order = ["south", "east", "north", "west"]
    step = (order.index(way) - order.index(arm)) % 4
    lanes = _lanes(parameters, arm)
    return 0 if step == 1 else lanes - 1 if step == 3 else (order.index(arm) + order.index(way)) % lanes


def _pedestrians(parameters: Parameters, arms: list[str]) -> list[Actor]:
    if not parameters["crossings"]:
        return []
    actors: list[Actor] = []
    for slot in (f"p{index}" for index in range(count_of(PEDESTRIAN_COUNTS, parameters))):
        arm = str(parameters[f"{slot}.from"])
        if arm not in arms:
            arm = arms[0]
        speed = float(parameters[f"{slot}.speed"])
        way = float(parameters[f"{slot}.arrival"]) * speed
        actors.append(
            Pedestrian(
                id=slot,
                driver=str(parameters[f"{slot}.driver"]),
                route=[f"{arm}_in", f"{_turn(arms, arm, int(parameters[f'{slot}.turn']))}_out"],
                position=round(max(0.0, _ARM_LENGTH - _JUNCTION_RADIUS - 4.0 - way), 2),
                speed=round(speed, 2),
            )
        )
    return actors
