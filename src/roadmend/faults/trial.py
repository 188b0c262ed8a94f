"""One run of the graph with a fault in it, started as a user would and judged from outside."""

import contextlib
import hashlib
import json
import os
import signal
import subprocess
import tempfile
import time
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from roadmend.core.errors import InputError
from roadmend.core.outcome import EventKind
from roadmend.core.tick import INTERVAL
from roadmend.faults.campaign import FaultCampaign, FaultTrial
from roadmend.faults.evidence import Evidence, read_evidence
from roadmend.faults.fault import MethodFault, SignalFault, TopicFault
from roadmend.faults.processes import command_of, end_all, left_of, node_process
from roadmend.faults.staging import TOUCHED, begin_of, relay, run_command, touched_stamps
from roadmend.recording.recovery import recover
from roadmend.world.families import sample_scenario
from roadmend.world.scenario_file import save_scenario

_POLL_S = 0.02
_START_S = 120.0  # patience until the vehicle drives [s]
_LOCKSTEP_SPEED = 15.0  # simulated seconds a second, about; a fault that comes too late is told, see `injected`
_SEEN_TICKS = 6  # that must be driven yet for a signal to be seen in the bag
_GONE_S = 5.0  # who has been told to end may need so long [s]
_OWNED = "mine.txt"  # stands for what was in the folder before


@dataclass(frozen=True)
class Disturbed:
    """What came of one run.

    Attributes:
        injected: whether the fault came while the vehicle drove, by the policy's commands; where not, the run tells nothing.
        exit_code: of ``roadmend run``; None if it hung and was killed.
        outcome: of the episode; empty without a result.
        distance: least one to others [m]; None without a result, or where nobody was near.
        named: whether standard error names the fault: the node, the state, or what cannot be used.
        traceback: whether standard error shows a bare traceback.
        left: processes and temporary folders that were left behind.
        is_tree_whole: whether what was in the folder before is still there, unchanged.
        recovered: whether the bag had to be recovered.
        evidence: what the bag shows; None if it cannot be read at all.
        stderr: its last lines.
    """

    injected: bool
    exit_code: int | None
    outcome: str
    distance: float | None
    named: bool
    traceback: bool
    left: tuple[str, ...]
    is_tree_whole: bool
    recovered: bool
    evidence: Evidence | None
    stderr: tuple[str, ...]

    def as_dict(self) -> dict[str, Any]:
        """Plain values, for JSON."""
        return vars(self) | {
            "left": list(self.left),
            "stderr": list(self.stderr),
            "evidence": self.evidence.as_dict() if self.evidence else None,
        }

    @classmethod
    def parse(cls, entry: Mapping[str, Any]) -> "Disturbed":
        """From ``as_dict``."""
        evidence = None if entry["evidence"] is None else Evidence.parse(entry["evidence"])
        texts = {name: tuple(entry[name]) for name in ("left", "stderr")}
        return cls(**{**entry, **texts, "evidence": evidence})


def disturb(campaign: FaultCampaign, trial: FaultTrial, graph: Mapping[str, str]) -> Disturbed:
    """Run the graph, put the fault into it, and look at everything that is left.

    Args:
        campaign: the campaign.
        trial: the run.
        graph: environment by which the nodes of the run, and those that disturb it, find each other and nobody else.

    Raises:
        InputError: the campaign names a family that there is not.
    """
    with tempfile.TemporaryDirectory(prefix="roadmend-faults-") as name:
        folder = Path(name)
        temporary = folder / "tmp"
        temporary.mkdir()
        (folder / "bags").mkdir()
        owned = folder / "bags" / _OWNED
        owned.write_text("was here before\n", encoding="utf-8")
        before = hashlib.sha256(owned.read_bytes()).digest()
        environment = {**os.environ, **graph, "TMPDIR": str(temporary)}
        environment["PYTHONPATH"] = os.pathsep.join(filter(None, [str(folder), os.environ.get("PYTHONPATH", "")]))
        between = relay(campaign, trial, folder, environment | {"TMPDIR": str(folder)})
        try:
            return _watch(_start(campaign, trial, folder, environment), campaign, trial, folder, before)
        finally:
            if between is not None:
                between.kill()
                between.wait()
            end_all(f"TMPDIR={temporary}")


def _start(
    campaign: FaultCampaign, trial: FaultTrial, folder: Path, environment: Mapping[str, str]
) -> subprocess.Popen[str]:
    family = campaign.families[trial.seed % len(campaign.families)]
    scenario = sample_scenario(family, campaign.first_scenario + trial.seed)
    if campaign.time_limit is not None:
        scenario = scenario.model_copy(update={"time_limit": campaign.time_limit})
    path = folder / "scenario.yaml"
    save_scenario(scenario, path)
    command = run_command(campaign, trial, path, folder)
    with (folder / "out").open("w") as out, (folder / "err").open("w") as err:
        return subprocess.Popen(command, stdout=out, stderr=err, text=True, env=environment, start_new_session=True)


