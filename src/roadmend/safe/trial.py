"""One episode of a built scenario, with all that is needed to tell whether it was the crash of a report."""

from dataclasses import dataclass

from roadmend.core.command import Decision
from roadmend.core.episode_result import EpisodeResult
from roadmend.core.errors import SimulationError
from roadmend.core.repair import Repair
from roadmend.core.route import Route
from roadmend.core.tick import Tick
from roadmend.policies.registry import make_policy
from roadmend.repair.registry import make_repairer
from roadmend.safe.contact import Contact
from roadmend.safe.film import Film
from roadmend.safe.likeness import Run, run_of
from roadmend.world.runner import drive
from roadmend.world.scenario import Scenario
from roadmend.world.simulation import Simulation


@dataclass(frozen=True, slots=True)
class CrashTestEpisode:
    """What an episode came to."""

    summary: EpisodeResult
    run: Run
    route: Route

    @property
    def film(self) -> Film:
        """Where everybody was."""
        return self.run.film

    @property
    def contact(self) -> Contact | None:
        """The first contact between any two; None if nobody touched anybody."""
        return self.run.contacts[0] if self.run.contacts else None

    @property
    def is_physical(self) -> bool:
        """Whether everybody moved as vehicles can."""
        return all(motion.is_physical for motion in self.run.motions.values())

    @property
    def moment(self) -> int:
        """The tick to look at: the ego's contact, else that at which somebody was nearest, else the middle.

        Who looks on is looked at from the crash on.
        """
        own = [each.tick for each in self.run.contacts if self.film.ego_name in each.names]
        crash = [each.tick for each in self.run.contacts if each.names & self.film.fixed]
        return own[0] if own else self.film.nearest(since=crash[0] if crash else 0)


def ego_name_of(scenario: Scenario) -> str:
    """What the report calls the vehicle in whose place the policy drives; "ego" where it is none of the report's."""
    number = scenario.origin.vehicle if scenario.origin is not None else None
    return "ego" if number is None else f"v{number}"


def blank_film(scenario: Scenario) -> Film:
    """A film of a scenario before its first tick."""
    return Film(ego_name_of(scenario), fixed=frozenset(each.id for each in scenario.obstacles))


def run_trial(scenario: Scenario, policy: str) -> CrashTestEpisode:
    """Drive a scenario with a policy, without repair.

    Raises:
        InputError: the scenario cannot be run, or there is no such policy.
        SimulationError: SUMO failed, or the ego touches somebody before it moves.
    """
    film = blank_film(scenario)
    with Simulation(scenario) as simulation:

        def see(tick: Tick) -> None:
            seen = simulation.seen
            assert seen is not None
            film.add(tick.scene.ego, seen.around, simulation.everyone())

        def watch(tick: Tick, _decision: Decision, _repair: Repair) -> None:
            see(tick)

        summary = drive(simulation, make_policy(policy), make_repairer("none"), watch, see)
        route = simulation.route
    if len(film.ego) < 2:
        raise SimulationError(f"{scenario.name} begins with a collision")
    return CrashTestEpisode(summary, run_of(scenario, film), route)
