"""Starts repair and recorder alone, beside nodes of another stack, and keeps them up until they are told to stop."""

import contextlib
import json
import os
import sys
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from roadmend import __version__
from roadmend.core.claim import claimed_bag
from roadmend.core.errors import InputError, RoadmendError
from roadmend.nodes.children import Child, stop
from roadmend.nodes.graph_options import JOURNAL, RECORDER_SUMMARY, REPAIR_SUMMARY
from roadmend.nodes.loopback import reach
from roadmend.nodes.repair_tally import RepairTally
from roadmend.nodes.ros_arguments import SHARED, as_yaml, check_addressees, shared_parameters
from roadmend.nodes.run_result import read_summary
from roadmend.nodes.scratch import scratch_folder
from roadmend.nodes.spinning import stop_on_signals
from roadmend.nodes.supervisor import REALTIME_SILENCE_S, Supervisor
from roadmend.repair.registry import METHOD_REGISTRY

POLL_S = 0.05
STOP_S = 5.0  # the recorder is gone this long after the end [s]
BAD_INPUT = 2  # exit code of a node that refuses its parameters


@dataclass(frozen=True)
class RepairGraphOptions:
    """Repair in a graph that is not ours."""

    method: str = "rss"
    seed: int = 0
    parameters: Mapping[str, Any] = field(default_factory=dict)  # of the repair node, beyond the above
    bags: Path = Path("bags")
    name: str = ""  # of the bag; made from the method and the time if empty
    record: bool = True
    record_topics: str = ""  # regular expression found in each topic to record; all if empty
    sim_time: bool = False  # whether the stack's time comes from /clock
    ros_arguments: tuple[str, ...] = ()  # for both nodes; parameters that name no node must be the repair node's

    def stem(self) -> str:
        """How the bag's name begins if it has none."""
        return f"repair-{METHOD_REGISTRY.find(self.method).label}"


@dataclass(frozen=True, slots=True)
class RepairRun:
    """What came of it."""

    answers: int
    interventions: int
    states: dict[str, int]  # answers by state
    restarts: int
    bag: str
    method_error: str  # how the method failed first, so that the guard's rule answered; empty if it did not
    recording_error: str  # why the bag is not complete; empty if it is
    faults: tuple[str, ...] = ()  # nodes that ended or hung, in one line each
    lost_messages: int = 0  # that were sent, as far as DDS knows, and are not in the bag


def run_repair(options: RepairGraphOptions, report: Callable[[str], None]) -> RepairRun:
    """Repair until SIGINT or SIGTERM, in the domain that ROS_DOMAIN_ID names.

    What the repair node says goes to standard error as it comes; so is told what its inputs lack.

    Args:
        options: what to run and how.
        report: called with a line for people now and then.

    Raises:
        InputError: a node refuses its parameters, there is no node of a name that they are for, or the bag's name is no
            name or taken.
        RoadmendError: the repair node failed beyond repair, or refuses its parameters when it is started anew.
    """
    check_addressees(options.ros_arguments)
    with (
        claimed_bag(options.bags, options.name, options.stem, is_wanted=options.record) as bag,
        scratch_folder("roadmend-repair-") as folder,
        stop_on_signals() as flag,
    ):
        run = _Run(options, bag, folder, report)
        try:
            return run.until(lambda: flag.is_set)
        finally:
            run.stop()


