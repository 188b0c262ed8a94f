"""What a run of the graph is asked for, and which nodes it then has, each with its parameters."""

import json
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from roadmend.nodes.announcement import EXTERNAL
from roadmend.nodes.provenance import provenance
from roadmend.nodes.supervisor import LOCKSTEP_SILENCE_S, REALTIME_SILENCE_S, START_S
from roadmend.policies.registry import POLICY_REGISTRY
from roadmend.repair.registry import METHOD_REGISTRY

DRAIN_S = 1.0  # for the recorder, which is stopped after all others, even if one of them went without a goodbye [s]
SUMMARY, REPAIR_SUMMARY, JOURNAL, RECORDER_SUMMARY = "sim.json", "repair.json", "repair.answers", "recorder.json"


@dataclass(frozen=True)
class GraphOptions:
    """One run of the graph."""

    scenario: Path
    policy: str = "modular"
    method: str = "rss"
    clock: str = "lockstep"
    rate: float = 1.0
    seed: int = 0
    bags: Path = Path("bags")
    name: str = ""  # of the bag; made from scenario, policy and method if empty
    record: bool = True
    viz: bool = True
    foxglove: int | None = None  # port of the live server; none if missing
    tuned: bool = False  # whether the method takes the model and the settings that were made for the policy
    ros_arguments: tuple[str, ...] = ()  # passed on to every node
    start_deadline: float | None = (
        None  # [s] for the drive to begin, 0 for none; START_S, and none with external, if None
    )
    silence: float | None = None  # [s] after which a node without a sign of life is ended; by the clock if None

    @property
    def is_external(self) -> bool:
        """Whether the policy is a node of somebody else's, which is waited for and not started."""
        return self.policy == EXTERNAL

    @property
    def begins_within(self) -> float:
        """Wall time [s] in which the drive must begin; 0 where it is waited for without an end."""
        if self.start_deadline is not None:
            return self.start_deadline
        return 0.0 if self.is_external else START_S

    @property
    def silence_limit(self) -> float:
        """Wall time [s] without a sign of life after which a node is ended."""
        if self.silence is not None:
            return self.silence
        return LOCKSTEP_SILENCE_S if self.clock == "lockstep" else REALTIME_SILENCE_S

    def writer(self, node: str) -> str:
        """The name by which a node of ours is obeyed; empty, for whoever is there first, where nodes are renamed."""
        return "" if any("__node:=" in word for word in self.ros_arguments) else node

    def stem(self) -> str:
        """How the bag's name begins if it has none."""
        policy = EXTERNAL if self.is_external else POLICY_REGISTRY.find(self.policy).label
        return f"{self.scenario.stem}-{policy}-{METHOD_REGISTRY.find(self.method).label}"


@dataclass(frozen=True, slots=True)
class Place:
    """Where a run keeps its files."""

    bag: Path | None  # None where nothing is recorded
    folder: Path  # gone after the run


def _recorder_parameters(options: GraphOptions, place: Place) -> dict[str, Any]:
    assert place.bag is not None
    told = provenance(options.scenario, options.ros_arguments)
    metadata = place.folder / "run.json"
    metadata.write_text(json.dumps(told), encoding="utf-8")
    return {
        "output": str(place.bag.parent),
        "name": place.bag.name,
        "claimed": True,
        "metadata": str(metadata),
        "attachments": [str(options.scenario)],
        "drain_limit": DRAIN_S,
        "summary": str(place.folder / RECORDER_SUMMARY),
    }


def _repair_parameters(options: GraphOptions, place: Place) -> dict[str, Any]:
    return {
        "method": options.method,
        "policy": options.policy if options.tuned else "",
        "writer": "" if options.is_external else options.writer("policy_node"),
        "trajectory": "optional" if options.is_external else "required",
        "clock": options.clock,
        "rate": float(options.rate),
        "seed": options.seed,
        "summary": str(place.folder / REPAIR_SUMMARY),
        "journal": str(place.folder / JOURNAL),
    }


@dataclass(frozen=True, slots=True)
class NodeEntry:
    """A node that runs beside the simulator, which waits for it."""

    node: str  # module of roadmend.nodes, whose node is called the same with _node behind
    parameters: Callable[[GraphOptions, Place], dict[str, Any]] = lambda _options, _place: {}
    is_wanted: Callable[[GraphOptions], bool] = lambda _options: True
    may_restart: bool = True  # if not, the run goes on without it


NODES = (  # in the order in which they are started
    NodeEntry("recorder", _recorder_parameters, lambda options: options.record, may_restart=False),
    NodeEntry("viz", is_wanted=lambda options: options.viz),
    NodeEntry(
        "foxglove", lambda options, _place: {"port": options.foxglove}, lambda options: options.foxglove is not None
    ),
    NodeEntry("policy", lambda options, _place: {"policy": options.policy}, lambda options: not options.is_external),
    NodeEntry("repair", _repair_parameters),
)
