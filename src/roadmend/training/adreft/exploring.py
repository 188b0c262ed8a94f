"""Episodes in which the decision adapter explores; what they come to as transitions (ADReFT algorithm 1).

Holds no torch: these run in worker processes with the compiled model.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from roadmend.core.command import Decision
from roadmend.core.outcome import EventKind
from roadmend.core.repair import Proposal, Repair
from roadmend.core.route import Route
from roadmend.core.scene import Scene
from roadmend.core.tick import INTERVAL, Tick
from roadmend.measures.answering import Answering
from roadmend.policies.registry import make_policy
from roadmend.repair.actions import ACTIONS
from roadmend.repair.adreft.configuration import ModelConfiguration
from roadmend.repair.adreft.model import AdreftModel
from roadmend.repair.guard import GuardedRepairer
from roadmend.training.adreft.configuration import ReinforcementSection
from roadmend.training.closed_loop import EpisodeCase
from roadmend.world.runner import run_episode

_ACTIONS = np.array(ACTIONS)


@dataclass(frozen=True, slots=True)
class Roll:
    """What decides an episode; travels to a worker process."""

    case: EpisodeCase
    policy: str
    configuration: ModelConfiguration
    tensors: Mapping[str, NDArray[Any]]
    threshold: float
    section: ReinforcementSection
    epsilon: float  # probability of a random action
    seed: tuple[int, ...]


@dataclass(frozen=True, slots=True, eq=False)
class Transitions:
    """K decisions with their returns."""

    state: NDArray[np.float32]  # x_c at the decision, shape (K, H)
    action: NDArray[np.int64]  # index into ACTIONS, shape (K,)
    reward: NDArray[np.float32]  # discounted, until the next state, shape (K,)
    discount: NDArray[np.float32]  # of the next state's value, 0 where the episode has ended, shape (K,)
    after: NDArray[np.float32]  # the next state, zero where the episode has ended, shape (K, H)

    def __len__(self) -> int:
        return len(self.action)


@dataclass(frozen=True, slots=True, eq=False)
class Rolled:
    """What an episode came to."""

    transitions: Transitions
    name: str
    is_violation: bool  # without repair
    outcome: str
    total: float  # sum of the decisions' rewards
    dose: float  # [s]


@dataclass(slots=True)
class _Deed:
    """One decision of the adapter and the ticks for which it held."""

    state: NDArray[np.float32]
    action: int
    reward: float = 0.0
    discount: float = 1.0


@dataclass
class ExploringRepair:
    """ADReFT whose adapter acts epsilon-greedily and whose decisions hold for some ticks."""

    model: AdreftModel
    section: ReinforcementSection
    epsilon: float
    generator: np.random.Generator
    name: str = "adreft"
    deeds: list[_Deed] = field(default_factory=list)
    score: float = 0.0  # of the last tick
    has_decided: bool = False  # at the last tick

    def __post_init__(self) -> None:
        self._tokenizer = self.model.tokenizer()
        self._held = 0  # ticks since the last decision, itself included
        self._action = 0
        self._last = 1.0, 0.0  # factor and reward of the last tick

    def reset(self, route: Route) -> None:
        """Begin an episode on ``route``."""
        self._tokenizer.reset(route)
        self._held = self.section.interval
        self.deeds.clear()

    def propose(self, scene: Scene, decision: Decision) -> Proposal:
        """Judge one tick; decide if it is time to."""
        tokens = self._tokenizer.tokens(scene, decision)
        state = self.model.encode(tokens.values)
        self.score = self.model.score(state, decision.command.action)
        is_asked = self.section.decisions == "all" or self.score > self.model.threshold
        self.has_decided = is_asked and self._held >= self.section.interval
        if self.has_decided:
            self._action = int(self.model.values(state, decision.command.action).argmax())
            if self.generator.random() < self.epsilon:
                self._action = int(self.generator.integers(len(ACTIONS)))
            self.deeds.append(_Deed(state, self._action))
            self._held = 0
        self._held += 1
        return Proposal(self.score, self.model.threshold, ACTIONS[self._action])

    def watch(self, _tick: Tick, _decision: Decision, repair: Repair) -> None:
        """Credit the tick that was just answered to the last decision."""
        if not self.deeds:
            return
        section, deed = self.section, self.deeds[-1]
        change = abs(repair.policy_action - repair.final_action)
        reward = (1.0 - self.score) * (1.0 - 0.5 * change) if section.step_reward else 0.0
        reward -= section.dose * change**section.dose_exponent * INTERVAL + section.time / section.interval
        self._last = deed.discount, reward
        deed.reward += deed.discount * reward
        deed.discount *= section.gamma
        if self.has_decided and section.action == "executed":
            deed.action = int(np.abs(_ACTIONS - repair.final_action).argmin())

    def end(self, outcome: EventKind) -> None:
        """Credit the end of the episode to the last decision."""
        if not self.deeds:
            return
        section, deed = self.section, self.deeds[-1]
        factor, reward = self._last
        if outcome == EventKind.COLLISION:
            deed.reward += factor * (section.violation - reward)  # in the place of the last step's reward
        else:
            deed.reward += factor * (section.goal if outcome == EventKind.GOAL else section.timeout)
        deed.discount = 0.0


def explore(roll: Roll) -> Rolled:
    """Drive one episode.

    Raises:
        InputError: the scenario or the policy is unusable.
        SimulationError: SUMO failed.
    """
    model = AdreftModel(roll.configuration, roll.tensors, roll.threshold)
    method = ExploringRepair(model, roll.section, roll.epsilon, np.random.default_rng(roll.seed))
    summary = run_episode(
        roll.case.scenario(), make_policy(roll.policy), Answering(GuardedRepairer(method)), method.watch
    )
    method.end(summary.outcome)
    total = sum(deed.reward for deed in method.deeds)
    transitions = link(method.deeds, roll.section.steps, roll.configuration.encoder.hidden)
    return Rolled(transitions, roll.case.name, roll.case.is_violation, summary.outcome.name, total, summary.dose)


def link(deeds: list[_Deed], steps: int, hidden: int) -> Transitions:
    """Transitions over ``steps`` decisions each; those near the end reach to the end."""
    count = len(deeds)
    reward, discount = np.zeros(count, dtype=np.float32), np.zeros(count, dtype=np.float32)
    after = np.zeros((count, hidden), dtype=np.float32)
    for first in range(count):
        total, factor = 0.0, 1.0
        last = min(first + steps, count)
        for deed in deeds[first:last]:
            total += factor * deed.reward
            factor *= deed.discount
        reward[first] = total
        if last < count:
            discount[first] = factor
            after[first] = deeds[last].state
    state = np.array([deed.state for deed in deeds], dtype=np.float32).reshape(count, hidden)
    return Transitions(state, np.array([deed.action for deed in deeds], dtype=np.int64), reward, discount, after)


_FIELDS = ("state", "action", "reward", "discount", "after")


class ReplayMemory:
    """Forgets the oldest when it is full. The encoder is frozen, so states are kept instead of scenes."""

    def __init__(self, capacity: int, hidden: int) -> None:
        self._arrays: dict[str, NDArray[Any]] = {
            "state": np.zeros((capacity, hidden), dtype=np.float32),
            "action": np.zeros(capacity, dtype=np.int64),
            "reward": np.zeros(capacity, dtype=np.float32),
            "discount": np.zeros(capacity, dtype=np.float32),
            "after": np.zeros((capacity, hidden), dtype=np.float32),
        }
        self._capacity = capacity
        self.added = 0  # transitions ever added

    def __len__(self) -> int:
        return min(self.added, self._capacity)

    def add(self, transitions: Transitions) -> None:
        """Remember transitions; of more than fit, the last ones."""
        count = len(transitions)
        kept = min(count, self._capacity)
        places = (self.added + count - kept + np.arange(kept)) % self._capacity
        for name, array in self._arrays.items():
            array[places] = getattr(transitions, name)[count - kept :]
        self.added += count

    def sample(self, size: int, generator: np.random.Generator) -> Transitions:
        """Draw uniformly with replacement."""
        chosen = generator.integers(len(self), size=size)
        return Transitions(*(self._arrays[name][chosen] for name in _FIELDS))

    def tensors(self, prefix: str) -> dict[str, NDArray[Any]]:
        """All that is remembered, by name."""
        return {f"{prefix}{name}": array[: len(self)] for name, array in self._arrays.items()}

    def load(self, tensors: dict[str, NDArray[Any]], prefix: str, added: int) -> None:
        """Remember again what ``tensors`` gave."""
        self.added = added
        for name, array in self._arrays.items():
            array[: len(self)] = tensors[f"{prefix}{name}"]
