"""A small set of made-up cases and their results."""

from roadmend.core.episode_result import EpisodeResult
from roadmend.core.outcome import Blame, Event, EventKind
from roadmend.measures.case_result import CaseResult
from roadmend.world.corpus import Case


def episode(
    outcome, ticks=200, interventions=0, change=0.0, digest="", deceleration=2.0, jerk=4.0, blame=Blame.UNKNOWN, text=""
):
    final = Event(10.0, EventKind[outcome], text, blame=blame)
    return EpisodeResult(
        "s",
        "p",
        "m",
        final,
        (final,),
        ticks,
        10.0,
        1.5,
        interventions,
        change,
        deceleration,
        jerk,
        0.5,
        100.0,
        (),
        digest,
        True,
    )


def result(case, violation, outcome, frames=0, change=0.0, family="S1", deceleration=2.0):
    came_to = episode(outcome, 200, frames, change, f"{case}{outcome}" * 8, deceleration)
    return CaseResult(case, family, violation, came_to)


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
