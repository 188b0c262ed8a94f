"""Starts the graph for one episode as separate processes, supervises them and stops them cleanly."""

import contextlib
import json
import signal
import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from pathlib import Path
from types import FrameType
from typing import Any, NoReturn

from roadmend.core.claim import claimed_bag
from roadmend.core.errors import InputError, RoadmendError
from roadmend.nodes.children import Child, stop
from roadmend.nodes.domain import own_domain
from roadmend.nodes.fault import read_fault
from roadmend.nodes.graph_options import NODES, SUMMARY, GraphOptions, Place
from roadmend.nodes.loopback import reach
from roadmend.nodes.ros_arguments import SHARED, as_yaml, check_addressees, check_taken, shared_parameters
from roadmend.nodes.run_result import InterruptedRunError, RunResult, announcement_of, read_result
from roadmend.nodes.scratch import scratch_folder
from roadmend.nodes.supervisor import START_S, Supervisor

POLL_S = 0.05
STOP_S = 2.8  # everything is gone this long after an interrupt [s]
MISSED_S = 2.0  # [s] without a sign of life that make a node the one that the start waits for
BAG_S = 30.0  # the recorder may take so long [s] to complete its bag after a drive
FAILED_S = 5.0  # and so long [s] after a run that failed, for it may be the recorder that hangs
SIM_STOP_S = 0.8  # of which the simulator may take [s] to report the abort
RECORDER = "recorder_node"  # ends last, and says itself how it ended
REPAIR = "repair_node"
BAD_INPUT = 2  # exit code of a node that refuses its parameters


def run_graph(options: GraphOptions, report: Callable[[str, float], None] = lambda _text, _time: None) -> RunResult:
    """Run one episode in the graph.

    Args:
        options: what to run and how.
        report: called with a word on the state and the wall time [s] since the start, several times a second.

    Raises:
        InputError: a node refuses its parameters, or the bag's name is no name or taken.
        RoadmendError: a node failed beyond repair, or refuses its parameters when it is started anew.
        InterruptedRunError: SIGINT or SIGTERM arrived.
    """
    check_addressees(options.ros_arguments)
    with (
        claimed_bag(options.bags, options.name, options.stem, is_wanted=options.record) as bag,
        own_domain() as domain,
        scratch_folder("roadmend-run-") as folder,
        _signals() as stopped,
    ):
        return _GraphRun(options, bag, folder, domain, report).supervise(stopped)


