"""The measures of an evaluation by name: the JSON, the table and the help of ``roadmend evaluate`` follow from here."""

from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass
from operator import itemgetter
from typing import Any, Literal

from roadmend.core.episode_result import EpisodeResult
from roadmend.core.outcome import EventKind
from roadmend.measures.case_result import CaseResult
from roadmend.measures.intervals import wilson
from roadmend.measures.ordinary import ordinary_figures
from roadmend.measures.repair import summarise


@dataclass(frozen=True, slots=True)
class MethodEpisodes:
    """What a policy drove under one repair method."""

    results: Sequence[EpisodeResult]
    cases: Sequence[CaseResult]  # those that the policy alone ends in a collision or at the goal
    pairs: Sequence[tuple[EpisodeResult, EpisodeResult]] = ()  # the policy alone, and with the method


@dataclass(frozen=True, slots=True)
class Column:
    """A column of the table, and one with its 95 % interval where ``interval`` is given."""

    title: str
    unit: str  # empty where it has none, or the title says it
    better: Literal["higher", "lower", ""]  # empty where neither is
    meaning: str
    value: Callable[[Any], float | None] = lambda figure: figure  # from the measure's figure; None where there is none
    interval: Callable[[Any], Sequence[float] | None] | None = None
    digits: int = 1


@dataclass(frozen=True, slots=True)
class Measure:
    """A figure of the episodes, as a plain value for the JSON, and what of it the table shows."""

    figure: Callable[[MethodEpisodes], Any]
    columns: tuple[Column, ...] = ()


def _outcomes(episodes: MethodEpisodes) -> dict[str, int]:
    counts = {kind.name: sum(result.outcome is kind for result in episodes.results) for kind in EventKind}
    return {name: count for name, count in counts.items() if count}


def _goal(episodes: MethodEpisodes) -> dict[str, Any]:
    goals, count = sum(result.reached_goal for result in episodes.results), len(episodes.results)
    return {"share": 100.0 * goals / count, "interval": [100.0 * bound for bound in wilson(goals, count)]}


def _collision(episodes: MethodEpisodes) -> float:
    return 100.0 * sum(result.collided for result in episodes.results) / len(episodes.results)


def _interval_of_delta_e(repair: dict[str, Any]) -> list[float] | None:
    interval: list[float] | None = repair["intervals"]["delta_e"]
    return interval


def _network(episodes: MethodEpisodes) -> dict[str, float | None]:
    """What driving over a network costs, by the way driven; None where no drive tells."""
    kilometres = sum(result.distance for result in episodes.results) / 1000.0
    spells = sum(len(result.spells) for result in episodes.results)
    # Time that is lost can be told of the same way only: where both come to the goal.
    both = [(bare, own) for bare, own in episodes.pairs if bare.reached_goal and own.reached_goal]
    way = sum(own.distance for _, own in both) / 1000.0
    lost = sum(own.duration - bare.duration for bare, own in both)
    return {
        "kilometres": kilometres,
        "interventions_per_km": spells / kilometres if kilometres else None,
        "time_lost_per_km": lost / way if way else None,
    }


# Of all drives of an evaluation, for a table about a network; no part of MEASURES' own table, which is wide enough.
NETWORK = (
    Column("driven", "km", "", "by all egos", itemgetter("kilometres"), digits=2),
    Column("interventions", "1/km", "lower", "of the repair method", itemgetter("interventions_per_km"), digits=2),
    Column(
        "time lost",
        "s/km",
        "lower",
        "where the policy comes to the goal alone and with repair",
        itemgetter("time_lost_per_km"),
        digits=2,
    ),
)

MEASURES: dict[str, Measure] = {
    "episodes": Measure(lambda episodes: len(episodes.results), (Column("episodes", "", "", "driven", digits=0),)),
    "outcomes": Measure(_outcomes),
    "goal": Measure(
        _goal,
        (Column("goal", "%", "higher", "episodes that end there", itemgetter("share"), itemgetter("interval")),),
    ),
    "collision": Measure(_collision, (Column("collision", "%", "lower", "episodes that end in one"),)),
    "network": Measure(_network),
    "repair": Measure(
        lambda episodes: summarise(episodes.cases),
        (
            Column(
                "%Fix",
                "",
                "higher",
                "collisions of the policy alone, by its own fault, that now end at the goal",
                itemgetter("fix"),
            ),
            Column("%Deg", "", "lower", "what it completes alone and now ends in a collision", itemgetter("deg")),
            Column("ΔE", "", "higher", "%Fix less %Deg", itemgetter("delta_e"), _interval_of_delta_e),
            Column("dose", "s", "lower", "full command by which an episode was changed", itemgetter("dose"), digits=2),
        ),
    ),
    "ordinary": Measure(
        lambda episodes: asdict(ordinary_figures(episodes.pairs)),
        (
            Column(
                "untouched",
                "%",
                "higher",
                "drives without a violation of the policy alone that are changed by less than 0.2 s of full command "
                "and in which no lane change is held back",
                itemgetter("untouched"),
            ),
            Column("time lost", "%", "lower", "on the way to the goal in these", itemgetter("time_lost")),
            Column("spells", "1/km", "lower", "interventions in these", itemgetter("spells_per_km"), digits=2),
            Column(
                "needless",
                "s/h",
                "lower",
                "dose in these of spells of which fewer than one future in ten violates (with --futures)",
                itemgetter("needless_dose_per_hour"),
            ),
            Column(
                "needed",
                "%",
                "higher",
                "interventions, those of all drives, of which at least one future in five violates (with --futures)",
                itemgetter("spells_needed"),
            ),
            Column(
                "new", "", "lower", "collisions of the ego's own fault in these", itemgetter("new_collisions"), digits=0
            ),
        ),
    ),
}
