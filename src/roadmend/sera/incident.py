"""An incident: a failure of an episode or an intervention of the repair node, as one bag tells it."""

from dataclasses import dataclass
from typing import Literal

from roadmend.sera.descriptor import EgoManoeuvre, HazardKind, OutcomeName, ParticipantKind, Side
from roadmend.sera.pattern import Where
from roadmend.world.scenario_actors import DriverName

IncidentKind = Literal["collision", "timeout", "off_route", "intervention"]
PlaceKind = Literal[
    "before_junction",
    "in_junction",
    "after_junction",
    "at_crossing",
    "ramp",
    "acceleration_lane",
    "highway",
    "exit_lane",
    "lane",
]
EgoAction = Literal["turning_left", "turning_right", "crossing_straight", "changing_lane", "standing", "driving_on"]
Encounter = Literal[
    "crossing_from_left",
    "crossing_from_right",
    "oncoming_turn",
    "oncoming",
    "cut_in",
    "braking_leader",
    "standing_leader",
    "slow_leader",
    "follower",
    "in_target_lane",
    "alongside",
    "pedestrian",
]
Verdict = Literal[
    "no_method",
    "not_at_all",
    "too_late",
    "too_weak",
    "struck_while_braking",
    "held_the_ego",
    "not_involved",
    "needed",
    "close",
    "no_need_seen",
    "controlled_stop",
]

OUTCOMES: dict[IncidentKind, OutcomeName | None] = {
    "collision": "COLLISION",
    "timeout": "TIMEOUT",
    "off_route": "OFF_ROUTE",
    "intervention": None,
}


@dataclass(frozen=True, slots=True)
class IncidentPlace:
    """Where on its route the ego was."""

    kind: PlaceKind
    lane: int  # of the route: how many of its lane changes lie behind the ego
    right_of_way: str | None = None  # the rule for the ego at the junction or crossing, in small letters
    distance: float | None = None  # [m] from the ego's front to that stop line, negative behind it


@dataclass(frozen=True, slots=True)
class IncidentEgo:
    """What the ego was doing."""

    action: EgoAction
    speed: float  # [m/s]
    manoeuvre: EgoManoeuvre | None = None  # its task in the scenario; None where the bag does not tell


@dataclass(frozen=True, slots=True)
class Other:
    """Whom it had to do with."""

    id: int  # of the object in the bag
    kind: ParticipantKind | None  # None where it was not recognised
    encounter: Encounter
    side: Side  # of the ego when the encounter began
    speed: float  # [m/s]
    braking: float  # [m/s2] its hardest deceleration during the encounter
    hazard: HazardKind | None = None  # what it did that the ego had to cope with; None where it did nothing wrong
    name: str = ""  # in the scenario; empty where the bag does not tell
    driver: DriverName | None = None  # its habit; None where the bag does not tell


@dataclass(frozen=True, slots=True)
class RepairAccount:
    """What the repair node did about it, in the seconds before a failure or during an intervention."""

    verdict: Verdict
    method: str  # empty where the bag does not tell
    states: tuple[tuple[str, float], ...]  # states of the node one after another, each with how long it held [s]
    begin: float | None = None  # [s] of simulation time at which it first stepped in
    frames: int = 0  # ticks whose command it replaced
    dose: float = 0.0  # [s] sum of |policy's action - final action| * tick
    plan_gap: float | None = None  # [m] least gap on the policy's plan to the others as they were recorded


@dataclass(frozen=True, slots=True)
class Incident:
    """One failure or one intervention."""

    kind: IncidentKind
    bag: str
    time: float  # [s] of simulation time at which it happened or began
    where: Where
    place: IncidentPlace
    ego: IncidentEgo
    other: Other | None  # None where nobody was involved, or the bag does not tell who
    repair: RepairAccount
    manner: str = ""  # how the outlines met: "ran into", "hit in the side", ...
    at_fault: bool | None = None  # whether the collision is the ego's fault
    avoidable: float | None = None  # [s] before contact at which full braking would last have avoided it: an estimate
    scenario: str = ""  # digest; empty where the bag carries no scenario
    policy: str = ""  # that drove; empty where the bag does not tell
    text: str = ""  # of the final event