class _Run:
    def __init__(
        self, options: RepairGraphOptions, bag: Path | None, folder: Path, report: Callable[[str], None]
    ) -> None:
        self._report, self._bag, self._folder = report, bag, folder
        self._domain = os.environ.get("ROS_DOMAIN_ID") or "0"
        self._extra = options.ros_arguments
        told = {"inputs": "newest", "method": options.method, "seed": options.seed, **options.parameters}
        if options.sim_time:
            told["use_sim_time"] = True  # the stamps of its stops are by that clock
        self._repair = self._child(
            "repair",
            told | {"summary": str(folder / REPAIR_SUMMARY), "journal": str(folder / JOURNAL)},
            may_restart=True,
        )
        self._recorder: Child | None = None
        if bag is not None:
            metadata = folder / "run.json"
            known = {"roadmend": __version__, "method": options.method, "policy": "external", "domain": self._domain}
            metadata.write_text(json.dumps(known | {"ros_arguments": " ".join(self._extra)}), encoding="utf-8")
            self._recorder = self._child(
                "recorder",
                {
                    "output": str(bag.parent),
                    "name": bag.name,
                    "claimed": True,
                    "metadata": str(metadata),
                    "include": options.record_topics,
                    "time_source": "simulation" if options.sim_time else "system",
                    "drain_limit": 1.0,
                    "summary": str(folder / RECORDER_SUMMARY),
                },
                may_restart=False,
            )
        self._read = 0  # bytes of the repair node's log that people have seen
        self._is_recording = True
        self._is_up = False  # whether the repair node's loop has ever come round: until then it may have to compile
        self._supervisor = Supervisor(REALTIME_SILENCE_S)

    def _child(self, node: str, parameters: Mapping[str, Any], *, may_restart: bool) -> Child:
        words = [word for name, value in parameters.items() for word in ("-p", f"{name}:={as_yaml(value)}")]
        environment = {"ROS_DOMAIN_ID": self._domain, **reach("SUBNET")}
        extra: Sequence[str] = self._extra
        if node != "repair":  # the repair node refuses what it does not have; another one need not have it
            extra = _for_others(extra)
            environment[SHARED] = json.dumps(sorted(shared_parameters(extra)))
        return Child(
            f"{node}_node",
            f"roadmend.nodes.{node}",
            ["--ros-args", *words, *extra],
            environment,
            self._folder / f"{node}.log",
            may_restart,
        )

    def until(self, stopped: Callable[[], bool]) -> RepairRun:
        for child in self._children:
            child.start()
        self._report(f"repairs in ROS_DOMAIN_ID {self._domain}; stop with Ctrl-C")
        while not stopped():
            self._look_after()
            self._hand_on()
            time.sleep(POLL_S)
        self.stop()
        return self._result()

    @property
    def _children(self) -> list[Child]:
        return [child for child in (self._recorder, self._repair) if child is not None]

    def _look_after(self) -> None:
        self._supervisor.end_silent(self._children, time.monotonic(), is_driving=self._is_up)
        self._is_up = self._is_up or self._repair.pulse.beats > 0
        for child in self._children:
            if child.exit_code is None:
                continue
            if child.exit_code == BAD_INPUT and isinstance(fault := child.fault(), InputError):
                if child.restarts:  # it has repaired, and what was recorded of that stays
                    raise RoadmendError(f"{child.name} could not be started anew: {fault}")
                raise fault
            if child is self._recorder:
                if self._is_recording:
                    self._is_recording = False
                    how = f"ended ({child.exit_code})"
                    self._report(f"{child.name} {how}, repairing on without it: {child.fault()}")
                continue
            self._report(self._supervisor.restart(child))

    def _hand_on(self) -> None:
        """Show what the repair node has said since."""
        with contextlib.suppress(FileNotFoundError), self._repair.log.open("rb") as log:
            log.seek(self._read)
            said = log.read()
            self._read += len(said)
            if said:
                sys.stderr.write(said.decode(errors="replace"))
                sys.stderr.flush()

    def stop(self) -> None:
        """Stop both, the recorder last: it takes in what the other still says. Does nothing the second time."""
        stop([self._repair], time.monotonic() + 1.0)
        if self._recorder is not None:
            stop([self._recorder], time.monotonic() + STOP_S)
        self._hand_on()

    def _result(self) -> RepairRun:
        counted = RepairTally(self._folder / JOURNAL)
        tally: dict[str, Any] = counted.values()
        counted.close()
        states = {name.removeprefix("state."): int(each) for name, each in tally.items() if name.startswith("state.")}
        return RepairRun(
            int(tally["answers"]),
            int(tally["interventions"]),
            states,
            self._repair.restarts,
            str(self._bag or ""),
            str(read_summary(self._folder / REPAIR_SUMMARY).get("fault", "")),
            self._recording_error(),
            tuple(self._supervisor.faults),
            int(read_summary(self._folder / RECORDER_SUMMARY).get("lost_messages", 0)),
        )

    def _recording_error(self) -> str:
        if self._recorder is None or (self._is_recording and not self._recorder.exit_code):
            return ""
        if self._recorder.exit_code:
            return str(self._recorder.fault())
        return f"{self._recorder.name} ended before the repair did; the bag ends there"


def _for_others(arguments: Sequence[str]) -> list[str]:
    """ROS arguments without the parameters that are not addressed to a node by its name."""
    kept: list[str] = []
    for word in arguments:
        if kept and kept[-1] in {"-p", "--param"} and ":" not in word.partition(":=")[0]:
            kept.pop()
        else:
            kept.append(word)
    return kept
