"""Several environments at once, each in a worker process: SUMO holds one simulation a process."""

from functools import partial
from typing import Any

import gymnasium
from gymnasium.vector import AsyncVectorEnv

from roadmend.api.given import RepairLike, Settings
from roadmend.core.errors import InputError
from roadmend.core.whole_number import whole_number
from roadmend.gym.drive import DriveEnv
from roadmend.gym.registration import ENVIRONMENT
from roadmend.gym.repair import RepairWrapper


def make_vector(
    num_envs: int = 1,
    *,
    repair: RepairLike | None = None,
    parameters: Settings | None = None,
    seed: int = 0,
    price: float = 0.0,
    **settings: Any,
) -> AsyncVectorEnv:
    """Gymnasium's vector environment over ``num_envs`` processes; ``gymnasium.make_vec`` calls it.

    The processes are started anew, so that the script that asks for them must stand under
    ``if __name__ == "__main__":``.

    Args:
        num_envs: how many.
        repair: a repair method that stands between, by name or as a class that stands in a file; None for none.
        parameters: of it, as ``RepairWrapper`` takes them.
        seed: likewise, the same in each process.
        price: likewise.
        settings: of ``DriveEnv``.

    Raises:
        InputError: an argument is unusable.
    """
    num_envs = whole_number(f"{ENVIRONMENT}: num_envs", num_envs, 1)
    if repair is None and (parameters or seed or price):
        what = "is given parameters, a seed or a price of a repair method, and none that repairs"
        raise InputError(ENVIRONMENT, what, 'give one, such as repair="rss"')
    of_repair = {"parameters": parameters, "seed": seed, "price": price}
    return AsyncVectorEnv([partial(_make, repair, of_repair, settings)] * num_envs, context="spawn")


def _make(repair: RepairLike | None, of_repair: dict[str, Any], settings: dict[str, Any]) -> gymnasium.Env[Any, Any]:
    env = DriveEnv(**settings)
    return env if repair is None else RepairWrapper(env, repair, **of_repair)
