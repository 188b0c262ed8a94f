"""One step of an episode: what there is to see, and what happened."""

from dataclasses import dataclass

from roadmend.core.outcome import Event
from roadmend.core.scene import Scene

INTERVAL_NS = 50_000_000  # [ns] between ticks: 20 Hz
INTERVAL = INTERVAL_NS * 1e-9  # [s]


@dataclass(frozen=True, slots=True)
class Tick:
    """What is known after one step."""

    number: int
    scene: Scene
    min_distance: float  # [m] between the ego's outline and the nearest other; exact below world.participants.NEAR
    events: tuple[Event, ...]
    final: Event | None  # set on the last tick
