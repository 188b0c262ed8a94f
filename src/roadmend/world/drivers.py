"""Who shares the road with the ego: bodies by kind, habits by driver, as SUMO vehicle types."""

import random
from dataclasses import dataclass

from roadmend.core.scene import ObjectKind
from roadmend.world.scenario import Environment
from roadmend.world.scenario_actors import Vehicle


@dataclass(frozen=True, slots=True)
class Body:
    """Size and abilities of a kind of vehicle."""

    vehicle_class: str  # SUMO vClass
    length: float  # [m]
    width: float  # [m]
    speed_max: float  # [m/s]
    acceleration: float  # [m/s2]
    deceleration: float  # [m/s2]


BODIES: dict[str, Body] = {
    "car": Body("passenger", 4.6, 1.8, 55.0, 2.6, 4.5),
    "suv": Body("passenger", 4.9, 1.95, 55.0, 2.6, 4.5),
    "minivan": Body("passenger", 5.2, 2.0, 50.0, 2.4, 4.5),
    "pickup": Body("passenger", 5.8, 2.05, 50.0, 2.4, 4.3),
    "truck": Body("truck", 10.0, 2.5, 27.0, 1.3, 4.0),
    "semi_truck": Body("trailer", 18.0, 2.55, 27.0, 0.9, 3.5),
    "bus": Body("bus", 12.0, 2.5, 27.0, 1.2, 4.0),
    "motorcycle": Body("motorcycle", 2.2, 0.8, 55.0, 4.0, 6.0),
    "bicycle": Body("bicycle", 1.7, 0.6, 6.5, 1.2, 3.0),
}

KINDS: dict[str, ObjectKind] = {
    "passenger": ObjectKind.CAR,
    "private": ObjectKind.CAR,
    "taxi": ObjectKind.CAR,
    "evehicle": ObjectKind.CAR,
    "hov": ObjectKind.CAR,
    "vip": ObjectKind.CAR,
    "authority": ObjectKind.CAR,
    "army": ObjectKind.TRUCK,
    "emergency": ObjectKind.CAR,
    "custom1": ObjectKind.CAR,
    "custom2": ObjectKind.CAR,
    "delivery": ObjectKind.TRUCK,
    "truck": ObjectKind.TRUCK,
    "trailer": ObjectKind.TRUCK,
    "bus": ObjectKind.BUS,
    "coach": ObjectKind.BUS,
    "tram": ObjectKind.BUS,
    "motorcycle": ObjectKind.MOTORCYCLE,
    "moped": ObjectKind.MOTORCYCLE,
    "scooter": ObjectKind.BICYCLE,
    "bicycle": ObjectKind.BICYCLE,
    "pedestrian": ObjectKind.PEDESTRIAN,
    "wheelchair": ObjectKind.PEDESTRIAN,
}

PEDESTRIAN_LENGTH = 0.5  # [m]
PEDESTRIAN_WIDTH = 0.6  # [m]

# SUMO parameters by driver; names as in SUMO's documentation of vehicle types.
_HABITS: dict[str, dict[str, float | str]] = {
    "careful": {
        "tau": 1.6,
        "sigma": 0.2,
        "minGap": 3.0,
        "speedFactor": 0.9,
        "lcAssertive": 0.7,
        "jmTimegapMinor": 2.5,
        "impatience": 0.0,
    },
    "normal": {
        "tau": 1.1,
        "sigma": 0.4,
        "minGap": 2.5,
        "speedFactor": 1.0,
        "lcAssertive": 1.0,
        "jmTimegapMinor": 1.2,
        "impatience": 0.1,
    },
    "aggressive": {
        "tau": 0.6,
        "sigma": 0.5,
        "minGap": 1.2,
        "speedFactor": 1.15,
        "lcAssertive": 3.0,
        "lcPushy": 0.6,
        "jmTimegapMinor": 0.6,
        "impatience": 0.6,
        "jmDriveAfterYellowTime": 3.0,
    },
    "reckless": {
        "tau": 0.4,
        "sigma": 0.6,
        "minGap": 0.8,
        "speedFactor": 1.3,
        "lcAssertive": 5.0,
        "lcPushy": 1.0,
        "jmTimegapMinor": 0.3,
        "impatience": 1.0,
        "jmDriveAfterYellowTime": 5.0,
        "jmDriveAfterRedTime": 4.0,
        "jmIgnoreFoeSpeed": 70.0,
    },
}

