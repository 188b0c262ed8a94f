"""What the damaged files of a campaign come to: a row for every kind of file and damage."""

from collections.abc import Mapping, Sequence
from typing import Any

from roadmend.faults.file_kinds import FILES, FileKind
from roadmend.faults.files import FileTrial, Refused

TIME_MAX = 10.0  # [s] more than the sound file takes
MEMORY_MAX = 512 << 10  # [KiB] likewise
FILE_HEADING = ["file: damage", "files", "safe", "refused", "longest [s]", "more memory than the sound file [MB]"]


def refusal_rows(runs: Sequence[tuple[FileTrial, Refused]]) -> list[dict[str, Any]]:
    """One entry for each kind of file and damage, judged against the sound file of the kind."""
    sound = {trial.kind: refused for trial, refused in runs if not trial.damage}
    groups: dict[tuple[str, str], list[Refused]] = {}
    for trial, refused in runs:
        if trial.damage:
            groups.setdefault((trial.kind, trial.damage), []).append(refused)
    return [_row(kind, damage, found, sound[kind]) for (kind, damage), found in groups.items()]


def _row(kind: str, damage: str, found: Sequence[Refused], sound: Refused) -> dict[str, Any]:
    faults = [_faults(FILES[kind], damage, one, sound) for one in found]
    return {
        "fault": f"{kind}: {damage}",
        "clock": "file",
        "runs": len(found),
        "safe": sum(not each for each in faults),
        "reported": sum(one.exit_code in FILES[kind].exits or one.exit_code in (0, 1) for one in found),
        "refused": sum(one.exit_code in FILES[kind].exits for one in found),
        "lost_messages": 0,
        "seconds_to_state": None,
        "seconds": max(one.seconds for one in found),
        "memory_mb": max(one.memory for one in found) >> 10,
        "more_memory_mb": max(0, max(one.memory for one in found) - sound.memory) >> 10,
        "faults": sorted({text for each in faults for text in each}),
    }


def _faults(kind: FileKind, damage: str, refused: Refused, sound: Refused) -> list[str]:
    faults = ["the sound file is refused"] if sound.exit_code != 0 else []
    allowed = {*kind.exits, *((0, 1) if damage in kind.may_pass else ())}
    if refused.exit_code is None:
        faults.append("hung")
    elif refused.exit_code not in allowed:
        faults.append(f"exit code {refused.exit_code}")
    if refused.exit_code == 2 and refused.lines != 1:
        faults.append(f"{refused.lines} lines in place of one")
    if refused.traceback:
        faults.append("a bare traceback")
    if refused.seconds > sound.seconds + TIME_MAX:
        faults.append(f"took {refused.seconds:.0f} s")
    if refused.memory > sound.memory + MEMORY_MAX:
        faults.append(f"took {refused.memory >> 10} MB")
    if not refused.is_tree_whole:
        faults.append("changed what it does not own, or left something")
    return faults


def file_table(rows: Sequence[Mapping[str, Any]]) -> list[list[str]]:
    """The rows for people, the heading first."""
    names = ("fault", "runs", "safe", "refused")
    return [
        FILE_HEADING,
        *([*(str(row[name]) for name in names), f"{row['seconds']:.1f}", str(row["more_memory_mb"])] for row in rows),
    ]
