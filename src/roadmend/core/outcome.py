"""How an episode ends and what happens on the way."""

from dataclasses import dataclass
from enum import IntEnum


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


@dataclass(frozen=True, slots=True)
class Event:
    """Something that happened to the episode at ``time`` [s]."""

    time: float
    kind: EventKind
    text: str
    object_ids: tuple[int, ...] = ()
    object_names: tuple[str, ...] = ()
