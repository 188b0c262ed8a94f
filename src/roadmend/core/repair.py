"""What a repair is: the command that goes to the vehicle and the account of how it came about."""

import math
from dataclasses import dataclass, field, replace
from enum import IntEnum
from typing import Self

from roadmend.core.command import Command
from roadmend.core.tick import INTERVAL


class RepairStatus(IntEnum):
    """State of the repair node; mirrors roadmend_msgs/RepairState."""

    PASS = 0
    REPAIRED = 1
    STARTING = 2
    STALE_COMMAND = 3
    STALE_OBJECTS = 4
    INVALID_COMMAND = 5
    INVALID_OBJECTS = 6
    RESET = 7
    MODEL_FAULT = 8


@dataclass(frozen=True, slots=True)
class RepairTrigger:
    """A participant that made a method step in."""

    object_id: int
    weight: float  # in the method's own measure, larger is weightier


@dataclass(frozen=True, slots=True)
class Proposal:
    """What a repair method would do, before the merger decides (ADReFT section 3.1.4)."""

    score: float  # how critical the scene is; NaN where the method has no score
    threshold: float  # the method steps in where score > threshold; NaN where it has none
    action: float  # proposed throttle - brake, -1 .. 1
    triggers: tuple[RepairTrigger, ...] = ()
    reason: str = ""
    worth: float | None = None  # see Repair.worth
    hold_back: bool = False  # whether a lane change that the policy would begin at this tick must wait


@dataclass(frozen=True, slots=True)
class Repair:
    """The repaired command of one tick."""

    command: Command
    status: RepairStatus
    score: float
    threshold: float
    policy_action: float
    repair_action: float
    intervened: bool
    dropped_objects: int = 0
    triggers: tuple[RepairTrigger, ...] = field(default=())
    reason: str = ""
    worth: float | None = None  # by how much the proposed action is judged better than leaving the policy alone, in
    # prices of a collision; None where the method judges no worth, which is not the same as none
    held_back: bool = False  # whether the merger held back a lane change that the policy asked for

    def without_lane_change(self) -> Self:
        """The same, with the lane change that the policy asked for held back."""
        return replace(self, command=replace(self.command, change_lane=False), intervened=True, held_back=True)

    @property
    def change(self) -> float:
        """By how much the policy's action was changed, 0 .. 2; 0 where it said nothing that is a number."""
        change = abs(self.policy_action - self.final_action)
        return 0.0 if math.isnan(change) else change

    @property
    def final_action(self) -> float:
        """Throttle - brake that goes to the vehicle."""
        return self.command.action


@dataclass(slots=True)
class Interventions:
    """Replaced commands, counted and measured (ADReFT section 4, metrics)."""

    ticks: int = 0  # whose command was replaced
    change: float = 0.0  # sum of |policy's action - final action| over them, 0 .. 2 each

    def add(self, repair: Repair) -> None:
        """Count one answer."""
        if repair.intervened:
            self.ticks += 1
            self.change += repair.change

    @property
    def intensity(self) -> float:
        """Mean change of a replaced command, 0 .. 2; 0 where none was."""
        return self.change / self.ticks if self.ticks else 0.0

    @property
    def dose(self) -> float:
        """Seconds of full command: the change times the interval."""
        return self.change * INTERVAL


def played(command: Command, wanted: float) -> Repair:
    """The answer of a repairer that plays what was planned and judges nothing: ``wanted`` where the policy brakes less.

    Args:
        command: the policy's.
        wanted: throttle - brake, -1 .. 1.
    """
    asked = command.action
    if wanted >= asked:
        return Repair(command, RepairStatus.PASS, 0.0, 0.5, asked, wanted, intervened=False)
    final = Command.from_action(wanted, change_lane=command.change_lane)
    return Repair(final, RepairStatus.REPAIRED, 1.0, 0.5, asked, wanted, intervened=True)