IGNORING = {"reckless": 0.8}  # share of a kind of drivers who look at nobody at junctions


def ignores_others(vehicle: Vehicle, seed: int) -> bool:
    """Whether a driver looks at nobody at junctions, for good: drawn from the scenario's seed and the vehicle's name.

    SUMO would draw it anew at every look, for one person after another in the order of their pointers until it heeds
    one: how often would hang on the heap's layout, and with it all that the driver's random numbers decide after that.
    """
    share = IGNORING.get(vehicle.driver, 0.0)
    return share > 0.0 and random.Random(f"ignores others:{seed}:{vehicle.id}").random() < share


def type_name(vehicle: Vehicle, *, ignoring: bool) -> str:
    """Name of the SUMO vehicle type: of all that are of this kind and drive like this, or of this one alone."""
    name = f"{vehicle.kind}_{vehicle.driver}" + ("_ignoring" if ignoring else "")
    return name if vehicle.speed_factor is None else f"{name}_{vehicle.id}"


def vehicle_type(vehicle: Vehicle, environment: Environment, *, ignoring: bool) -> dict[str, str]:
    """Attributes of the SUMO vType, the road's friction taken into account."""
    kind, driver, speed_factor = vehicle.kind, vehicle.driver, vehicle.speed_factor
    body = BODIES[kind]
    grip = min(1.0, environment.effective_friction / 0.9)
    habits = dict(_HABITS[driver])
    if ignoring:
        habits["jmIgnoreFoeProb"] = 1.0
    if speed_factor is not None:
        habits["speedFactor"] = speed_factor
    habits["speedFactor"] = float(habits["speedFactor"]) * (0.7 + 0.3 * grip)
    attributes: dict[str, float | str] = {
        "vClass": body.vehicle_class,
        "length": body.length,
        "width": body.width,
        "maxSpeed": body.speed_max,
        "desiredMaxSpeed": body.speed_max,
        "accel": body.acceleration * (0.5 + 0.5 * grip),
        "decel": body.deceleration * grip,
        "emergencyDecel": 9.0 * grip,
        "speedDev": 0,
        "latAlignment": "right" if kind == "bicycle" else "center",
        **habits,
    }
    return {name: value if isinstance(value, str) else f"{value:.4g}" for name, value in attributes.items()}


def entry_speed(vehicle: Vehicle, speed_factor: float, limit: float) -> str:
    """SUMO's departSpeed of a vehicle whose driver goes at ``speed_factor`` of the limit [m/s] of the lane it comes in on.

    The scenario's, as far as the driver wants to go so fast there: SUMO refuses a faster entry.
    """
    if vehicle.speed is None:
        return "max"
    fastest = BODIES[vehicle.kind].speed_max
    wanted = min(limit * speed_factor, fastest, fastest * speed_factor)
    return f"{min(vehicle.speed, wanted - 0.01):.2f}"


def pedestrian_type(driver: str, speed: float) -> dict[str, str]:
    """Attributes of the SUMO vType of a person on foot."""
    hurry = {"careful": 0.0, "normal": 0.1, "aggressive": 0.6, "reckless": 1.0}[driver]
    attributes = {
        "vClass": "pedestrian",
        "maxSpeed": f"{speed:.4g}",
        "desiredMaxSpeed": f"{speed:.4g}",
        "speedFactor": "1",
        "speedDev": "0",
        "impatience": f"{hurry:g}",
    }
    if driver == "reckless":
        attributes |= {"jmDriveAfterRedTime": "20", "jmIgnoreFoeProb": "1"}
    return attributes
