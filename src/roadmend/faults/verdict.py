"""What a campaign comes to: a row for every fault, on every clock and at every rate."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from statistics import median
from typing import Any

from roadmend.core.tick import INTERVAL
from roadmend.faults.campaign import FaultTrial
from roadmend.faults.fault import Fault, SignalFault, TopicFault
from roadmend.faults.trial import Disturbed, collided

STATE_TICKS = 3  # within which the state must be declared

MEANINGS = {  # of the columns
    "fault": "what was done to the graph",
    "clock": "lockstep, or real time and how fast",
    "runs": "in which the fault came while the vehicle drove",
    "safe": "of them: the exit code is a documented one, no process and no folder is left, nothing that was there before is "
    "changed, the bag reads, no traceback is shown, and no collision that the undisturbed run does not have",
    "reported": "of them: standard error names the fault, and the bag holds its state or event",
    f"in {STATE_TICKS} ticks": "that state came so soon after the first tick that was disturbed; of those where one was, and "
    "long enough to count as late "
    "(of a state that says what messages held: after the first whose messages were all there)",
    "state after [s]": "median of that time, simulated",
    "stands after [s]": "likewise until the vehicle stood",
    "nearest [m]": "least distance to anybody in any of the runs",
    "diagnostics": "runs in which /diagnostics had a warning of the repair node or the simulator",
    "lost messages": "of the simulator's that the bags lack",
    "recovered": "bags that had to be",
    "collisions": "runs that ended in one",
    "alone": "of them, those that the undisturbed run has too",
}
HEADING = list(MEANINGS)


@dataclass(frozen=True)
class Judged:
    """A run and what is wrong with it.

    Attributes:
        trial: what was run.
        disturbed: what came of it; where the fault came too late, the run counts in no column.
        faults: why it is not safe; empty if it is.
        is_reported: whether whoever must name the fault did.
        is_new_collision: whether it collided where the undisturbed run does not.
        undisturbed: what came of the run without the fault; None if that was not run.
    """

    trial: FaultTrial
    disturbed: Disturbed
    faults: tuple[str, ...]
    is_reported: bool
    is_new_collision: bool
    undisturbed: Disturbed | None = None


def judge(runs: Sequence[tuple[FaultTrial, Disturbed]]) -> list[Judged]:
    """Judge the runs of a campaign, each against the undisturbed one of its clock, rate and seed."""
    bare = {_place(trial): disturbed for trial, disturbed in runs if trial.fault is None}
    return [_judged(trial, disturbed, bare.get(_place(trial))) for trial, disturbed in runs]


def _judged(trial: FaultTrial, disturbed: Disturbed, bare: Disturbed | None) -> Judged:
    fault, faults = trial.fault, _left_behind(disturbed)
    if not disturbed.injected:  # of such a run there is no more to be said
        return Judged(trial, disturbed, tuple(faults), is_reported=True, is_new_collision=False, undisturbed=bare)
    if disturbed.exit_code is not None and disturbed.exit_code not in (fault.exits if fault else (0,)):
        faults.append(f"exit code {disturbed.exit_code}")
    if disturbed.evidence is None and (fault is None or fault.is_driven):
        faults.append("lost the bag")
    if fault is not None and not fault.is_driven and len(disturbed.stderr) != 1:
        faults.append(f"{len(disturbed.stderr)} lines in place of one")
    is_new = collided(disturbed) and (bare is None or not collided(bare))
    if is_new:
        faults.append("collided")
    is_reported = fault is None or _is_reported(fault, trial.clock, disturbed)
    return Judged(trial, disturbed, tuple(faults), is_reported, is_new, bare)


def _left_behind(disturbed: Disturbed) -> list[str]:
    """What no run may do, with a fault or without one."""
    faults = ["hung"] if disturbed.exit_code is None else []
    faults += [f"left {each}" for each in disturbed.left]
    if disturbed.traceback:
        faults.append("a bare traceback")
    if not disturbed.is_tree_whole:
        faults.append("changed what it does not own")
    return faults


def _is_reported(fault: Fault, clock: str, disturbed: Disturbed) -> bool:
    """Whether standard error names the fault, and the bag shows the state.

    In lockstep the simulator waits, so that who is soon back has left no tick unanswered and nothing to declare; in real
    time nobody can be away without it.
    """
    evidence = disturbed.evidence
    is_silent = evidence is None or evidence.silence is not None
    if isinstance(fault, TopicFault) and fault.declared is not None and not is_silent:
        return True  # by its draw no message lacked for long enough to be missed
    must_show = fault.declared is not None and (clock == "realtime" or not isinstance(fault, SignalFault) or is_silent)
    if (fault.named or must_show) and not disturbed.named:
        return False
    return not must_show or (evidence is not None and evidence.is_declared)


def campaign_rows(judged: Sequence[Judged]) -> list[dict[str, Any]]:
    """One entry for each fault, clock and rate; runs in which the fault came too late are in its ``faults`` alone."""
    groups: dict[tuple[str, str, float], list[Judged]] = {}
    for each in judged:
        groups.setdefault((each.trial.row, each.trial.clock, each.trial.rate), []).append(each)
    return [_row(*key, found) for key, found in groups.items()]


def _row(name: str, clock: str, rate: float, found: Sequence[Judged]) -> dict[str, Any]:
    judged = [each for each in found if each.disturbed.injected]
    evidence = [each.disturbed.evidence for each in judged if each.disturbed.evidence]
    states = [one.to_state for one in evidence if one.to_state is not None]
    stops = [one.to_standstill for one in evidence if one.to_standstill is not None]
    fault = found[0].trial.fault
    must = [one for one in evidence if fault and fault.declared and fault.prompt and one.silence is not None]
    limit = STATE_TICKS * INTERVAL + 1e-6
    return {
        "fault": name,
        "clock": clock,
        "rate": rate,
        "runs": len(judged),
        "safe": sum(not each.faults for each in judged),
        "reported": sum(each.is_reported for each in judged),
        "must_declare": len(must),
        "within_3_ticks": sum(one.to_state is not None and one.to_state <= limit for one in must),
        "lost_messages": sum(one.lost for one in evidence),
        "seconds_to_state": median(states) if states else None,
        "seconds_to_state_max": max(states, default=None),
        "seconds_to_standstill": median(stops) if stops else None,
        "nearest": min((one.disturbed.distance for one in judged if one.disturbed.distance is not None), default=None),
        "on_stderr": sum(one.disturbed.named for one in judged),
        "in_diagnostics": sum(one.in_diagnostics for one in evidence),
        "recovered": sum(each.disturbed.recovered for each in judged),
        "collisions": sum(collided(each.disturbed) for each in judged),
        "new_collisions": sum(each.is_new_collision for each in judged),
        "faults": sorted({text for each in found for text in each.faults}),
    }


def table(rows: Sequence[Mapping[str, Any]]) -> list[list[str]]:
    """The rows for people, the heading first."""
    return [HEADING, *map(_cells, rows)]


def _cells(row: Mapping[str, Any]) -> list[str]:
    clock = row["clock"] if row["clock"] == "lockstep" else f"{row['clock']} x {row['rate']:g}"
    within = f"{row['within_3_ticks']} of {row['must_declare']}" if row["must_declare"] else _number(None)
    figures = [_number(row["seconds_to_state"]), _number(row["seconds_to_standstill"]), _number(row["nearest"])]
    counts = [str(row[name]) for name in ("in_diagnostics", "lost_messages", "recovered", "collisions")]
    counts.append(str(row["collisions"] - row["new_collisions"]))
    return [row["fault"], clock, str(row["runs"]), str(row["safe"]), str(row["reported"]), within, *figures, *counts]


def _number(value: float | None) -> str:
    return "\N{EN DASH}" if value is None else f"{value:.2f}"


def _place(trial: FaultTrial) -> tuple[str, float, int]:
    return trial.clock, trial.rate, trial.seed
