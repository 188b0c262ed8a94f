"""What a small benchmark comes to, made up, for the tests of its figures and reports."""

from harness.benchmark_run import Measured, PolicyBenchmark
from harness.contenders import Absence, Contender
from roadmend.measures.monitor import Confusion
from tests.measures.results import CASES, run


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
    benchmark = PolicyBenchmark(policy, "", "d" * 64, tuple(CASES), contenders, contenders[1:3], absences)
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
    return Measured(benchmark, results, confusions)


MADE = {
    "command": "./roadmend bench adreft",
    "commit": "0123456789abcdef",
    "dirty": False,
    "machine": {"processor": "a <processor>", "cores": 2, "system": "Linux 6", "python": "3.11.7"},
}
