"""Records a run in this process as a bag of the graph."""

from collections.abc import Callable

from roadmend.core.command import Decision
from roadmend.core.episode_result import EpisodeResult
from roadmend.core.repair import Repair
from roadmend.core.route import Route
from roadmend.core.tick import Tick
from roadmend.recording.episode_writer import EpisodeWriter
from roadmend.recording.writer import BagWriter
from roadmend.world.road_network import LaneMap

DRAWN = 2  # every second tick is drawn: 10 times a second, as viz_node does


class EpisodeRecorder:
    """Turns what the runner reports into messages; its methods are the runner's watchers.

    Args:
        writer: the bag.
        method_at: which repair method answers at a time [s].
        lanes: the map; without it the bag has none.
    """

    def __init__(self, writer: BagWriter, method_at: Callable[[float], str], lanes: LaneMap | None) -> None:
        self._episode = EpisodeWriter(writer)
        self._method_at = method_at
        self._lanes = lanes
        self._route: Route | None = None

    def opened(self, route: Route) -> None:
        """The episode begins."""
        self._route = route
        self._episode.route(route, self._lanes)

    def answered(self, tick: Tick, decision: Decision, repair: Repair) -> None:
        """A tick was decided."""
        time = tick.scene.time
        self._seen(tick)
        self._episode.decision(time, decision)
        self._episode.repair(time, repair, self._method_at(time))
        if tick.number % DRAWN == 0:
            self._draw(tick, decision, repair)

    def ended(self, tick: Tick) -> None:
        """The final tick was reached."""
        self._seen(tick)
        self._draw(tick)

    def _seen(self, tick: Tick) -> None:
        self._episode.scene(tick.scene)
        for event in tick.events:
            self._episode.event(event)

    def _draw(self, tick: Tick, decision: Decision | None = None, repair: Repair | None = None) -> None:
        if self._route is not None:
            self._episode.drawing(tick.scene, self._route, decision, repair)


def account_of(summary: EpisodeResult, messages: int) -> dict[str, str]:
    """What a bag says of the end of the run in it."""
    return {
        "clock": "lockstep",
        "messages": f"{messages}",
        "lost_messages": "0",
        "outcome": summary.outcome.name,
        "outcome_text": summary.text,
        "outcome_time": f"{summary.duration:g}",
    }
