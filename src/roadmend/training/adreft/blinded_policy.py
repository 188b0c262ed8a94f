"""A policy that does not see everybody for a while: a source of collisions that no search has shaped."""

import random
from dataclasses import dataclass, replace

import numpy as np

from roadmend.core.command import Decision
from roadmend.core.interfaces import Policy
from roadmend.core.route import Route
from roadmend.core.scene import Scene

_LATEST = 0.5  # of an episode: by then a blindness has begun
_SHORTEST, _LONGEST = 5.0, 60.0  # [s] of blindness; shorter ones seldom end in a collision
_SEEN = 0.3  # greatest share of the participants that are seen all the same


@dataclass(frozen=True, slots=True)
class Blindness:
    """From ``begin`` to ``end`` [s] a participant is seen only if its number, scattered, is below ``seen``."""

    begin: float
    end: float
    seen: float  # share of the participants, 0 .. 1
    salt: int


def draw_blindness(seed: str, duration: float) -> Blindness:
    """A blindness within an episode of ``duration`` [s]."""
    chance = random.Random(seed)
    begin = chance.uniform(0.0, _LATEST * duration)
    return Blindness(
        begin, begin + chance.uniform(_SHORTEST, _LONGEST), chance.uniform(0.0, _SEEN), chance.randrange(1 << 16)
    )


class BlindedPolicy:
    """Drives as ``policy`` would if it did not see some participants (``core.interfaces.Policy``)."""

    def __init__(self, policy: Policy, blindness: Blindness) -> None:
        self.name = policy.name
        self._policy, self._blindness = policy, blindness

    def reset(self, route: Route) -> None:
        """Begin an episode on ``route``."""
        self._policy.reset(route)

    def step(self, scene: Scene) -> Decision:
        """Decide for one tick."""
        blindness = self._blindness
        if blindness.begin <= scene.time < blindness.end and len(scene.objects):
            scattered = (scene.objects.id.astype(np.uint64) * np.uint64(40503) + np.uint64(blindness.salt)) % np.uint64(
                997
            )
            scene = replace(scene, objects=scene.objects.select(scattered < blindness.seen * 997.0))
        return self._policy.step(scene)
