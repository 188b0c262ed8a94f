"""What a repair is: the command that goes to the vehicle and the account of how it came about."""

from dataclasses import dataclass, field
from enum import IntEnum

from roadmend.core.command import Command


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
class Trigger:
    """A participant that made a method step in."""

    object_id: int
    weight: float  # in the method's own measure, larger is weightier


@dataclass(frozen=True, slots=True)
class Proposal:
    """What a repair method would do, before the merger decides (ADReFT section 3.1.4)."""

    score: float  # how critical the scene is; NaN where the method has no score
    threshold: float  # the method steps in where score > threshold; NaN where it has none
    action: float  # proposed throttle - brake, -1 .. 1
    triggers: tuple[Trigger, ...] = ()
    reason: str = ""


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
    triggers: tuple[Trigger, ...] = field(default=())
    reason: str = ""

    @property
    def final_action(self) -> float:
        """Throttle - brake that goes to the vehicle."""
        return self.command.action
