"""Rows of a committed table that are not measured again: they stand beside the fresh ones, and say where they are from.

A whole table takes hours, a method alone minutes. What is kept was measured on the same cases; ``--verify`` drives it
again and tells whether the world or a method has moved since.
"""

import re
from collections.abc import Mapping, Sequence
from typing import Any

from harness.adreft_cost import EAGER
from harness.benchmark_content import OURS
from roadmend.core.errors import InputError
from roadmend.core.tick import INTERVAL
from roadmend.measures.repair import PairedCase, advantage_of, intervals_of

Content = dict[str, Any]
_OF_PRICES = ("curve-count", "curve-cases", "table-cases")
_PRICES = "what is fixed at a given loss of time"
_SIZES = re.compile(r"--(count|networks|drives|futures|curve-count|curve-cases|table-cases) (\d+)")


class _Kept:
    """Who was kept, of which policy, and who was measured anew."""

    def __init__(self) -> None:
        self._kept: dict[str, list[str]] = {}  # method -> policies
        self._fresh: dict[str, set[str]] = {}  # method -> policies

    @property
    def names(self) -> set[str]:
        """Methods that were kept for some policy."""
        return {*self._kept}

    def missing(self, policy: str, old: Mapping[str, Any], fresh: Mapping[str, Any], order: Sequence[str]) -> list[str]:
        """Methods of the order that only the old table has for a policy; from now on they count as kept."""
        found = [name for name in old if name not in fresh and name in order]
        for name in fresh:
            self._fresh.setdefault(name, set()).add(policy)
        for name in found:
            policies = self._kept.setdefault(name, [])
            policies += [policy] * (policy not in policies)
        return found

    def note(self, content: Content, before: Mapping[str, Any], order: Sequence[str], more: Sequence[str] = ()) -> None:
        """Write into the provenance which methods were measured by which earlier command.

        A method whose policies were not all measured by one command is called with each policy: "modular: adreft".
        """
        made = before["provenance"]
        earlier = {name: entry for entry in made.get("kept", ()) for name in entry["methods"]}
        found: dict[tuple[str, str], list[str]] = {}
        for name in [*_ordered(self._kept, order), *more]:
            by = {
                f"{policy}: {name}": earlier.get(f"{policy}: {name}", earlier.get(name, made))
                for policy in self._kept.get(name, [])
            } or {name: earlier.get(name, made)}
            sources = {(entry["commit"], entry["command"]) for entry in by.values()}
            is_one = len(sources) == 1 and self._fresh.get(name, set()) <= {*self._kept.get(name, [])}
            for label, entry in {name: next(iter(by.values()))}.items() if is_one else by.items():
                found.setdefault((entry["commit"], entry["command"]), []).append(label)
        content["provenance"]["kept"] = [
            {"commit": commit, "command": command, "methods": names} for (commit, command), names in found.items()
        ]


def keep_cases(
    content: Content,
    cases: Content,
    before: Mapping[str, Any],
    cases_before: Mapping[str, Any],
    digests: Mapping[str, Sequence[str]],
    order: Sequence[str],
) -> None:
    """Add to a table, and to its cases, what an earlier one has besides; who leads by how much is found anew.

    A policy that was not measured is kept whole.

    Args:
        content: as ``build_content`` makes it.
        cases: as ``case_table`` makes it.
        before: the earlier table.
        cases_before: its cases.
        digests: by measured policy, of each case's trajectory without repair: what the earlier table's row without
            repair must show.
        order: of the methods; what is not in it is dropped.

    Raises:
        InputError: the two are not of the same cases.
    """
    kept = _Kept()
    for policy, table in cases.items():
        former = cases_before.get(policy, {"names": [], "methods": {}})
        alone = former["methods"].get("none", {"digests": []})["digests"]
        if former["names"] != table["names"] or alone != [
            digest[: len(known)] for digest, known in zip(digests[policy], alone, strict=False)
        ]:
            mend = "measure all methods again, without --keep"
            raise InputError("--keep", f"the committed table has other cases of the policy {policy}", mend)
    left_out = [policy for policy in before["policies"] if policy not in cases]
    _make_room(content, cases, before, cases_before, left_out)
    for policy, table in cases.items():
        former = cases_before[policy]
        missing = kept.missing(policy, former["methods"], table["methods"], order)
        table["methods"] |= {name: former["methods"][name] for name in missing}
        table["methods"] = _ordered(table["methods"], order)
        _take(content["contenders"][policy], before["contenders"][policy], missing)
        groups = {"": (content["summary"], before["summary"])}
        groups |= {family: (content["families"][family], before["families"][family]) for family in content["families"]}
        for family, (fresh, old) in groups.items():
            _take(fresh[policy], old[policy], missing)
            _renew(fresh[policy], table, family)
            fresh[policy] = _ordered(fresh[policy], order)
        monitor = content["monitor"][policy]
        _take(monitor, before["monitor"][policy], [name for name in before["monitor"][policy] if name not in monitor])
    for part in ("titles", "monitor_titles"):
        content[part] = _ordered({**before[part], **content[part]}, order)
    known = {(entry["policy"], entry["method"]) for entry in content["not_run"]}
    content["not_run"] += [
        entry
        for entry in before["not_run"]
        if (entry["method"] in kept.names or (entry["policy"] in left_out and entry["method"] in order))
        and (entry["policy"], entry["method"]) not in known
    ]
    kept.note(content, before, order)


