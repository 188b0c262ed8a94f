"""What a bag tells about the run in it: how to drive it again, and what it came to."""

import math
from dataclasses import dataclass

from roadmend.core.episode_result import EpisodeResult
from roadmend.core.errors import InputError
from roadmend.core.geometry import nearest_distance
from roadmend.core.outcome import EventKind
from roadmend.core.route import Route
from roadmend.core.yaml_file import parse_yaml
from roadmend.policies.registry import POLICIES
from roadmend.recording.messages import sized
from roadmend.recording.reader import BagReader
from roadmend.recording.ticks import BagTicks
from roadmend.world.scenario import Scenario
from roadmend.world.scenario_file import parse_scenario

_MEND = "take a bag that 'roadmend run' has recorded"
RECORD = "roadmend"  # metadata record that 'roadmend run' has the recorder write


@dataclass(frozen=True, slots=True)
class RunPlan:
    """How a recorded run was driven."""

    scenario: Scenario
    scenario_file: str  # name of the attachment
    policy: str
    method: str


@dataclass(frozen=True, slots=True)
class RunOutcome:
    """What a run came to."""

    method: str
    outcome: str  # an EventKind's name
    text: str
    duration: float  # [s]
    min_distance: float | None  # [m] between the outlines of the ego and the nearest other; None if nobody came near
    interventions: int


def read_plan(reader: BagReader) -> RunPlan:
    """How the run in a bag was driven.

    Raises:
        InputError: the bag carries no scenario, an unusable one, or does not say which policy drove.
    """
    bag, record = str(reader.path), reader.metadata.get(RECORD, {})
    scenario = recorded_scenario(reader)
    if scenario is None:
        raise InputError(bag, "carries no scenario", _MEND)
    policy = record.get("policy", "")
    if policy not in POLICIES:
        what = (
            f"was driven by the policy {policy!r}, which is not here" if policy else "does not say which policy drove"
        )
        raise InputError(bag, what, _MEND)
    return RunPlan(scenario, record["scenario_file"], policy, record.get("method", ""))


def recorded_scenario(reader: BagReader) -> Scenario | None:
    """The scenario that a bag carries, if it carries one.

    Raises:
        InputError: what it carries is no scenario.
    """
    name = reader.metadata.get(RECORD, {}).get("scenario_file", "")
    attachment = reader.attachments.get(name)
    if attachment is None:
        return None
    where = f"{reader.path}: {name}"
    try:
        content = parse_yaml(attachment.data, where)
    except InputError:
        content = None
    if not isinstance(content, dict):
        raise InputError(where, "is no scenario", _MEND)
    return parse_scenario(content, where)


def recorded_outcome(ticks: BagTicks, method: str) -> RunOutcome:
    """What the run in a bag came to; ABORTED where it has no end.

    Raises:
        InputError: the bag is corrupt or holds no tick.
    """
    outcome, text, stamp = EventKind.ABORTED, "no final event was recorded", -1
    interventions, nearest = 0, math.inf
    route: Route | None = None
    for tick in ticks:
        if tick.ego is None:
            continue
        stamp = tick.stamp
        route = tick.route or route
        if tick.objects is not None:
            ego = tick.ego if route is None else sized(tick.ego, route)
            nearest = min(nearest, nearest_distance(ego, tick.objects))
        if tick.final is not None:
            outcome, text = tick.final.kind, tick.final.text  # nobody drives on the answer to this tick
        elif tick.repair is not None:
            interventions += tick.repair.intervened
    if stamp < 0:
        raise InputError(str(ticks.path), "holds no odometry", "take another bag")
    distance = nearest if math.isfinite(nearest) else None
    return RunOutcome(method, outcome.name, text, stamp * 1e-9, distance, interventions)


def driven_outcome(summary: EpisodeResult, method: str) -> RunOutcome:
    """What a run in this process came to."""
    return RunOutcome(
        method, summary.outcome.name, summary.text, summary.duration, summary.min_distance, summary.interventions
    )
