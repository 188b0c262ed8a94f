"""Repair as a wrapper: a learner that drives, and is trained, under a repair method."""

import math
from collections.abc import Iterator
from typing import Any

import gymnasium
import numpy as np
from gymnasium.utils import RecordConstructorArgs

from roadmend.api.given import RepairLike, Settings, repairer_of
from roadmend.core.command import Decision, Trajectory
from roadmend.core.errors import InputError
from roadmend.core.repair import Repair
from roadmend.gym.drive import DriveEnv
from roadmend.gym.observation import Observation
from roadmend.gym.observer import command_of

_NO_PLAN = Trajectory.empty()


class RepairWrapper(gymnasium.Wrapper[Observation, np.ndarray, Observation, np.ndarray], RecordConstructorArgs):
    """Between the learner and ``roadmend/Drive-v0``: the repaired command is driven, behind the guard, as in the graph.

    A learner plans no trajectory, so that the method assumes that the present motion goes on. ``info`` gets ``repair``:
    status, intervened, policy_action, final_action, score, threshold and reason; and ``reward_terms`` gets ``repair``.
    """

    def __init__(
        self,
        env: gymnasium.Env[Observation, np.ndarray],
        repair: RepairLike = "rss",
        *,
        parameters: Settings | None = None,
        seed: int = 0,
        price: float = 0.0,
    ) -> None:
        """Wrap an environment.

        Args:
            env: ``roadmend/Drive-v0``, perhaps in wrappers that leave actions as they are.
            repair: the method: a name, a class, or an object.
            parameters: what differs from the method's defaults.
            seed: for methods that draw numbers.
            price: reward for a change of the action by 1, 0 to 2 are possible; 0 or less.

        Raises:
            InputError: it is another environment, or an argument is unusable.
        """
        # So that Gymnasium can make the same one anew from its spec.
        RecordConstructorArgs.__init__(self, repair=repair, parameters=parameters, seed=seed, price=price)
        gymnasium.Wrapper.__init__(self, env)
        if not isinstance(env.unwrapped, DriveEnv):
            raise InputError("RepairWrapper", f"cannot repair in {env.unwrapped}", "wrap roadmend/Drive-v0")
        if any(isinstance(layer, RepairWrapper) for layer in _layers(env)):
            raise InputError("RepairWrapper", "there is one already around this environment", "wrap it once")
        if not _is_price(price):
            raise InputError("RepairWrapper: price", f"is {price!r}", "give 0 or less")
        self._drive: DriveEnv = env.unwrapped
        self._repairer = repairer_of(repair, parameters, seed)
        self._price = price
        self._drive.method = self._repairer.name
        self._drive.taken = (2,)  # a method may hold a lane change back where the learner has no say in it

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Observation, dict[str, Any]]:
        """Begin an episode; see ``DriveEnv.reset``."""
        begun = self.env.reset(seed=seed, options=options)
        self._repairer.reset(self._drive.route)
        return begun

    def step(self, action: np.ndarray) -> tuple[Observation, float, bool, bool, dict[str, Any]]:
        """Drive one tick on the repaired action; see ``DriveEnv.step``."""
        command = command_of(action, self.action_space.shape)
        repair = self._repairer.step(self._drive.tick.scene, Decision(command, _NO_PLAN))
        self._drive.note(repair)
        final = repair.command
        # In double precision, as the method has it: what is driven is what it says, to the bit.
        driven = np.array([final.action, 1.0 if final.change_lane else -1.0])
        observation, reward, terminated, truncated, info = self.env.step(driven)
        term = self._price * repair.change
        info["repair"] = _plain(repair)
        info["reward_terms"] = {**info["reward_terms"], "repair": term}
        return observation, float(reward) + term, terminated, truncated, info


def _is_price(given: object) -> bool:
    return isinstance(given, int | float) and not isinstance(given, bool) and -math.inf < given <= 0.0


def _layers(env: gymnasium.Env[Any, Any]) -> Iterator[gymnasium.Env[Any, Any]]:
    yield env
    while isinstance(env, gymnasium.Wrapper):
        env = env.env
        yield env


def _plain(repair: Repair) -> dict[str, Any]:
    return {
        "status": repair.status.name,
        "intervened": repair.intervened,
        "policy_action": repair.policy_action,
        "final_action": repair.final_action,
        "score": repair.score,
        "threshold": repair.threshold,
        "reason": repair.reason,
    }
