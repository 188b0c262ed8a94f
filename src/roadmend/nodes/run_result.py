"""What came out of a run of the graph, from what its nodes have left behind."""

import contextlib
import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from roadmend.core.episode_result import EpisodeResult
from roadmend.core.interrupt import InterruptedWorkError
from roadmend.core.outcome import EventKind
from roadmend.core.repair import RepairStatus
from roadmend.core.spell import Spell
from roadmend.nodes.announcement import Announcement
from roadmend.nodes.graph_options import JOURNAL, RECORDER_SUMMARY, REPAIR_SUMMARY, SUMMARY
from roadmend.nodes.repair_tally import RepairTally

_STATE = "state."  # before the name of a state, in the tally
_COMPLAINTS = frozenset(
    status.name
    for status in (
        RepairStatus.STALE_COMMAND,
        RepairStatus.STALE_OBJECTS,
        RepairStatus.INVALID_COMMAND,
        RepairStatus.INVALID_OBJECTS,
        RepairStatus.MODEL_FAULT,
    )
)
STANDSTILL_TICKS = 20  # at the end of a run, driven without the policy or the repair node, are no late command any more


@dataclass(frozen=True)
class RunResult:
    """What came out of one run."""

    episode: EpisodeResult
    clock: str
    watchdog_ticks: int
    restarts: int  # of all nodes
    real_time_factor: float
    bag: str
    recording_error: str = ""  # why the bag is not complete; empty if it is
    policy_error: str = ""  # how the policy failed first, so that the vehicle braked; empty if it did not
    method_error: str = ""  # how the repair method failed first, so that the guard's rule answered; empty if it did not
    warnings: tuple[str, ...] = ()  # who else took part, in one line each
    configuration: dict[str, Any] = field(default_factory=dict)  # by node: what each has announced of itself
    faults: tuple[str, ...] = ()  # nodes that ended, hung or fell silent, in one line each
    lost_messages: int = 0  # that were sent, as far as DDS knows, and are not in the bag
    answers: dict[str, int] = field(default_factory=dict)  # of the repair node, by state
    foreign_frames: str = ""  # whose messages the repair node did not use for their frame; empty where there were none
    repair_restarts: int = 0  # of the repair node alone

    def as_dict(self) -> dict[str, Any]:
        """Plain values, for JSON: the episode's figures without its peaks, and what is the run's own."""
        figures = {name: value for name, value in self.episode.figures().items() if not name.startswith("peak_")}
        return figures | {name: value for name, value in vars(self).items() if name != "episode"}


class InterruptedRunError(InterruptedWorkError):
    """The user stopped the run; the bag is complete up to that point."""

    def __init__(self, result: RunResult | None) -> None:
        super().__init__()
        self.result = result


def read_result(folder: Path, clock: str, restarts: int, bag: Path | None, faults: Sequence[str]) -> RunResult:
    """The result of a run whose simulator has ended.

    The simulator knows what was announced, but not what was replaced; that is in the journal of the repair node, which
    outlives every restart.

    Args:
        folder: where the nodes have left their summaries.
        clock: how time passed, where nobody announced it.
        restarts: of nodes.
        bag: its folder; None if nothing was recorded.
        faults: what went wrong with nodes, in one line each.
    """
    sim = read_summary(folder / SUMMARY)
    counted = RepairTally(folder / JOURNAL)
    tally: dict[str, Any] = counted.account()
    counted.close()
    episode = replace(
        EpisodeResult.parse(sim["result"]),
        policy=sim["account"]["policy"],
        method=sim["account"]["method"],
        interventions=tally["interventions"],
        change=tally["change"],
        spells=tuple(Spell(**spell) for spell in tally["spells"]),
    )
    left = read_summary(folder / REPAIR_SUMMARY)
    answers = {name.removeprefix(_STATE): count for name, count in tally.items() if name.startswith(_STATE)}
    return RunResult(
        episode,
        sim["account"].get("clock", clock),
        sim["watchdog_ticks"],
        restarts,
        sim["real_time_factor"],
        str(bag or ""),
        method_error=left.get("fault", ""),
        warnings=tuple(sim["warnings"]),
        configuration={name: announcement_of(one).as_dict() for name, one in sim["announced"].items()},
        faults=(*faults, *_silent_end(sim.get("watchdog_since", 0), tally["stale"])),
        lost_messages=read_summary(folder / RECORDER_SUMMARY).get("lost_messages", 0),
        answers=answers,
        foreign_frames=left.get("frames", ""),
    )


def _silent_end(bitten: int, stale: int) -> list[str]:
    """Who had nothing to say at the end of the drive, however short that was for a supervisor."""
    if bitten >= STANDSTILL_TICKS:
        return [f"repair_node sent no command at the last {bitten} ticks: the simulator braked"]
    if stale >= STANDSTILL_TICKS:
        return [f"policy_node, or what it needs, was missing at the last {stale} ticks: controlled stop"]
    return []


def complaint_of(result: RunResult) -> str:
    """Ticks whose command or scene was not as it should be, in one line for people; empty where all were."""
    counts = {name: count for name, count in result.answers.items() if name in _COMPLAINTS}
    resets = result.answers.get(RepairStatus.RESET.name, 0) - 1 - result.repair_restarts  # each begins with one
    if resets > 0:
        counts[RepairStatus.RESET.name] = resets
    told = ", ".join(f"{count} as {name}" for name, count in counts.items())
    lines = [
        f"of {sum(result.answers.values())} answers repair_node gave {told}" if told else "",
        result.foreign_frames,
    ]
    if result.watchdog_ticks:
        lines.append(f"the simulator braked by itself at {result.watchdog_ticks} ticks ({EventKind.WATCHDOG.name})")
    return "; ".join(filter(None, lines))


def gap_of(bag: str, lost: int) -> str:
    """What a bag lacks, in one line for people."""
    return f"{bag}: {lost} messages were lost on their way to the recorder"


def announcement_of(content: Mapping[str, Any]) -> Announcement:
    """From plain values."""
    return Announcement(content["node"], content["label"], content["values"])


def read_summary(path: Path) -> dict[str, Any]:
    """What a node has left; nothing where it was killed before it could."""
    content: dict[str, Any] = {}
    with contextlib.suppress(OSError, json.JSONDecodeError):
        content = json.loads(path.read_text(encoding="utf-8"))
    return content
