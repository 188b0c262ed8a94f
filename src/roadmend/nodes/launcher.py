"""Starts the graph for one episode as separate processes, supervises them and stops them cleanly."""

import contextlib
import json
import os
import signal
import tempfile
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from types import FrameType
from typing import Any, NoReturn

from roadmend.core.claim import claimed_bag
from roadmend.core.episode_result import EpisodeResult
from roadmend.core.errors import InputError, RoadmendError
from roadmend.core.interrupt import InterruptedWorkError
from roadmend.core.spell import Spell
from roadmend.nodes.announcement import EXTERNAL, Announcement
from roadmend.nodes.children import Child, stop
from roadmend.nodes.domain import own_domain
from roadmend.nodes.fault import read_fault
from roadmend.nodes.provenance import provenance
from roadmend.nodes.ros_arguments import SHARED, check_addressees, check_taken, shared_parameters
from roadmend.policies.registry import POLICY_REGISTRY
from roadmend.repair.registry import METHOD_REGISTRY

POLL_S = 0.05
RESTARTS_MAX = 5  # of one node in one run
STOP_S = 2.8  # everything is gone this long after an interrupt [s]
DRAIN_S = 1.0  # for the recorder, which is stopped after all others, even if one of them went without a goodbye [s]
SIM_STOP_S = 0.8  # of which the simulator may take [s] to report the abort
BAD_INPUT = 2  # exit code of a node that refuses its parameters


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

    @property
    def is_external(self) -> bool:
        """Whether the policy is a node of somebody else's, which is waited for and not started."""
        return self.policy == EXTERNAL

    def stem(self) -> str:
        """How the bag's name begins if it has none."""
        policy = EXTERNAL if self.is_external else POLICY_REGISTRY.find(self.policy).label
        return f"{self.scenario.stem}-{policy}-{METHOD_REGISTRY.find(self.method).label}"


@dataclass(frozen=True, slots=True)
class _Place:
    """Where a run keeps its files."""

    bag: Path | None  # None where nothing is recorded
    folder: Path  # gone after the run


def _recorder_parameters(options: GraphOptions, place: _Place) -> dict[str, Any]:
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
    }


def _repair_parameters(options: GraphOptions, place: _Place) -> dict[str, Any]:
    return {
        "method": options.method,
        "policy": options.policy if options.tuned else "",
        "trajectory": "optional" if options.is_external else "required",
        "clock": options.clock,
        "rate": float(options.rate),
        "seed": options.seed,
        "summary": str(place.folder / "repair.json"),
    }


@dataclass(frozen=True, slots=True)
class NodeEntry:
    """A node that runs beside the simulator, which waits for it."""

    node: str  # module of roadmend.nodes, whose node is called the same with _node behind
    parameters: Callable[[GraphOptions, _Place], dict[str, Any]] = lambda _options, _place: {}
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


@dataclass(frozen=True)
class RunResult:
    """What came out of one run."""

    episode: EpisodeResult
    clock: str
    watchdog_ticks: int
    restarts: int
    real_time_factor: float
    bag: str
    recording_error: str = ""  # why the bag is not complete; empty if it is
    policy_error: str = ""  # how the policy failed first, so that the vehicle braked; empty if it did not
    method_error: str = ""  # how the repair method failed first, so that the guard's rule answered; empty if it did not
    warnings: tuple[str, ...] = ()  # who else took part, in one line each
    configuration: dict[str, Any] = field(default_factory=dict)  # by node: what each has announced of itself

    def as_dict(self) -> dict[str, Any]:
        """Plain values, for JSON: the episode's figures without its peaks, and what is the run's own."""
        figures = {name: value for name, value in self.episode.figures().items() if not name.startswith("peak_")}
        return figures | {name: value for name, value in vars(self).items() if name != "episode"}


class InterruptedRunError(InterruptedWorkError):
    """The user stopped the run; the bag is complete up to that point."""

    def __init__(self, result: RunResult | None) -> None:
        super().__init__()
        self.result = result


