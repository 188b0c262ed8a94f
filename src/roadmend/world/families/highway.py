"""S4 highway exit and S5 on-ramp merging."""

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
from roadmend.world.scenario_actors import Actor, Vehicle
from roadmend.world.scenario_networks import HighwayExitNetwork, OnRampNetwork
from roadmend.world.space import Choice, Dimension, Parameters, Uniform, Whole

VEHICLES = 28  # slots
_KIND = Choice({"car": 0.66, "truck": 0.2, "bus": 0.04, "motorcycle": 0.1})
_MANOEUVRES = {"none": 0.52, "brake": 0.14, "cut_in": 0.17, "swoop": 0.17}
VEHICLE_COUNTS: Counts = {"light": (3, 8), "medium": (9, 16), "dense": (17, VEHICLES)}


def _vehicle_slot(slot: str) -> dict[str, Dimension]:
    dimensions: dict[str, Dimension] = {
        f"{slot}.kind": _KIND,
        f"{slot}.driver": DRIVER,
        f"{slot}.lane": Uniform(0.0, 1.0),
        f"{slot}.offset": Uniform(-160.0, 180.0),
        f"{slot}.speed": Uniform(0.65, 1.05),
        f"{slot}.side": Uniform(0.0, 1.0),
    }
    return dimensions | slot_manoeuvre(slot, _MANOEUVRES)


_SHARED: dict[str, Dimension] = {
    "lanes": Whole(2, 4),
    "speed_limit": Choice({22.22: 0.2, 27.78: 0.4, 33.33: 0.4}),
    "ramp_speed_limit": Uniform(13.0, 20.0),
    "density": Choice({"light": 0.3, "medium": 0.4, "dense": 0.3}),
    "fill": Uniform(0.0, 1.0),
    "ego_lane": Uniform(0.0, 1.0),
    "ego_position": Uniform(30.0, 90.0),
    "ego_speed": Uniform(0.7, 0.95),
    **WEATHER,
    **{key: value for index in range(VEHICLES) for key, value in _vehicle_slot(f"v{index}").items()},
}
EXIT_SPACE: dict[str, Dimension] = {
    "approach_length": Uniform(400.0, 600.0),
    "lane_length": Uniform(150.0, 320.0),
    **_SHARED,
}
RAMP_SPACE: dict[str, Dimension] = {
    "ramp_length": Uniform(120.0, 220.0),
    "lane_length": Uniform(140.0, 300.0),
    **_SHARED,
    "lanes": Whole(1, 3),
}


def build_exit(parameters: Parameters, name: str, seed: int) -> Scenario:
    """The highway exit that a point of EXIT_SPACE stands for."""
    lanes = int(parameters["lanes"])
    limit = float(parameters["speed_limit"])
    network = HighwayExitNetwork(
        lanes=lanes,
        speed_limit=limit,
        ramp_speed_limit=float(parameters["ramp_speed_limit"]),
        approach_length=float(parameters["approach_length"]),
        lane_length=float(parameters["lane_length"]),
        ramp_length=250.0,
    )
    # At most two lanes away from the exit: the way is too short for more.
    lane = min(int(float(parameters["ego_lane"]) * lanes), lanes - 1, 1)
    ego = Ego(
        route=["approach", "diverge", "ramp"],
        lane=lane,
        position=float(parameters["ego_position"]) + 100.0,
        speed=round(float(parameters["ego_speed"]) * limit, 2),
        goal=100.0,
    )
    here = LanePlace("ego", ("approach", lane), ego.position + 0.5 * ego.length, ego.speed, ego.length)
    places, ways = [], {}
    for slot in _slots(parameters):
        kind = str(parameters[f"{slot}.kind"])
        own_lane = min(int(float(parameters[f"{slot}.lane"]) * lanes), lanes - 1)
        speed = _speed(parameters, slot, limit)
        ahead = here.ahead + float(parameters[f"{slot}.offset"])
        places.append(LanePlace(slot, ("approach", own_lane), ahead, speed, body_length(kind)))
        leaves = float(parameters[f"{slot}.side"]) < (0.45 if own_lane == 0 else 0.1)
        ways[slot] = ["approach", "diverge", "ramp" if leaves else "mainline"]
    actors = _actors(parameters, make_room(places, here), ways, {"approach": network.approach_length})
    return Scenario(
        name=name,
        family="S4",
        seed=seed,
        time_limit=75.0,
        network=network,
        ego=ego,
        actors=actors,
        environment=environment(parameters),
    )