class _GraphRun:
    def __init__(
        self, options: GraphOptions, bag: Path | None, folder: Path, domain: int, report: Callable[[str, float], None]
    ) -> None:
        self._options = options
        self._environment = {"ROS_DOMAIN_ID": str(domain), **reach()}
        self._bag = bag
        self._folder = folder
        self._report = report
        self._begun = time.monotonic()
        self._gone: set[str] = set()
        self._is_driving = False
        self._waiting: list[str] = []  # what keeps the drive from beginning, as the simulator sees it
        self._supervisor = Supervisor(options.silence_limit, max(START_S, options.begins_within))
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
            summary=str(folder / SUMMARY),
            driver="external" if options.is_external else "own",
            writer=options.writer("repair_node"),
            wait_for=[f"{entry.node}_node" for entry in entries],
        )
        place = Place(bag, folder)
        self._nodes = [
            self._child(entry.node, may_restart=entry.may_restart, **entry.parameters(options, place))
            for entry in entries
        ]

    def _child(self, node: str, *, may_restart: bool, **parameters: Any) -> Child:
        arguments: list[str] = []
        for name, value in parameters.items():
            arguments += ["-p", f"{name}:={as_yaml(value)}"]
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
                    self._stop()
                    raise InterruptedRunError(self._result() if (self._folder / SUMMARY).exists() else None)
                self._supervisor.end_silent(everyone, time.monotonic(), is_driving=self._is_driving)
                self._look_after(self._nodes)
                self._pass_on()
                self._check_start()
                self._report("running", time.monotonic() - self._begun)
                time.sleep(POLL_S)
            if not self._sim.exit_code:
                self._look_after(self._recorders)  # it may have ended since the last look
                self._supervisor.end([child for child in self._nodes if child not in self._recorders], stopped)
            self._stop(patience=BAG_S)
            self._check_end()
            self._pass_on()
            return self._result()
        except InputError:
            stop(everyone, time.monotonic() + STOP_S)
            raise
        except RoadmendError:  # what was driven until then is in the bag, which the recorder must be let complete
            self._stop(patience=FAILED_S)
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
        self._waiting = view["waiting"]
        waiting = [f"waiting for {line}" for line in view["waiting"]]
        for line in [*view["notes"], *view["warnings"], *waiting]:
            if line not in self._said:
                self._said.add(line)
                self._report(line, time.monotonic() - self._begun)
        started = {child.name for child in (*self._nodes, self._sim)}
        announced = [*map(announcement_of, view["announced"].values())]
        check_taken(self._options.ros_arguments, announced, len(started))

    def _look_after(self, children: Sequence[Child]) -> None:
        for child in children:
            if child.exit_code is None:
                continue
            if child.exit_code == BAD_INPUT:
                _raise(child, has_driven=self._has_driven)
            if not child.may_restart:
                self._drive_on_without(child)
                continue
            self._report(self._supervisor.restart(child), time.monotonic() - self._begun)

    @property
    def _has_driven(self) -> bool:
        return (self._folder / "sim.driving").exists()

    def _check_start(self) -> None:
        """Wait for the first answer, but not for ever.

        Raises:
            RoadmendError: the drive has not begun in time; its line names who is missing.
        """
        self._is_driving = self._is_driving or self._has_driven
        limit = self._options.begins_within
        if self._is_driving or not limit or time.monotonic() - self._begun < limit or self._sim.exit_code is not None:
            return
        everyone = [*self._nodes, self._sim]
        silent = [child for child in everyone if child.pulse.silence > MISSED_S or not child.pulse.beats]
        names = [f"{child.name} (no sign of life for {child.pulse.silence:.0f} s)" for child in silent]
        who = ", ".join(names) or "; ".join(self._waiting) or "an answer to the first tick"
        raise RoadmendError(f"the drive did not begin within {limit:g} s, for want of {who}; see --start-deadline")

    def _check_end(self) -> None:
        """Look whether the drive that is over has a result.

        Raises:
            RoadmendError: the simulator failed, or was told to stop before the drive.
        """
        if self._sim.exit_code:
            _raise(self._sim, has_driven=self._has_driven)
        if not (self._folder / SUMMARY).exists():
            raise RoadmendError("sim_node was told to stop before the drive began: there is no result")

    def _drive_on_without(self, child: Child) -> None:
        """Say once that a node is gone which the vehicle does not need; but the simulator does not begin without it."""
        if not (self._folder / "sim.begun").exists():
            _raise(child, has_driven=False)
        if child.name not in self._gone:
            self._gone.add(child.name)
            words = f"{child.name} ended ({child.exit_code}), driving on without it: {child.fault()}"
            self._report(words, time.monotonic() - self._begun)

    def _stop(self, *, patience: float | None = None) -> None:
        """Stop all; the recorder has ``patience`` [s] to complete its bag, or what an interrupt leaves of ``STOP_S``."""
        deadline = time.monotonic() + STOP_S
        stop([self._sim], time.monotonic() + SIM_STOP_S)  # where the drive has ended it has gone
        # The recorder goes last: it takes in what the others still say.
        stop([child for child in self._nodes if child not in self._recorders], deadline - 1.2)
        stop(self._recorders, deadline if patience is None else time.monotonic() + patience)

    def _result(self) -> RunResult:
        restarts = sum(child.restarts for child in self._nodes)
        found = read_result(self._folder, self._options.clock, restarts, self._bag, self._supervisor.faults)
        return replace(
            found,
            recording_error=self._recording_error(),
            policy_error=self._policy_error(),
            repair_restarts=sum(child.restarts for child in self._nodes if child.name == REPAIR),
        )

    @property
    def _recorders(self) -> list[Child]:
        """The recorder; empty where nothing is recorded."""
        return [child for child in self._nodes if child.name == RECORDER]

    def _recording_error(self) -> str:
        for recorder in self._recorders:
            if recorder.exit_code:
                return str(recorder.fault())
            if recorder.name in self._gone:  # told to stop by somebody else
                return f"{recorder.name} ended before the drive did; the bag ends there"
        return ""

    def _policy_error(self) -> str:
        policies = [child for child in self._nodes if child.name == "policy_node"]
        return str(read_fault(policies[0].fault_file) or "") if policies else ""


def _raise(child: Child, *, has_driven: bool) -> NoReturn:
    fault = child.fault()
    if child.restarts:
        raise RoadmendError(f"{child.name} could not be started anew: {fault}")
    if isinstance(fault, InputError) and not has_driven:  # at that the bag is thrown away
        raise fault
    raise RoadmendError(f"{child.name} failed ({child.exit_code}): {fault}")


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