def keep_cost(cost: Content, before: Mapping[str, Any], order: Sequence[str]) -> Content:
    """What a frame costs by method: of those that were not timed now, what they cost before.

    Args:
        cost: as ``cost_of`` makes it.
        before: the earlier one.
        order: of the methods; what is neither in it nor PyTorch's is dropped.
    """
    names = [*order, EAGER]
    return _ordered({name: found for name, found in {**before, **cost}.items() if name in names}, names)


def check_sizes(command: str, before: Mapping[str, Any], *, is_whole: bool = False) -> None:
    """Whether a command measures ordinary drives and prices on as much as those did that made the earlier figures.

    Args:
        command: as it was given.
        before: the earlier figures.
        is_whole: whether it measures every method of every policy, so that only prices are kept, if any.

    Raises:
        InputError: it does not.
    """
    own = {name: size for name, size in _sizes(command).items() if not is_whole or name in _OF_PRICES}
    for made in (before["provenance"], *before["provenance"].get("kept", ())):
        for name, size in _sizes(made["command"]).items():
            if own.get(name, size) != size:
                mend = "give the same, or measure all methods again, without --keep"
                raise InputError("--keep", f"the committed figures are of --{name} {size}, not {own[name]}", mend)


def _sizes(command: str) -> dict[str, str]:
    """By option, how much a command measured of what it measured at all."""
    given = dict(_SIZES.findall(command))
    found = {"count": given.get("count", "200")}
    if "futures" in given:  # they change no drive: rows whose need was not looked at may stand beside others
        found["futures"] = given["futures"]
    if "networks" in given:
        found |= {name: given[name] for name in ("networks", "drives")}
    if "curve-count" in given:
        found |= {name: given.get(name, "all") for name in _OF_PRICES}
    return found


def keep_ordinary(content: Content, before: Mapping[str, Any], order: Sequence[str]) -> None:
    """Add to what ordinary drives and prices came to what an earlier measurement has besides.

    By how much ADReFT leads at a price is known only where both were driven together: beside a price that was measured
    anew it is not told of what is kept. Methods that are not in ``order`` are dropped.

    Raises:
        InputError: the two are not of the same drives.
    """
    kept = _Kept()

    def take(fresh: Content, policy: str, old: Mapping[str, Any]) -> None:
        methods = fresh.setdefault(policy, {})
        _take(methods, old, kept.missing(policy, old, methods, order))
        fresh[policy] = _ordered(methods, order)

    for name, policies in before["ordinary"].items():
        for policy, old in policies.items():
            fresh = content["ordinary"].setdefault(name, {})
            rows = {**old, **fresh.get(policy, {})}.values()
            if len({(row["drives"], row["collisions_bare"]) for row in rows}) > 1:
                mend = "give the same drives, or measure all methods again, without --keep"
                raise InputError("--keep", f"the committed figures of {policy} on {name} are of other drives", mend)
            take(fresh, policy, old)
    if before["at_time_lost"] and not content["at_time_lost"]:
        content["curve"], content["at_time_lost"] = before["curve"], before["at_time_lost"]
        # who was kept before may have been so among the prices, and is not told apart
        former = [name for entry in before["provenance"].get("kept", ()) for name in entry["methods"]]
        kept.note(
            content, before, order, more=[_PRICES, *(name for name in former if name not in (*kept.names, _PRICES))]
        )
        return
    for policy, old in before["curve"].items():
        take(content["curve"], policy, old)
    for policy, old in before["at_time_lost"].items():
        take(content["at_time_lost"], policy, {name: _without_lead(prices) for name, prices in old.items()})
    kept.note(content, before, order)


def _drives(figures: Mapping[str, Any]) -> tuple[Any, ...]:
    """What is equal to the last digit where a method's drives are the same; its code may be written otherwise."""
    model = figures.get("contender", {}).get("model", {}).get("digest")
    return model, figures.get("delta_e"), figures.get("dose_violations")


