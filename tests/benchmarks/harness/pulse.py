"""Brake pulses: profiles that are planned beforehand and played against a policy in the loop."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

from roadmend.core.command import Decision
from roadmend.core.repair import Repair, played
from roadmend.core.route import Route
from roadmend.core.scene import Scene
from roadmend.core.tick import INTERVAL


class DoseExceededError(Exception):
    """A played profile has cost as much as it may; the rest of the episode is of no interest."""


@dataclass(frozen=True, slots=True)
class Pulse:
    """From tick ``begin`` on, for ``ticks`` ticks, no more than ``action``: min(policy's action, ``action``)."""

    begin: int  # tick, 0 is the first decision of an episode
    ticks: int
    action: float  # throttle - brake, a bin of repair.actions

    @property
    def end(self) -> int:
        """The first tick after it."""
        return self.begin + self.ticks

    @property
    def start(self) -> float:
        """Simulation time of its first tick [s]."""
        return self.begin * INTERVAL

    @property
    def duration(self) -> float:
        """How long it lasts [s]."""
        return self.ticks * INTERVAL


class PulsePlayer:
    """A repairer (``core.interfaces.Repairer``) that plays pulses and looks at nothing.

    Unlike every other repairer it stops the episode with an exception, ``DoseExceededError``, where ``limit`` is
    reached: it is for searches over re-simulations, never for a vehicle.
    """

    name = "pulse"

    def __init__(self, pulses: Sequence[Pulse] = (), limit: float = math.inf) -> None:
        """Plan the profile.

        Args:
            pulses: may overlap; the least action counts.
            limit: dose [s] that the profile must stay below.
        """
        self._pulses = tuple(pulses)
        self._limit = limit
        self._tick = 0
        self._dose = 0.0
        self.actions: list[float] = []  # the policy's, tick by tick

    def reset(self, route: Route) -> None:
        """Begin an episode."""
        del route
        self._tick = 0
        self._dose = 0.0
        self.actions.clear()

    def step(self, scene: Scene, decision: Decision) -> Repair:
        """Play one tick.

        Raises:
            DoseExceededError: the dose has reached the limit.
        """
        del scene
        tick, command = self._tick, decision.command
        asked = command.action
        self._tick += 1
        self.actions.append(asked)
        planned = min((pulse.action for pulse in self._pulses if pulse.begin <= tick < pulse.end), default=1.0)
        self._dose += max(0.0, asked - planned) * INTERVAL
        if planned < asked and self._dose >= self._limit:
            raise DoseExceededError
        return played(command, planned)
