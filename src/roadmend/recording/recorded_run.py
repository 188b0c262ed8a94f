"""What a bag tells about the run in it: how to drive it again, and what it came to."""

import hashlib
import json
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from roadmend.core.command import Command
from roadmend.core.episode_result import EpisodeResult, ResultBuilder
from roadmend.core.errors import InputError
from roadmend.core.geometry import nearest_distance
from roadmend.core.outcome import Event, EventKind
from roadmend.core.route import Route
from roadmend.core.scene import ObjectList, Scene
from roadmend.core.tick import INTERVAL_NS, Tick
from roadmend.core.yaml_file import parse_yaml
from roadmend.policies.registry import POLICY_REGISTRY
from roadmend.recording.layout import RECORD
from roadmend.recording.messages import sized
from roadmend.recording.reader import BagReader
from roadmend.recording.ticks import BagTicks
from roadmend.world.scenario import Scenario
from roadmend.world.scenario_file import parse_scenario

_MEND = "take a bag that 'roadmend run' has recorded"


@dataclass(frozen=True, slots=True)
class RunPlan:
    """How a recorded run was driven."""

    scenario: Scenario
    scenario_file: str  # name of the attachment
    policy: str
    method: str
    policy_parameters: dict[str, Any]  # by name; the policy's defaults where the bag tells none


def read_plan(reader: BagReader, policy: str = "") -> RunPlan:
    """How the run in a bag was driven.

    Args:
        reader: of the bag.
        policy: who drove, where the user says it; otherwise it is what the bag says, unless that is code from outside.

    Raises:
        InputError: the bag carries no scenario, an unusable one, or does not say which policy drove.
    """
    bag, record = str(reader.path), reader.metadata.get(RECORD, {})
    scenario = recorded_scenario(reader)
    if scenario is None:
        raise InputError(bag, "carries no scenario", _MEND)
    driver = policy or _policy(bag, record)
    parameters = _parameters(bag, record, driver) if driver == record.get("policy") else {}
    return RunPlan(scenario, record["scenario_file"], driver, record.get("method", ""), parameters)


def _policy(bag: str, record: Mapping[str, str]) -> str:
    """Who drove, as the bag says."""
    policy = record.get("policy", "")
    if not policy:
        raise InputError(bag, "does not say which policy drove", _MEND)
    if record.get("policy_is_own") == "false":
        what = f"was driven by {policy}, a node of somebody else's"
        raise InputError(bag, what, "a class may drive in its place: 'bag need' and 'bag resimulate' take --policy")
    if ":" in policy:
        what = f"was driven by {policy!r}, code from outside that a bag makes nobody run"
        raise InputError(bag, what, f"name it yourself: --policy {policy}")
    try:
        POLICY_REGISTRY.find_installed(policy)
    except InputError:
        raise InputError(bag, f"was driven by the policy {policy!r}, which is not here", _MEND) from None
    return policy


def _parameters(bag: str, record: Mapping[str, str], policy: str) -> dict[str, Any]:
    """What a policy drove with: the graph tells its node's parameters, of which the policy's have its label before them.

    What this version knows no more is left out: the run is then held against the recorded one.
    """
    try:
        told = json.loads(record.get("policy_parameters") or "{}")
    except ValueError:
        told = None
    if not isinstance(told, dict):
        raise InputError(bag, "does not say what its policy's parameters were", _MEND)
    found = POLICY_REGISTRY.find(policy)
    prefix = f"{found.label}."
    if any(name.startswith(prefix) for name in told):
        told = {name.removeprefix(prefix): value for name, value in told.items() if name.startswith(prefix)}
    return {name: value for name, value in told.items() if name in found.entry.parameters.model_fields}


def recorded_scenario(reader: BagReader) -> Scenario | None:
    """The scenario that a bag carries, if it carries one.

    Raises:
        InputError: what it carries is no scenario, or another one than was driven.
    """
    record = reader.metadata.get(RECORD, {})
    name = record.get("scenario_file", "")
    attachment = reader.attachments.get(name)
    if attachment is None:
        return None
    where = f"{reader.path}: {name}"
    digest = hashlib.sha256(attachment.data).hexdigest()
    if (record.get("scenario_sha256") or digest) != digest:
        raise InputError(
            where, "is not the scenario that was driven: it was altered, or is another of that name", _MEND
        )
    try:
        content = parse_yaml(attachment.data, where)
    except InputError:
        content = None
    if not isinstance(content, dict):
        raise InputError(where, "is no scenario", _MEND)
    return parse_scenario(content, where)


def recorded_result(ticks: BagTicks, plan: RunPlan) -> EpisodeResult:
    """What the run in a bag came to, as far as the bag tells; ABORTED where it has no end.

    Raises:
        InputError: the bag is corrupt or holds no tick.
    """
    builder = ResultBuilder(plan.scenario.name, plan.policy, plan.method)
    route: Route | None = None
    tick: Tick | None = None
    for recorded in ticks:
        if recorded.ego is None:
            continue
        route = recorded.route or route
        ego = recorded.ego if route is None else sized(recorded.ego, route)
        objects = recorded.objects or ObjectList.empty()
        scene = Scene(recorded.stamp * 1e-9, ego, objects, np.empty(0, np.uint8))
        distance = nearest_distance(ego, objects)
        tick = Tick(recorded.stamp // INTERVAL_NS, scene, distance, tuple(recorded.events), recorded.final)
        builder.see(tick)
        command = Command(0.0, 0.0)
        if tick.final is None and recorded.repair is not None:  # nobody drives on the answer to the final tick
            builder.repair(recorded.repair)
            command = recorded.repair.command
        builder.command(tick, command)
    if tick is None:
        raise InputError(str(ticks.path), "holds no odometry", "take another bag")
    if builder.final is None:
        builder.note(Event(builder.duration, EventKind.ABORTED, "no final event was recorded"))
    return builder.result()
