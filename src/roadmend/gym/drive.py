"""``roadmend/Drive-v0``: the ego of a scenario, driven by throttle and brake, one tick of 0.05 s a step."""

import contextlib
import math
from collections.abc import Iterable, Mapping, Sequence
from os import PathLike
from typing import Any

import gymnasium
import numpy as np
from gymnasium import spaces
from gymnasium.error import ResetNeeded

from roadmend.api.scenarios import scenario_of, scenarios_of
from roadmend.core.command import Command
from roadmend.core.episode_result import ResultBuilder
from roadmend.core.errors import InputError, SimulationError
from roadmend.core.outcome import Event, EventKind
from roadmend.core.repair import Repair
from roadmend.core.route import Route
from roadmend.core.settings import check_parameters
from roadmend.core.tick import Tick
from roadmend.core.whole_number import whole_number
from roadmend.gym.observation import Observation, observation_space
from roadmend.gym.observer import DriveObserver, command_of
from roadmend.gym.registration import ENVIRONMENT
from roadmend.gym.reward import RewardWeights, reward_terms
from roadmend.world.families import FAMILIES, LAST, family_of, sample_scenario
from roadmend.world.scenario import Scenario
from roadmend.world.simulation import Simulation

ScenarioGiven = Scenario | str | PathLike[str]
_LEARNER = "learner"  # who drives, in results
_SCENARIO = "scenario"  # the one option of a reset
_COUNT = 20  # scenarios of each family, where nothing else is said


