"""Descriptors of scenarios: read off the scenario alone, nothing is run."""

from collections import Counter
from collections.abc import Sequence

from roadmend.sera.descriptor import (
    BankEntry,
    Descriptor,
    EgoManoeuvre,
    Hazard,
    HazardKind,
    OutcomeStatistics,
    ParticipantKind,
    RoadDescriptor,
    RoadKind,
    Side,
    outcome_name,
)
from roadmend.world.corpus import METHOD, Case, Corpus
from roadmend.world.scenario import Scenario
from roadmend.world.scenario_actors import Actor, Pedestrian, Trigger, Vehicle
from roadmend.world.scenario_networks import HighwayExitNetwork, IntersectionNetwork, OnRampNetwork

_ENTERING, _LEAVING = "_in", "_out"  # edges of an intersection's arm


def describe(scenario: Scenario, outcomes: tuple[OutcomeStatistics, ...] = ()) -> Descriptor:
    """Describe a scenario.

    Args:
        scenario: any, also one on a SUMO network of the user's, of which less can be told.
        outcomes: what policies have made of it.
    """
    environment = scenario.environment
    kinds = Counter[ParticipantKind](
        actor.kind if isinstance(actor, Vehicle) else "pedestrian" for actor in scenario.actors
    )
    return Descriptor(
        road=_road(scenario),
        manoeuvre=_manoeuvre(scenario),
        participants=dict(sorted(kinds.items())),
        drivers=dict(sorted(Counter(actor.driver for actor in scenario.actors).items())),
        hazards=tuple(hazard for actor in scenario.actors if (hazard := _hazard(scenario, actor)) is not None),
        weather=environment.weather,
        light=environment.time_of_day,
        friction=environment.effective_friction,
        sensing_range=environment.effective_range,
        ego_speed=scenario.ego.speed,
        family=scenario.family,
        outcomes=outcomes,
    )


def entry_of(scenario: Scenario, origin: str, outcomes: tuple[OutcomeStatistics, ...] = ()) -> BankEntry:
    """The scenario as the bank keeps it."""
    return BankEntry(scenario.digest, scenario.name, origin, describe(scenario, outcomes), scenario)


def entry_of_case(case: Case, corpus: Corpus) -> BankEntry:
    """A case of a corpus, with the outcome that was found.

    Raises:
        InputError: the family has come to depend on a parameter that the case does not have.
    """
    found = OutcomeStatistics(corpus.policy, {outcome_name(case.outcome): 1}, case.min_distance, METHOD)
    return entry_of(case.scenario(), f"corpus {corpus.policy} {case.split}", (found,))


def _road(scenario: Scenario) -> RoadDescriptor:
    network = scenario.network
    match network:
        case IntersectionNetwork():
            arm = next((arm for arm in network.arms if arm.name == _arm(scenario.ego.route)), network.arms[0])
            kind: RoadKind = "tee_junction" if len(network.arms) == 3 else "intersection"
            control = "priority" if network.control == "priority_stop" else network.control  # stop or yield: one rule
            return RoadDescriptor(kind, arm.lanes, arm.speed_limit, control, network.crossings)
        case HighwayExitNetwork():
            return RoadDescriptor("highway_exit", network.lanes, network.speed_limit)
        case OnRampNetwork():
            return RoadDescriptor("on_ramp", network.lanes, network.speed_limit)
        case _:
            return RoadDescriptor("road_network")


def _manoeuvre(scenario: Scenario) -> EgoManoeuvre | None:
    route = scenario.ego.route
    match scenario.network:
        case IntersectionNetwork():
            turn = _bearing_from(scenario, _arm(route), _arm(route[-1:]))
            return None if turn is None else "left_turn" if turn == "left" else _AFTER_JUNCTION.get(turn)
        case HighwayExitNetwork():
            return "exit" if "ramp" in route else "keep_lane"
        case OnRampNetwork():
            return "merge" if "ramp" in route else "keep_lane"
        case _:
            return None


_AFTER_JUNCTION: dict[Side, EgoManoeuvre] = {"right": "right_turn", "oncoming": "straight"}


def _hazard(scenario: Scenario, actor: Actor) -> Hazard | None:
    if isinstance(actor, Pedestrian):
        crosses = isinstance(scenario.network, IntersectionNetwork) and _arm(actor.route) != _arm(actor.route[-1:])
        return Hazard("pedestrian_crossing", "pedestrian", _side(scenario, actor)) if crosses else None
    kind = hazard_kind([manoeuvre.action for manoeuvre in actor.manoeuvres])
    if kind is None:
        return None
    return Hazard(kind, actor.kind, _side(scenario, actor), _nearest([each.when for each in actor.manoeuvres]))


def hazard_kind(actions: Sequence[str]) -> HazardKind | None:
    """What a vehicle's manoeuvres come to together; None where there are none."""
    if "cut_in" in actions:
        return "cut_in_and_brake" if "brake" in actions else "cut_in"
    return "run_right_of_way" if "run" in actions else "hard_braking" if "brake" in actions else None


def _nearest(triggers: Sequence[Trigger]) -> float | None:
    return min((each.ego_distance for each in triggers if each.ego_distance is not None), default=None)


def _side(scenario: Scenario, actor: Actor) -> Side | None:
    """Where the actor starts, as the ego sees it."""
    ego = scenario.ego
    if not ego.route:
        return None
    if isinstance(scenario.network, IntersectionNetwork) and _arm(actor.route) != _arm(ego.route):
        return _bearing_from(scenario, _arm(ego.route), _arm(actor.route))
    if actor.route[0] == ego.route[0]:
        lane = actor.lane if isinstance(actor, Vehicle) else ego.lane
        return side_on_road(ego.lane, lane, is_ahead=actor.depart == 0.0 and actor.position > ego.position)
    if isinstance(scenario.network, OnRampNetwork):
        return "left" if ego.route[0] == "ramp" else "right"
    return None


def side_on_road(ego_lane: int, lane: int, *, is_ahead: bool) -> Side:
    """Where a vehicle in a lane of the ego's road is seen."""
    if lane == ego_lane:
        return "ahead" if is_ahead else "behind"
    return "left" if lane > ego_lane else "right"


def _arm(route: Sequence[str]) -> str:
    """The arm that the first edge of a route belongs to."""
    return route[0].removesuffix(_ENTERING).removesuffix(_LEAVING) if route else ""


def _bearing_from(scenario: Scenario, own: str, other: str) -> Side | None:
    """On which side an arm lies for one who enters by ``own``; None for an unknown or the same arm."""
    network = scenario.network
    assert isinstance(network, IntersectionNetwork)
    bearings = {arm.name: arm.bearing for arm in network.arms}
    if own not in bearings or other not in bearings or own == other:
        return None
    turn = (bearings[other] - bearings[own]) % 360.0  # counter-clockwise: the arm on the right comes first
    return "right" if turn < 135.0 else "left" if turn > 225.0 else "oncoming"
