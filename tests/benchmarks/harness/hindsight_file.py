"""Hindsight bounds of many cases, side by side and on disk: one line of JSON a case, and interrupted work goes on."""

import json
import os
from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path
from typing import Any

from harness.hindsight import BUDGET, Bound, Episode, PulseSearch
from roadmend import __version__
from roadmend.core.errors import InputError
from roadmend.core.fanout import fan_out
from roadmend.policies.registry import make_policy

FORMAT = "roadmend-hindsight/1"


def hindsight_bound(
    cases: Sequence[Episode],
    policy: str,
    workers: int,
    folder: Path,
    report: Callable[[Bound], None] = lambda _bound: None,
    *,
    budget: int = BUDGET,
) -> list[Bound]:
    """The bound of every case, in the order of the cases.

    Kept in ``folder``/hindsight-POLICY.jsonl: what is there is not searched again, whatever cases it came from.

    Args:
        cases: what to repair; successes may be among them and cost one run each.
        policy: name of the policy in the loop.
        workers: processes; the bounds do not depend on their number.
        folder: where to keep the bounds.
        report: called for every case, those from disk included, in order.
        budget: re-simulations of a case; a file keeps to one budget.

    Raises:
        InputError: there is no such policy, a scenario is unusable, or the file is damaged, of another kind or place.
        SimulationError: SUMO failed, or a worker process died.
    """
    make_policy(policy)
    path = folder / f"hindsight-{policy}.jsonl"
    header = {"format": FORMAT, "policy": policy, "budget": budget, "roadmend": __version__}
    known = _open(path, header)
    keys = [_key(case) for case in cases]
    missing = {key: case for key, case in zip(keys, cases, strict=True) if key not in known}
    bounds: list[Bound] = []
    with fan_out(workers, len(missing)) as mapper:
        searched = iter(mapper(partial(_search, policy=policy, budget=budget), list(missing.values())))
        for key in keys:
            if key not in known:  # a case may be given twice
                bound = next(searched)
                _append(path, bound.dump())
                known[key] = bound
            bounds.append(known[key])
            report(known[key])
    return bounds


def _search(case: Episode, *, policy: str, budget: int) -> Bound:
    return PulseSearch(case, make_policy(policy), budget).run()


def _key(case: Episode) -> tuple[str, str]:
    return case.name, case.scenario().digest


def _open(path: Path, header: dict[str, Any]) -> dict[tuple[str, str], Bound]:
    """What a file holds; makes it where there is none, and drops a last line that an interruption cut short."""
    if not path.exists():
        try:
            path.parent.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise InputError(str(path), f"cannot be written ({error.strerror})", "choose a writable folder") from None
        _append(path, header)
        return {}
    try:
        content = path.read_bytes()
        whole = content[: content.rfind(b"\n") + 1]
        if len(whole) < len(content):
            os.truncate(path, len(whole))
    except OSError as error:
        raise InputError(str(path), f"cannot be read ({error.strerror})", "choose a readable folder") from None
    lines = whole.decode(errors="replace").splitlines()
    if not lines:
        _append(path, header)
        return {}
    known: dict[tuple[str, str], Bound] = {}
    for number, line in enumerate(lines, start=1):
        try:
            values = json.loads(line)
            if number == 1:
                _check_header(path, values, header)
            else:
                bound = Bound.parse(values)
                known[bound.name, bound.scenario] = bound
        except (AttributeError, KeyError, TypeError, ValueError):
            raise InputError(f"{path} line {number}", "is damaged", "choose another folder") from None
    return known


def _check_header(path: Path, found: dict[str, Any], header: dict[str, Any]) -> None:
    for name, value in header.items():
        if found.get(name) != value:
            what = f"holds bounds with {name} {found.get(name)!r}, not {value!r}"
            raise InputError(str(path), what, "choose another folder or the same settings")


def _append(path: Path, values: dict[str, Any]) -> None:
    try:
        with path.open("ab", buffering=0) as file:
            file.write(json.dumps(values).encode() + b"\n")
    except OSError as error:
        raise InputError(str(path), f"cannot be written ({error.strerror})", "choose a writable folder") from None