class DriveEnv(gymnasium.Env[Observation, np.ndarray]):
    """One ego in SUMO, to be driven to its goal.

    Action, Box(-1, 1): throttle - brake, one number; with ``lane_change`` a second one, above 0 where the route's next
    lane change shall begin, if the ego is where it may. Without it, it begins as soon as it may, whoever is there.

    Observation: see ``gym.observation``. Reward: the sum of the terms of ``gym.reward``. An episode terminates at the
    goal, in a collision and where the lane ends under the ego; it is truncated at the scenario's time limit.

    ``info`` has the scenario's name, time [s], tick, min_distance [m] to the nearest other (None where nobody is near),
    events (plain values, as they happened), objects_left_out (how many the observation has no room for); from a step
    also reward_terms; and from the last one outcome and result, the figures of the whole episode.

    SUMO holds one simulation a process. An environment has it from reset to the end of the episode, or to ``close``; a
    second one that is reset in between is refused. ``make_vector`` drives several in worker processes.
    """

    metadata = {"render_modes": []}  # noqa: RUF012 - as Gymnasium has it

    def __init__(
        self,
        scenarios: ScenarioGiven | Sequence[ScenarioGiven] | None = None,
        *,
        families: Sequence[str] | None = None,
        first: int | None = None,
        count: int | None = None,
        objects: int = 16,
        lane_change: bool = False,
        reward: Mapping[str, float] | None = None,
    ) -> None:
        """Choose what is driven in; every reset draws one of the scenarios.

        Args:
            scenarios: or paths of their files.
            families: random scenarios of these instead; of ours all, where nothing is given.
            first: number of the first scenario of each family, as ``roadmend sample --seed`` has it; 0 if None.
            count: how many scenarios of each family, 20 if None. Each has its own road network, which is built the
                first time.
            objects: participants that an observation has room for, the nearest first.
            lane_change: whether the action says when to change lanes.
            reward: weights that differ from the defaults of ``RewardWeights``, by name.

        Raises:
            InputError: an argument is unusable.
        """
        drawn = [
            name for name, given in (("families", families), ("first", first), ("count", count)) if given is not None
        ]
        if scenarios is not None and drawn:
            what = f"is given both scenarios and {drawn[0]}"
            raise InputError(ENVIRONMENT, what, "give scenarios, or families with first and count")
        first = whole_number(f"{ENVIRONMENT}: first", 0 if first is None else first)
        count = whole_number(f"{ENVIRONMENT}: count", _COUNT if count is None else count, 1)
        objects = whole_number(f"{ENVIRONMENT}: objects", objects, 1)
        if first + count - 1 > LAST:
            what = f"{first} and count {count} go beyond the last scenario of a family"
            raise InputError(f"{ENVIRONMENT}: first", what, f"stay up to number {LAST}")
        if not isinstance(lane_change, bool | np.bool_):
            raise InputError(f"{ENVIRONMENT}: lane_change", f"is {lane_change!r}", "give True or False")
        if reward is not None and not isinstance(reward, Mapping):
            raise InputError(f"{ENVIRONMENT}: reward", f"is {reward!r}", 'give weights by name, such as {"goal": 20.0}')
        if scenarios is not None and not isinstance(scenarios, Scenario | str | PathLike | Iterable):
            raise InputError(
                f"{ENVIRONMENT}: scenarios", f"is {scenarios!r}", "give scenarios, or paths of their files"
            )
        if isinstance(families, str) or not isinstance(families, Iterable | None):
            raise InputError(f"{ENVIRONMENT}: families", f"is {families!r}", 'give a list of names, such as ["S3"]')
        self._weights = check_parameters(reward, RewardWeights, "reward")
        self._given = scenarios_of(scenarios) if scenarios is not None else []
        self._families = [*FAMILIES] if families is None else [*families]
        for family in self._families:
            if not isinstance(family, str):
                raise InputError(
                    f"{ENVIRONMENT}: families", f"{family!r} is no name", f"choose of {', '.join(FAMILIES)}"
                )
            family_of(family)
        if not self._families:
            raise InputError(f"{ENVIRONMENT}: families", "there is none", f"choose of {', '.join(FAMILIES)}")
        self._first, self._count, self._most = first, count, objects
        self._observer = DriveObserver(objects)
        self.observation_space = observation_space(objects)
        self.action_space = spaces.Box(-1.0, 1.0, (2 if lane_change else 1,), np.float32)
        self.method = "none"  # who repairs, in results; the wrapper says it
        self.taken = self.action_space.shape  # of the actions that come here; a wrapper's are its own affair
        self._simulation: Simulation | None = None
        self._tick: Tick | None = None

    @property
    def tick(self) -> Tick:
        """What there is to see now.

        Raises:
            ResetNeeded: nothing yet.
        """
        if self._tick is None:
            raise ResetNeeded("roadmend/Drive-v0: call reset() first")
        return self._tick

    @property
    def route(self) -> Route:
        """The ego's route in this episode."""
        _ = self.tick
        return self._route

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Observation, dict[str, Any]]:
        """Begin an episode.

        Args:
            seed: the same one gives the same scenario, and with the same actions the same episode, bit for bit.
            options: "scenario" names one to drive, or the path of its file, instead of one that is drawn.

        Raises:
            InputError: the options or the scenario are unusable.
            SimulationError: another episode is under way in this process, or SUMO failed.
        """
        super().reset(seed=seed)
        self.close()
        scenario = self._chosen(options or {})
        self._simulation = simulation = Simulation(scenario)
        self._route = simulation.route
        self._builder = ResultBuilder(simulation.scenario.name, _LEARNER, self.method)
        self._observer.reset(self._route)
        self._action = 0.0
        try:
            self._tick = tick = simulation.first()
        except SimulationError:
            self.close()
            raise
        if tick.final is not None:  # Gymnasium knows no episode without a step
            self.close()
            what = f"is over before a step: {tick.final.text}"
            raise InputError(f"scenario {scenario.name}", what, "let the ego or what it stands in begin elsewhere")
        self._builder.see(tick)
        return self._observer.see(tick.scene), self._info(tick)

    def step(self, action: np.ndarray) -> tuple[Observation, float, bool, bool, dict[str, Any]]:
        """Drive one tick.

        Raises:
            InputError: the action is not of the action space.
            ResetNeeded: the episode is over, or none has begun.
            SimulationError: SUMO failed.
        """
        if self._simulation is None:
            raise ResetNeeded("roadmend/Drive-v0: the episode is over, or none has begun; call reset()")
        command, left = command_of(action, self.taken), self._observer.left
        self._builder.command(self.tick, command)
        try:
            self._tick = tick = self._simulation.step(command)
        except SimulationError:
            self.close()
            raise
        self._builder.see(tick)
        observation = self._observer.see(tick.scene)
        change, self._action = abs(command.action - self._action), command.action
        terms = reward_terms(self._weights, tick, left - self._observer.left, self._observer.limit, change)
        info = self._info(tick) | {"reward_terms": terms}
        if tick.final is not None:
            self._builder.command(tick, Command(0.0, 0.0))
            info |= {"outcome": tick.final.kind.name, "result": self._builder.result().figures()}
            self.close()  # another environment may have SUMO now
        truncated = tick.final is not None and tick.final.kind is EventKind.TIMEOUT
        terminated = tick.final is not None and not truncated
        return observation, sum(terms.values()), terminated, truncated, info

    def note(self, repair: Repair) -> None:
        """Count an answer of the repair method in the episode's result; called before the step that drives on it."""
        self._builder.repair(repair)

    def close(self) -> None:
        """Give SUMO back; harmless when it has been given back before."""
        simulation, self._simulation = self._simulation, None
        if simulation is not None:
            simulation.close()

    def __del__(self) -> None:
        with contextlib.suppress(AttributeError):  # one that was refused has nothing to give back
            self.close()

    def _chosen(self, options: Mapping[str, Any]) -> Scenario:
        unknown = [name for name in options if name != _SCENARIO]
        if unknown:
            raise InputError(f"{ENVIRONMENT}: options", f"{unknown[0]!r} is unknown", f"known is {_SCENARIO!r}")
        if _SCENARIO in options:
            return scenario_of(options[_SCENARIO])
        if self._given:
            return self._given[int(self.np_random.integers(len(self._given)))]
        family = self._families[int(self.np_random.integers(len(self._families)))]
        return sample_scenario(family, self._first + int(self.np_random.integers(self._count)))

    def _info(self, tick: Tick) -> dict[str, Any]:
        return {
            "scenario": self._route.scenario,
            "time": tick.scene.time,
            "tick": tick.number,
            "min_distance": tick.min_distance if math.isfinite(tick.min_distance) else None,
            "events": [_plain(event) for event in tick.events],
            "objects_left_out": max(0, len(tick.scene.objects) - self._most),
        }


def _plain(event: Event) -> dict[str, Any]:
    return {
        "time": event.time,
        "kind": event.kind.name,
        "text": event.text,
        "with_whom": list(event.object_names),
        "blame": event.blame.name,
        "at_fault": event.at_fault,
        "impact_speed": event.impact_speed,
    }
