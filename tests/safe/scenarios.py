"""Scenarios of every kind that the language can express, for hypothesis."""

from hypothesis import strategies as st

from roadmend.safe.dsl import (
    MAX_LANES,
    MAX_SPEED_LIMIT,
    Action,
    Compass,
    Control,
    CrashScenario,
    DescribedCollision,
    DescribedEnvironment,
    DescribedImpact,
    DescribedRoadNetwork,
    DescribedVehicle,
    DslModel,
    Manoeuvre,
    Position,
    RoadType,
    Side,
    StruckObject,
    Time,
    Weather,
)

RAMP = [Position.MAIN_ROAD, Position.ON_RAMP]
COMPASS = [position for position in Position if position not in RAMP]

_finite = st.floats(-1e6, 1e6, allow_nan=False)
_actions = (
    st.none() | st.sampled_from(Action) | st.lists(st.tuples(_finite, _finite), min_size=2, max_size=4).map(tuple)
)
_values = (
    st.none()
    | st.booleans()
    | st.integers(-9, 9)
    | st.text('aé"\\<>:#\n', max_size=5)
    | st.lists(st.integers(), max_size=2)
)
_extras = st.dictionaries(st.from_regex(r"x-[a-z][a-z0-9-]{0,6}", fullmatch=True), _values, max_size=2)


@st.composite
def scenarios(draw):
    road_type = draw(st.none() | st.sampled_from(RoadType))
    stem = draw(st.none() | st.sampled_from(Compass)) if road_type is RoadType.T_INTERSECTION else None
    positions = st.none() | st.sampled_from(RAMP if road_type is RoadType.MERGING else COMPASS)
    vehicle = st.builds(
        DescribedVehicle,
        st.none() | st.sampled_from(DslModel),
        positions,
        _actions,
        st.none() | st.integers(1, MAX_SPEED_LIMIT) | st.floats(0.5, MAX_SPEED_LIMIT),
        st.none() | st.sampled_from(Manoeuvre),
        _extras,
    )
    vehicles = tuple(draw(st.lists(vehicle, min_size=1, max_size=4)))
    pairs = [
        (one, other) for one in range(1, len(vehicles) + 1) for other in range(1, len(vehicles) + 1) if one != other
    ]
    sides = st.none() | st.sampled_from(Side)
    collision = (
        st.builds(lambda pair, *both: DescribedCollision(*pair, *both), st.sampled_from(pairs), sides, sides)
        if pairs
        else st.nothing()
    )
    impact = st.builds(
        DescribedImpact,
        st.integers(1, len(vehicles)),
        st.none() | st.sampled_from(StruckObject),
        sides,
        st.sampled_from((None, Side.LEFT, Side.RIGHT)),
    )
    return CrashScenario(
        DescribedRoadNetwork(
            road_type,
            draw(st.none() | st.integers(1, MAX_LANES)),
            stem,
            draw(st.none() | st.booleans()),
            draw(st.sampled_from((None, Side.LEFT, Side.RIGHT))),
            draw(st.none() | st.sampled_from(Control)),
        ),
        vehicles,
        DescribedEnvironment(
            draw(st.none() | st.sampled_from(Time)), draw(st.none() | st.sampled_from(Weather)), draw(_extras)
        ),
        tuple(draw(st.lists(collision, max_size=2))) if pairs else (),
        tuple(draw(st.lists(impact, max_size=2))),
        draw(_extras),
    )
