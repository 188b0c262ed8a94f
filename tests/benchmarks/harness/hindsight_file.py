"""Hindsight bounds of many cases, side by side, kept in a journal."""

from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path

from harness.hindsight import BUDGET, Bound, Episode, PulseSearch
from roadmend.core.fanout import fan_out
from roadmend.core.journal import Journal, Key, entry_key
from roadmend.measures.driver import driver_key
from roadmend.policies.registry import make_policy

FORMAT = "roadmend-hindsight/2"


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
    driver = driver_key(policy)
    keys = [entry_key([__name__], driver, budget, case.name, case.scenario().digest) for case in cases]
    bounds: list[Bound] = []
    with Journal(folder / f"hindsight-{policy}.jsonl", FORMAT, {"policy": policy, "budget": budget}) as journal:
        known = _read(journal)
        missing = {key: case for key, case in zip(keys, cases, strict=True) if key not in known}
        with fan_out(workers, len(missing)) as mapper:
            searched = mapper(partial(_search, policy=policy, budget=budget), missing.values())
            for key in keys:
                if key not in known:  # a case may be given twice
                    known[key] = next(searched)
                    journal.add(key, known[key].dump())
                bounds.append(known[key])
                report(known[key])
    return bounds


def _search(case: Episode, *, policy: str, budget: int) -> Bound:
    return PulseSearch(case, make_policy(policy), budget).run()


def _read(journal: Journal) -> dict[Key, Bound]:
    known: dict[Key, Bound] = {}
    for number, (key, values) in enumerate(journal, 2):
        try:
            known[key] = Bound.parse(values)
        except (AttributeError, KeyError, TypeError, ValueError):
            raise journal.damaged(number) from None
    return known
