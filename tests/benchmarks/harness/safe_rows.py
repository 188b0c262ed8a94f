"""The figures of ``roadmend bench safe`` as a table for people."""

from collections.abc import Iterable, Iterator, Mapping
from typing import Any

PAPER: dict[str, Any] = {  # SAFE, RQ1 and RQ3: other simulators, other policies
    "reports": 50,
    "scenarios": {"IDM": 214, "PPO": 211, "BeamNG": 96, "LCTGen, IDM": 50, "AC3R, BeamNG": 19},
    "violations": {"IDM": 42, "PPO": 30, "BeamNG": 87, "LCTGen, IDM": 3, "AC3R, BeamNG": 16},
    "violation_rate": 0.3052,
    "top": {"IDM": [1, 3, 4]},
    "reproduced": {"IDM": 15, "LCTGen, IDM": 3},
    "seconds_per_scenario": [10, 25],
    "extraction": {"cases": 13, "road": 93.8, "actors": 80.0, "env": 100.0, "overall": 80.0},
}
_CATEGORIES = ("road", "actors", "env", "overall")
_DIMENSIONS = {
    "who": "who ran into whom",
    "order": "the order of contacts",
    "parts": "the parts that touch",
    "from": "where they come from",
    "to": "where they go",
    "road": "the type of road",
    "motion": "who stands or reverses",
    "physical": "the physical bounds",
}
SURE = 0.9  # confidence from which 95 of 100 readings are to be right
_NOT_MEASURED = "-"

Row = list[str]


def rows_of(content: Mapping[str, Any]) -> list[Row]:
    """The table: one column a policy, the paper's figures last."""
    policies = [*content["violations"]]
    rows = [["what", *policies, "paper"]]
    for title, cells, paper in (*_tests(content), *_reproduction(content), *_extraction(content)):
        rows.append([title, *([cells] * len(policies) if isinstance(cells, str) else cells), paper])
    return rows


_Line = tuple[str, "str | list[str]", str]


def _tests(content: Mapping[str, Any]) -> Iterator[_Line]:
    yield "reports", str(content["reports"]), "50"
    yield "reports whose scenarios build and run", str(content["built"]), _NOT_MEASURED
    yield "scenarios", str(content["scenarios"]), "214 IDM, 211 PPO, 96 BeamNG"
    yield "collisions", _numbers(content["violations"]), "42 IDM, 30 PPO, 87 BeamNG"
    yield "by the ego's fault", _numbers(content["violations_at_fault"]), _NOT_MEASURED
    yield "violation rate", [_percent(rate) for rate in content["violation_rate"].values()], "30.5 %"
    tops = ["/".join(map(str, top)) or _NOT_MEASURED for top in content["top"].values()]
    yield "first, second, third after", tops, "1/3/4 IDM"
    seconds = content["seconds_per_scenario"]
    yield "seconds a scenario", _NOT_MEASURED if seconds is None else f"{seconds:.2f}", "10 to 25"