def _watch(
    process: subprocess.Popen[str], campaign: FaultCampaign, trial: FaultTrial, folder: Path, before: bytes
) -> Disturbed:
    fault = trial.fault
    injected = not isinstance(fault, SignalFault) or _inject(process, fault, campaign, trial, folder)
    code: int | None
    try:
        code = process.wait(campaign.patience)
    except subprocess.TimeoutExpired:
        code = None
    mark = f"TMPDIR={folder / 'tmp'}"
    until = time.monotonic() + (_GONE_S if code is not None else 0.0)
    while (there := left_of(mark)) and time.monotonic() < until:
        time.sleep(_POLL_S)
    left = [f"process {command_of(number)}" for number in there] if code is not None else []
    if code is None:
        end_all(mark)
        process.wait()
    else:
        left += [f"folder {path.name}" for path in (folder / "tmp").glob("roadmend-*") if path.is_dir()]
    if isinstance(fault, TopicFault) or (isinstance(fault, MethodFault) and fault.is_driven):
        injected = (folder / TOUCHED).exists()
    said = (folder / "err").read_text(encoding="utf-8", errors="replace")
    result = _result(folder / "out")
    owned = folder / "bags" / _OWNED
    evidence, recovered = None, False
    if fault is None or fault.is_driven:
        evidence, recovered = _evidence(campaign, folder, trial, result.get("duration"))
    if fault is not None and trial.clock == "realtime" and evidence is not None:
        # Before the policy's first answer the vehicle is held, and to be silent then is another fault.
        injected = injected and evidence.begun is not None and evidence.begun < begin_of(campaign, trial)
    return Disturbed(
        injected,
        code,
        str(result.get("outcome", "")),
        result.get("min_distance"),
        fault is not None and fault.said in said,
        "Traceback (most recent call last)" in said,
        tuple(left),
        owned.is_file() and hashlib.sha256(owned.read_bytes()).digest() == before,
        recovered,
        evidence,
        tuple(said.splitlines()[-8:]),
    )


def _inject(
    process: subprocess.Popen[str], fault: SignalFault, campaign: FaultCampaign, trial: FaultTrial, folder: Path
) -> bool:
    """Send the signal at a moment drawn by the seed; returns whether it came while the vehicle drove."""
    drawn = begin_of(campaign, trial)
    speed = _LOCKSTEP_SPEED if trial.clock == "lockstep" else trial.rate
    until = time.monotonic() + _START_S
    while not any((folder / "tmp").glob("roadmend-run-*/sim.driving")):
        if process.poll() is not None or time.monotonic() > until:
            return False
        time.sleep(_POLL_S)
    target = node_process(process.pid, fault.node, 5.0)
    time.sleep(drawn / speed)
    if target is None or process.poll() is not None or any((folder / "tmp").glob("roadmend-run-*/sim.json")):
        return False
    try:
        os.kill(target, getattr(signal, f"SIG{fault.signal}"))
    except ProcessLookupError:
        return False
    time.sleep(_SEEN_TICKS * INTERVAL / speed)
    came_late = any((folder / "tmp").glob("roadmend-run-*/sim.json"))
    if fault.resume is not None:
        time.sleep(fault.resume)
        with contextlib.suppress(ProcessLookupError):
            os.kill(target, signal.SIGCONT)
    return not came_late


def _result(path: Path) -> Mapping[str, Any]:
    """What ``roadmend run --json`` told of its one episode; empty if it told nothing."""
    with contextlib.suppress(OSError, json.JSONDecodeError, LookupError, TypeError):
        return dict(json.loads(path.read_text(encoding="utf-8"))[0])
    return {}


def _evidence(
    campaign: FaultCampaign, folder: Path, trial: FaultTrial, duration: float | None
) -> tuple[Evidence | None, bool]:
    """What the bag shows, and whether it had to be recovered for that."""
    fault = trial.fault
    node = fault.node if isinstance(fault, SignalFault) else None
    declared = fault.declared if fault else None
    asked = (node, declared, duration, touched_stamps(campaign, trial, folder))
    bag = folder / "bags" / "bag"
    with contextlib.suppress(InputError):
        return read_evidence(bag, *asked), False
    with contextlib.suppress(InputError):
        recover(bag, folder / "recovered")
        return read_evidence(folder / "recovered", *asked), True
    return None, True


def collided(disturbed: Disturbed) -> bool:
    """Whether the episode ended in a collision."""
    return disturbed.outcome == EventKind.COLLISION.name
