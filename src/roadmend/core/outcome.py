"""How an episode ends and what happens on the way."""

from dataclasses import dataclass
from enum import IntEnum

from roadmend.core.scene import ObjectKind


class EventKind(IntEnum):
    """Mirrors roadmend_msgs/ScenarioEvent."""

    STARTED = 0
    GOAL = 1
    COLLISION = 2
    TIMEOUT = 3
    OFF_ROUTE = 4
    ABORTED = 5
    WATCHDOG = 6
    RECOVERED = 7
    CHANGE_LANE = 8
    CLEARED = 9

    @property
    def is_final(self) -> bool:
        """Whether the episode is over with this event."""
        return EventKind.GOAL <= self <= EventKind.ABORTED


class Blame(IntEnum):
    """What kind of contact a collision was, by nuPlan's rules (``world.blame``); mirrors roadmend_msgs/ScenarioEvent."""

    UNKNOWN = 0  # no collision, or recorded by a version that did not say
    EGO_STOOD = 1  # the other hit the standing ego
    OTHER_STOOD = 2  # the ego hit one who stood
    FRONT = 3  # the ego's front hit the other
    REAR = 4  # the other hit the ego's rear
    SIDE = 5  # the other hit the ego's side
    CHANGING = 6  # the ego was changing lanes

    @property
    def is_egos(self) -> bool:
        """Whether the ego is at fault."""
        return self in {Blame.OTHER_STOOD, Blame.FRONT, Blame.CHANGING}


@dataclass(frozen=True, slots=True)
class Event:
    """Something that happened to the episode at ``time`` [s]. Programs read the other fields, never the text."""

    time: float
    kind: EventKind
    text: str  # one line for people
    object_ids: tuple[int, ...] = ()  # who else was in it
    object_names: tuple[str, ...] = ()
    object_kinds: tuple[ObjectKind, ...] = ()
    blame: Blame = Blame.UNKNOWN  # of a collision
    impact_speed: float | None = None  # [m/s] of the ego at a collision; None where there is none, or not known

    @property
    def at_fault(self) -> bool:
        """Whether it is a collision by the ego's own fault."""
        return self.blame.is_egos
