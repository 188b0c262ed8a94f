"""Driving as an environment of Gymnasium: ``roadmend/Drive-v0``, told on the page src/doc/gymnasium.md.

Gymnasium finds it by itself where roadmend is installed; in a clone ``import roadmend.gym`` makes it known. Nothing that
drives is loaded before one is made.
"""

from importlib import import_module

from roadmend.gym.registration import ENVIRONMENT, register

__all__ = ["ENVIRONMENT", "register"]

_HOMES = {
    "DriveEnv": "roadmend.gym.drive",
    "LearnedPolicy": "roadmend.gym.observer",
    "RepairWrapper": "roadmend.gym.repair",
    "RewardWeights": "roadmend.gym.reward",
    "make_vector": "roadmend.gym.vector",
}


def __getattr__(name: str) -> object:
    if name not in _HOMES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(_HOMES[name]), name)


register()