def keep_controls(content: Content, before: Mapping[str, Any], order: Sequence[str]) -> None:
    """Add to controls what earlier ones have besides: methods by their shuffles, and bounds, which hang on no method.

    Raises:
        InputError: the two are not of as many cases.
    """
    kept = _Kept()
    renewed = {policy for policy, found in content["controls"].items() if OURS in found["shuffled"]}
    for policy, kept_before in before["controls"].items():
        found = content["controls"].setdefault(policy, {"shuffled": {}})
        fresh, old = found["shuffled"], kept_before["shuffled"]
        sizes = {(each["violations"], each["successes"]) for each in [*fresh.values(), *old.values()]}
        if len(sizes) > 1:
            mend = "give the same --cases, or measure all methods again, without --keep"
            raise InputError("--keep", f"the committed controls of the policy {policy} are of other cases", mend)
        _take(fresh, old, kept.missing(policy, old, fresh, order))
        found["shuffled"] = _ordered(fresh, order)
    bounds = [policy for policy in before["bound"] if policy not in content["bound"]]
    _take(content["bound"], before["bound"], bounds)
    for policy in renewed.intersection(bounds):
        fresh, old = (found["controls"][policy]["shuffled"].get(OURS, {}) for found in (content, before))
        if _drives(fresh) != _drives(old):
            # what is held against the kept bound is of other drives
            content["bound"][policy]["informed"] = {**before["bound"][policy]["informed"], "adreft_dose": None}
    kept.note(content, before, order, more=["informed bound"] if bounds else [])


def keep_robustness(content: Content, before: Mapping[str, Any], order: Sequence[str]) -> None:
    """Add to a robustness study the methods that an earlier one has besides.

    Raises:
        InputError: the two did not search alike.
    """
    alike = ("techniques", "families", "runs", "budget")
    if any(content[name] != before[name] for name in alike):
        mend = "give the same --budget and families, or run all methods again, without --keep"
        raise InputError("--keep", "the committed study did not search alike", mend)
    kept = _Kept()
    for policy, techniques_before in before["policies"].items():
        techniques = content["policies"].setdefault(policy, {})
        for technique, old in techniques_before.items():
            curves = techniques.setdefault(technique, {})
            _take(curves, old, kept.missing(policy, old, curves, order))
            techniques[technique] = _ordered(curves, order)
    content["policies"] = _ordered(content["policies"], [*before["policies"]])
    kept.note(content, before, order)


def _make_room(
    content: Content,
    cases: Content,
    before: Mapping[str, Any],
    cases_before: Mapping[str, Any],
    left_out: Sequence[str],
) -> None:
    """Take policies that were not measured into a table, without methods yet; policies in the order of before."""
    places = [*before["policies"]]
    for policy in left_out:
        cases[policy] = {**cases_before[policy], "methods": {}}
        content["corpora"][policy] = before["corpora"][policy]
        for part in ("contenders", "summary", "monitor"):
            content[part][policy] = {}
    for family in before["families"]:
        fresh = content["families"].setdefault(family, {}) | {policy: {} for policy in left_out}
        content["families"][family] = _ordered(fresh, places)
    content["policies"] = [*_ordered(dict.fromkeys([*content["policies"], *left_out]), places)]
    for part in ("corpora", "contenders", "summary", "monitor"):
        content[part] = _ordered(content[part], places)
    for policy in _ordered(cases, places):
        cases[policy] = cases.pop(policy)


def _take(fresh: Content, old: Mapping[str, Any], names: Sequence[str]) -> None:
    for name in names:
        found = old[name]
        fresh[name] = dict(found) if isinstance(found, Mapping) else found


def _renew(figures: Content, table: Mapping[str, Any], family: str) -> None:
    """What hangs on single cases, of a family or (empty) of all: intervals, and ADReFT's lead, one of the two kept."""
    paired = {name: paired_cases(table, name, family) for name in table["methods"]}
    for name, cases in paired.items():
        figures[name]["intervals"] = intervals_of(cases)
        if name != OURS and OURS in paired:
            figures[name]["adreft_minus_this"] = advantage_of(paired[OURS], cases)


def paired_cases(table: Mapping[str, Any], method: str, family: str = "") -> list[PairedCase]:
    """What a method came to in the cases of a committed table, of a family or (empty) of all."""
    columns = table["methods"][method]
    rows = zip(
        table["names"],
        table["families"],
        table["alone"],
        columns["outcomes"],
        columns["doses"],
        columns["frames"],
        strict=True,
    )
    return [
        PairedCase(name, alone == "C", outcome == "G", outcome == "C", dose, outcome == "T", dose / INTERVAL, frames)
        for name, of, alone, outcome, dose, frames in rows
        if family in ("", of)
    ]


def _without_lead(prices: Mapping[str, Any]) -> Content:
    return {price: None if point is None else {**point, "lead": None} for price, point in prices.items()}


def _ordered(methods: Mapping[str, Any], order: Sequence[str]) -> Content:
    """In the order given; what is not in it comes last."""
    places = {name: place for place, name in enumerate(order)}
    return {name: methods[name] for name in sorted(methods, key=lambda each: places.get(each, len(places)))}
