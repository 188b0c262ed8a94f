"""A small set of made-up results, for the tests of the benchmark's figures and reports."""

from roadmend.evaluation.benchmark_run import Entrants, Measured
from roadmend.measures.case_result import CaseResult
from roadmend.measures.contenders import Absence, Contender
from roadmend.measures.monitor import Confusion
from roadmend.world.corpus import Case


def result(case, violation, outcome, frames=0, change=0.0, family="S1", deceleration=2.0, jerk=4.0):
    return CaseResult(
        case, family, violation, outcome, 200, 10.0, frames, change, 1.5, deceleration, jerk, f"{case}{outcome}" * 8
    )


def case(name, violation, family="S1"):
    outcome = "COLLISION" if violation else "GOAL"
    digest = f"{name}{outcome}" * 8
    return Case(name, family, "test", 1, {}, outcome, digest, "random", 0, 0, "", None, 10.0)


CASES = [
    case("a", True),
    case("b", True),
    case("c", True, "S2"),
    case("d", True, "S2"),
    case("e", False),
    case("f", False),
    case("g", False, "S2"),
    case("h", False, "S2"),
]
FAMILY = {each.name: each.family for each in CASES}


def run(outcomes, frames=0, change=0.0):
    """Results of all cases from a letter each."""
    names = {"G": "GOAL", "C": "COLLISION", "T": "TIMEOUT", "O": "OFF_ROUTE"}
    return tuple(
        result(each.name, each.is_violation, names[letter], frames, change, each.family)
        for each, letter in zip(CASES, outcomes, strict=True)
    )


def contender(name, title, group, policy="modular"):
    return Contender(name, title, group, policy, name, {"margin": 0.5} if group == "rival" else {}, code="c" * 64)


def measured(policy="modular"):
    contenders = (
        contender("none", "no repair", "reference", policy),
        contender("rule", "RuleRepair", "rival", policy),
        contender("adreft", "ADReFT", "adreft", policy),
        contender("hindsight", "hindsight bound", "bound", policy),
    )
    absences = (Absence("wo_sr", policy, "there is no model <wo_sr>"),)
    entrants = Entrants(policy, "", "d" * 64, tuple(CASES), contenders, contenders[1:3], absences)
    results = {
        "none": run("CCCCGGGG"),
        "rule": run("GTCCGGGC", 20, 24.0),
        "adreft": run("GGGTGGGG", 10, 6.0),
        "hindsight": run("GGGCGGGG", 5, 4.0),
    }
    confusions = {
        "rule": (Confusion(1, 1, 9, 89),) * len(CASES),
        "adreft": (Confusion(8, 4, 2, 86),) * len(CASES),
    }
    return Measured(entrants, results, confusions)


MADE = {
    "command": "./roadmend bench adreft",
    "commit": "0123456789abcdef",
    "dirty": False,
    "machine": {"processor": "a <processor>", "cores": 2, "system": "Linux 6", "python": "3.11.7"},
}
