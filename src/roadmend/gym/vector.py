"""Several environments at once, each in a worker process: SUMO holds one simulation a process."""

from functools import partial
from typing import Any

import gymnasium
from gymnasium.vector import AsyncVectorEnv

from roadmend.api.given import RepairLike
from roadmend.core.errors import InputError
from roadmend.gym.drive import DriveEnv
from roadmend.gym.repair import RepairWrapper


def make_vector(num_envs: int = 1, *, repair: RepairLike | None = None, **settings: Any) -> AsyncVectorEnv:
    """Gymnasium's vector environment over ``num_envs`` processes; ``gymnasium.make_vec`` calls it.

    The processes are started anew, so that the script that asks for them must stand under
    ``if __name__ == "__main__":``.

    Args:
        num_envs: how many.
        repair: a repair method that stands between, by name or as a class that stands in a file; None for none.
        settings: of ``DriveEnv``.

    Raises:
        InputError: an argument is unusable.
    """
    if num_envs < 1:
        raise InputError("roadmend/Drive-v0: num_envs", f"is {num_envs!r}", "give a whole number from 1 on")
    return AsyncVectorEnv([partial(_make, repair, settings)] * num_envs, context="spawn")


def _make(repair: RepairLike | None, settings: dict[str, Any]) -> gymnasium.Env[Any, Any]:
    env = DriveEnv(**settings)
    return env if repair is None else RepairWrapper(env, repair)