def run_graph(options: GraphOptions, report: Callable[[str, float], None] = lambda _text, _time: None) -> RunResult:
    """Run one episode in the graph.

    Args:
        options: what to run and how.
        report: called with a word on the state and the wall time [s] since the start, several times a second.

    Raises:
        InputError: a node refuses its parameters, or the bag's name is no name or taken.
        RoadmendError: a node failed beyond repair.
        InterruptedRunError: SIGINT or SIGTERM arrived.
    """
    check_addressees(options.ros_arguments)
    with (
        claimed_bag(options.bags, options.name, options.stem, is_wanted=options.record) as bag,
        own_domain() as domain,
        tempfile.TemporaryDirectory(prefix="roadmend-run-") as folder,
        _signals() as stopped,
    ):
        return _GraphRun(options, bag, Path(folder), domain, report).supervise(stopped)


class _GraphRun:
    def __init__(
        self, options: GraphOptions, bag: Path | None, folder: Path, domain: int, report: Callable[[str, float], None]
    ) -> None:
        self._options = options
        reach = os.environ.get("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")
        self._environment = {"ROS_DOMAIN_ID": str(domain), "ROS_AUTOMATIC_DISCOVERY_RANGE": reach}
        self._bag = bag
        self._folder = folder
        self._report = report
        self._begun = time.monotonic()
        self._gone: set[str] = set()
        self._said: set[str] = set()  # lines of the simulator's that were passed on
        shared = shared_parameters(options.ros_arguments)
        self._environment[SHARED] = json.dumps(sorted(shared))
        entries = [entry for entry in NODES if entry.is_wanted(options)]
        self._sim = self._child(
            "sim",
            may_restart=False,
            scenario=str(options.scenario),
            clock=options.clock,
            rate=float(options.rate),
            summary=str(folder / "sim.json"),
            driver="external" if options.is_external else "own",
            wait_for=[f"{entry.node}_node" for entry in entries],
        )
        place = _Place(bag, folder)
        self._nodes = [
            self._child(entry.node, may_restart=entry.may_restart, **entry.parameters(options, place))
            for entry in entries
        ]

    def _child(self, node: str, *, may_restart: bool, **parameters: Any) -> Child:
        arguments: list[str] = []
        for name, value in parameters.items():
            arguments += ["-p", f"{name}:={_as_yaml(value)}"]
        return Child(
            f"{node}_node",
            f"roadmend.nodes.{node}",
            ["--ros-args", *arguments, *self._options.ros_arguments],
            self._environment,
            self._folder / f"{node}.log",
            may_restart,
        )

    def supervise(self, stopped: Callable[[], bool]) -> RunResult:
        everyone = [*self._nodes, self._sim]
        try:
            for child in everyone:
                child.start()
            if self._options.foxglove is not None:
                self._report(f"live at ws://127.0.0.1:{self._options.foxglove}, for Foxglove", 0.0)
            while self._sim.exit_code is None:
                if stopped():
                    self._stop(interrupted=True)
                    raise InterruptedRunError(self._result() if (self._folder / "sim.json").exists() else None)
                self._look_after(self._nodes)
                self._pass_on()
                self._report("running", time.monotonic() - self._begun)
                time.sleep(POLL_S)
            self._stop(interrupted=False)
            if self._sim.exit_code:
                _raise(self._sim)
            self._pass_on()
            return self._result()
        except InputError:
            stop(everyone, time.monotonic() + STOP_S)
            raise
        finally:
            stop(everyone, time.monotonic() + 0.5)

    def _pass_on(self) -> None:
        """Say what the simulator sees of the graph: what it waits for, what the method runs with, who disturbs.

        Raises:
            InputError: a parameter was given to all nodes and none of them has it.
        """
        try:
            view = json.loads((self._folder / "sim.graph").read_text(encoding="utf-8"))
        except (OSError, json.JSONDecodeError):
            return
        waiting = [f"waiting for {line}" for line in view["waiting"]]
        for line in [*view["notes"], *view["warnings"], *waiting]:
            if line not in self._said:
                self._said.add(line)
                self._report(line, time.monotonic() - self._begun)
        started = {child.name for child in (*self._nodes, self._sim)}
        announced = [*map(_announcement, view["announced"].values())]
        check_taken(self._options.ros_arguments, announced, len(started))

    def _look_after(self, children: Sequence[Child]) -> None:
        for child in children:
            if child.exit_code is None:
                continue
            if child.exit_code == BAD_INPUT:
                _raise(child)
            if not child.may_restart:
                self._drive_on_without(child)
                continue
            if child.restarts >= RESTARTS_MAX:
                raise RoadmendError(f"{child.name} ended {RESTARTS_MAX + 1} times; last: {child.fault()}")
            child.restarts += 1
            self._report(f"{child.name} ended ({child.exit_code}), restarted", time.monotonic() - self._begun)
            child.start()

    def _drive_on_without(self, child: Child) -> None:
        """Say once that a node is gone which the vehicle does not need; but the simulator does not begin without it."""
        if not (self._folder / "sim.begun").exists():
            _raise(child)
        if child.name not in self._gone:
            self._gone.add(child.name)
            words = f"{child.name} ended ({child.exit_code}), driving on without it: {child.fault()}"
            self._report(words, time.monotonic() - self._begun)

    def _stop(self, *, interrupted: bool) -> None:
        deadline = time.monotonic() + STOP_S
        if interrupted:
            stop([self._sim], time.monotonic() + SIM_STOP_S)
        # The recorder goes last: it takes in what the others still say.
        recorder = [child for child in self._nodes if child.name == "recorder_node"]
        stop([child for child in self._nodes if child not in recorder], deadline - 1.2)
        stop(recorder, deadline if interrupted else time.monotonic() + 30.0)

    def _result(self) -> RunResult:
        sim = json.loads((self._folder / "sim.json").read_text(encoding="utf-8"))
        repair: dict[str, Any] = {}
        with contextlib.suppress(OSError, json.JSONDecodeError):
            repair = json.loads((self._folder / "repair.json").read_text(encoding="utf-8"))
        # The simulator knows what was announced, but not what was replaced.
        episode = replace(
            EpisodeResult.parse(sim["result"]),
            policy=sim["account"]["policy"],
            method=sim["account"]["method"],
            interventions=repair.get("interventions", 0),
            change=repair.get("change", 0.0),
            spells=tuple(Spell(**spell) for spell in repair.get("spells", ())),
        )
        return RunResult(
            episode,
            sim["account"].get("clock", self._options.clock),
            sim["watchdog_ticks"],
            sum(child.restarts for child in self._nodes),
            sim["real_time_factor"],
            str(self._bag or ""),
            self._recording_error(),
            self._policy_error(),
            repair.get("fault", ""),
            tuple(sim["warnings"]),
            {name: _announcement(one).as_dict() for name, one in sim["announced"].items()},
        )

    def _recording_error(self) -> str:
        recorder = next((child for child in self._nodes if child.name == "recorder_node"), None)
        if recorder is None or not recorder.exit_code:
            return ""
        return str(recorder.fault())

    def _policy_error(self) -> str:
        policies = [child for child in self._nodes if child.name == "policy_node"]
        return str(read_fault(policies[0].fault_file) or "") if policies else ""


def _announcement(content: Mapping[str, Any]) -> Announcement:
    return Announcement(content["node"], content["label"], content["values"])


def _raise(child: Child) -> NoReturn:
    fault = child.fault()
    if isinstance(fault, InputError):
        raise fault
    raise RoadmendError(f"{child.name} failed ({child.exit_code}): {fault}")


def _as_yaml(value: Any) -> str:
    """A parameter value as rcl's YAML reader takes it on the command line; texts are quoted so that they stay texts."""
    return json.dumps(value)


@contextlib.contextmanager
def _signals() -> Iterator[Callable[[], bool]]:
    """While this lasts, SIGINT and SIGTERM only set a flag."""
    arrived: list[int] = []

    def note(number: int, _frame: FrameType | None) -> None:
        arrived.append(number)

    previous = {number: signal.signal(number, note) for number in (signal.SIGINT, signal.SIGTERM)}
    try:
        yield lambda: bool(arrived)
    finally:
        for number, handler in previous.items():
            signal.signal(number, handler)