def build_ramp(parameters: Parameters, name: str, seed: int) -> Scenario:
    """The on-ramp that a point of RAMP_SPACE stands for."""
    lanes = int(parameters["lanes"])
    limit = float(parameters["speed_limit"])
    ramp_limit = float(parameters["ramp_speed_limit"])
    network = OnRampNetwork(
        lanes=lanes,
        speed_limit=limit,
        ramp_speed_limit=ramp_limit,
        ramp_length=float(parameters["ramp_length"]),
        lane_length=float(parameters["lane_length"]),
        approach_length=400.0,
    )
    ego = Ego(
        route=["ramp", "merge", "mainline"],
        position=0.5 * float(parameters["ego_position"]),
        speed=round(float(parameters["ego_speed"]) * ramp_limit, 2),
        goal=150.0,
    )
    here = LanePlace("ego", ("ramp", 0), ego.position + 0.5 * ego.length, ego.speed, ego.length)
    meeting = (network.ramp_length - ego.position) / max(0.9 * ramp_limit, 1.0)  # [s] until the ego may merge
    places, ways = [], {}
    for slot in _slots(parameters):
        kind = str(parameters[f"{slot}.kind"])
        if float(parameters[f"{slot}.side"]) < 0.12:
            speed = _speed(parameters, slot, ramp_limit)
            places.append(
                LanePlace(
                    slot, ("ramp", 0), here.ahead + 0.5 * float(parameters[f"{slot}.offset"]), speed, body_length(kind)
                )
            )
            ways[slot] = ["ramp", "merge", "mainline"]
            continue
        # More of the traffic keeps to the right, where the ego must find its gap.
        lane = min(int(float(parameters[f"{slot}.lane"]) ** 1.6 * lanes), lanes - 1)
        speed = _speed(parameters, slot, limit)
        ahead = network.approach_length - speed * meeting + float(parameters[f"{slot}.offset"])
        places.append(LanePlace(slot, ("approach", lane), ahead, speed, body_length(kind)))
        ways[slot] = ["approach", "merge", "mainline"]
    lengths = {"approach": network.approach_length, "ramp": network.ramp_length}
    actors = _actors(parameters, make_room(places, here), ways, lengths)
    return Scenario(
        name=name,
        family="S5",
        seed=seed,
        time_limit=75.0,
        network=network,
        ego=ego,
        actors=actors,
        environment=environment(parameters),
    )


def _slots(parameters: Parameters) -> list[str]:
    return [f"v{index}" for index in range(count_of(VEHICLE_COUNTS, parameters))]


def _speed(parameters: Parameters, slot: str, limit: float) -> float:
    share = float(parameters[f"{slot}.speed"])
    return min(share * limit, BODIES[str(parameters[f"{slot}.kind"])].speed_max)


def _actors(
    parameters: Parameters, places: list[LanePlace], ways: dict[str, list[str]], lengths: dict[str, float]
) -> list[Actor]:
    actors: list[Actor] = []
    for place in sorted(places, key=lambda place: int(place.slot[1:])):
        edge, lane = place.lane
        if place.ahead > lengths[edge] - 30.0:
            continue  # pushed past the first edge: no room for it
        started = place.ahead > place.length + 0.5
        actors.append(
            Vehicle(
                id=place.slot,
                kind=str(parameters[f"{place.slot}.kind"]),
                driver=str(parameters[f"{place.slot}.driver"]),
                route=ways[place.slot],
                depart=0.0 if started else round((place.length + 0.5 - place.ahead) / max(place.speed, 1.0), 2),
                lane=lane,
                position=round(place.ahead if started else place.length + 0.5, 2),
                speed=round(place.speed, 2),
                manoeuvres=manoeuvres(parameters, place.slot),
            )
        )
    return actors
