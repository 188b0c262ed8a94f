"""Crashes in the scenario language, for the tests of stage II."""

from roadmend.safe.construction import CrashRole
from roadmend.safe.dsl import (
    Action,
    Compass,
    CrashScenario,
    DescribedCollision,
    DescribedEnvironment,
    DescribedRoadNetwork,
    DescribedVehicle,
    DslModel,
    Manoeuvre,
    Position,
    RoadType,
    Time,
    Weather,
)

DAY = DescribedEnvironment(Time.DAYTIME, Weather.CLEAR)


def vehicle(position="W2E", action="Move Forward", manoeuvre=None, *, model="Sedan", limit=35):
    return DescribedVehicle(
        DslModel(model) if model else None,
        Position(position) if position else None,
        Action(action) if isinstance(action, str) else action,
        limit,
        Manoeuvre(manoeuvre) if manoeuvre else None,
    )


def crash(road_type, *vehicles, lanes=2, stem=None, collisions=(), environment=DAY):
    kind = RoadType(road_type) if road_type else None
    road = DescribedRoadNetwork(kind, lanes, Compass(stem) if stem else None)
    return CrashScenario(road, vehicles, environment, tuple(collisions))


def role(what, ego=0, report="sample"):
    return CrashRole(report, what, ego)


HEAD_ON = crash("Straight", vehicle("W2E"), vehicle("E2W", manoeuvre="Enter the Wrong Way"))
CROSSING = crash("Intersection", vehicle("W2E"), vehicle("S2N", model="SUV"), collisions=[DescribedCollision(2, 1)])
ALL = {
    "straight": HEAD_ON,
    "curve": crash("Curve", vehicle("N2S", limit=45), vehicle("S2N", model="Semi Truck", limit=45), lanes=4),
    "intersection": CROSSING,
    "tee": crash("T-intersection", vehicle("E2W", "Turn Left"), vehicle("S2N"), lanes=3, stem="East"),
    "merging": crash("Merging", vehicle("Main road", limit=65), vehicle("On-ramp", manoeuvre="Merge"), lanes=4),
    "rear end": crash(
        "Straight", vehicle("W2E"), vehicle("W2E", model="Pickup"), lanes=4, collisions=[DescribedCollision(1, 2)]
    ),
    "lane change": crash("Straight", vehicle("W2E"), vehicle("W2E", manoeuvre="Changing Lane"), lanes=4),
    "parked": crash("Straight", vehicle("W2E"), vehicle("W2E", manoeuvre="Stop"), lanes=2),
    "driveway": crash("Straight", vehicle("W2E"), vehicle("N2S", "Turn Left"), lanes=2),
    "alone": crash("Curve", vehicle("W2E")),
    "open": crash(
        None,
        vehicle(None, None, model=None, limit=None),
        vehicle(None, None, model=None, limit=None),
        lanes=None,
        environment=DescribedEnvironment(None, None),
    ),
    "pile-up": crash("Straight", vehicle(), vehicle(model="Semi Truck"), vehicle(), vehicle(), lanes=2),
}