def _reproduction(content: Mapping[str, Any]) -> Iterator[_Line]:
    found = content["reproduction"]["policies"].values()
    if content["records"]["records"]:
        yield "crashes reproduced, by the judge", [_of(each, "reproduced") for each in found], "15 of 50 by eye"
        yield "share of all reports", [_percent(each["reproduced"] / each["reports"]) for each in found], "30.0 %"
        for half in ("seen", "unseen"):
            shares = [_of(each["by_half"][half], "reproduced") for each in found if half in each["by_half"]]
            if shares:
                yield f"on the {half} half", shares, _NOT_MEASURED
        yield "with the policy only in a vehicle that stood", [str(each["stood"]) for each in found], _NOT_MEASURED
        singles, others = _by_kind(content["records"], found)
        yield "with the policy as an onlooker of a vehicle that crashes alone", singles, _NOT_MEASURED
        yield "with two vehicles or more", others, _NOT_MEASURED
        yield "of these crashes' collisions, shown", [f"{each['shown']} of {each['collisions']}" for each in found], "-"
        for name, title in _DIMENSIONS.items():
            cells = [f"{each['but_for'][name]} ({each['failed'][name]} runs differ)" for each in found]
            yield f"reproduced, had {title} not counted", cells, _NOT_MEASURED
        wrong = [f"{each['wrongly_accepted']} of {each['wrong_records']}" for each in found]
        yield "control: records of other crashes on such a road accepted", wrong, _NOT_MEASURED
    own = [f"{each['by_own_reading']} of {each['reports']}" for each in found]
    yield "by the program's own reading of the report", own, _NOT_MEASURED
    for name, ablation in content["ablations"].items() if content["records"]["records"] else ():
        measured = ablation["reproduction"].values()
        title = f"control: without {name.replace('-', ' ')}" + (", one random draw" if name == "search" else "")
        yield title, [_of(each, "reproduced") for each in measured], _NOT_MEASURED
        singles, others = _by_kind(content["records"], measured)
        yield f"{title}: a vehicle alone", singles, _NOT_MEASURED
        yield f"{title}: two vehicles or more", others, _NOT_MEASURED


def _extraction(content: Mapping[str, Any]) -> Iterator[_Line]:
    paper = PAPER["extraction"]
    for group, found in content["extraction"].items():
        if found is None:
            continue
        for name in _CATEGORIES:
            told = f"{paper[name]:.1f} % of {paper['cases']}, with the sketch"
            yield f"read right, {group.replace('_', ' ')}, text only: {name}", _scored(found, name), told
        for part, title in (("with_sketch", "with the sketch"), ("majority", "control: the usual value of each field")):
            if found.get(part):
                cells = ", ".join(f"{name} {found[part][name]:.1f}" for name in _CATEGORIES)
                yield f"read right, {group.replace('_', ' ')}, {title}", f"{cells} %", _NOT_MEASURED
        bins = found["calibration"]
        surest = next(
            (each for each in (bins["text_only"] if isinstance(bins, dict) else bins) if each["low"] == SURE), None
        )
        if surest is not None:
            title = (
                f"fields given with a confidence of {SURE} or more that are right, {group.replace('_', ' ')}, text only"
            )
            yield title, right_of(surest), _NOT_MEASURED

    for name, ablation in content["ablations"].items():
        for group, found in ablation.get("extraction", {}).items():
            if found is None:
                continue
            cells = ", ".join(f"{category} {found[category]:.1f}" for category in _CATEGORIES)
            yield (
                f"read right, {group.replace('_', ' ')}, text only, control: without {name.replace('-', ' ')}",
                f"{cells} %",
                _NOT_MEASURED,
            )


def right_of(readings: Mapping[str, Any]) -> str:
    """Share of some readings that are right, and how many they are; a dash where there are none."""
    right = readings["right"]
    return _NOT_MEASURED if right is None else f"{100 * right:.1f} % of {readings['count']}"


def _by_kind(records: Mapping[str, int], found: Iterable[Mapping[str, Any]]) -> tuple[list[str], list[str]]:
    """Reproduced crashes of a single vehicle, on which the policy only looks, and of more: a random draw is one often."""
    alone = records["single_vehicle"]
    singles, others = [], []
    for each in found:
        singles.append(f"{each['looked_on']} of {alone}")
        others.append(f"{each['reproduced'] - each['looked_on']} of {records['records'] - alone}")
    return singles, others


def _scored(found: Mapping[str, Any], name: str) -> str:
    return f"{found[name]:.1f} % of {found['cases']}"


def _of(found: Mapping[str, Any], name: str) -> str:
    return f"{found[name]} of {found['reports']}"


def _numbers(found: Mapping[str, int]) -> list[str]:
    return [str(value) for value in found.values()]


def _percent(share: float | None) -> str:
    return _NOT_MEASURED if share is None else f"{100.0 * share:.1f} %"
