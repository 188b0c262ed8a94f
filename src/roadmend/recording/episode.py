"""A recorded episode as a whole, for pictures and for the analysis of failures. Needs no ROS."""

from dataclasses import dataclass, field
from pathlib import Path

from roadmend.core.command import Trajectory
from roadmend.core.errors import InputError
from roadmend.core.outcome import Event, EventKind
from roadmend.core.repair import Repair
from roadmend.core.route import Route
from roadmend.core.scene import EgoState, ObjectList
from roadmend.core.spell_account import SpellAccount, SpellAccountBuilder
from roadmend.recording.layout import RECORD
from roadmend.recording.messages import sized
from roadmend.recording.reader import BagReader
from roadmend.recording.ticks import BagTicks
from roadmend.world.road_network import LaneMap


@dataclass(slots=True)
class BagEpisode:
    """What a bag tells of an episode, by the stamp [ns] of each tick; a bag may lack anything but the ego."""

    path: Path
    ego: dict[int, EgoState] = field(default_factory=dict)
    objects: dict[int, ObjectList] = field(default_factory=dict)
    trajectories: dict[int, Trajectory] = field(default_factory=dict)
    repairs: dict[int, Repair] = field(default_factory=dict)
    route: Route | None = None
    lanes: LaneMap | None = None
    events: list[Event] = field(default_factory=list)
    account: dict[str, str] = field(default_factory=dict)  # what the recorder says of the run

    @property
    def stamps(self) -> list[int]:
        """Stamps of the ticks [ns], rising."""
        return sorted(self.ego)

    @property
    def outcome(self) -> str:
        """How the last episode ended, in words; empty where it has no end."""
        for event in reversed(self.events):
            if event.kind.is_final:
                return event.kind.name.lower().replace("_", " ")
            if event.kind is EventKind.STARTED:
                break
        return ""

    def spells(self) -> tuple[SpellAccount, ...]:
        """The interventions, explained; without the answer to a final tick, on which nobody drives."""
        builder = SpellAccountBuilder()
        ends = {round(event.time * 1e9) for event in self.events if event.kind.is_final}
        for stamp, repair in sorted(self.repairs.items()):
            if stamp not in ends and builder.add(stamp * 1e-9, repair) and stamp in self.ego and stamp in self.objects:
                builder.see(self.ego[stamp], self.objects[stamp])
        return builder.accounts


def read_episode(path: Path) -> BagEpisode:
    """Read the one episode that a bag holds; raises what ``episode_of`` does, and if there is no such bag."""
    return episode_of(BagReader(path))


def episode_of(reader: BagReader) -> BagEpisode:
    """Read the one episode that an open bag holds.

    Raises:
        InputError: the bag is cut short, or nothing of an ego is in it.
    """
    episode = BagEpisode(reader.path, account=reader.metadata.get(RECORD, {}))
    for tick in BagTicks(reader, needed=()):
        if tick.ego is not None:
            episode.ego[tick.stamp] = tick.ego
        if tick.objects is not None:
            episode.objects[tick.stamp] = tick.objects
        if tick.trajectory is not None:
            episode.trajectories[tick.stamp] = tick.trajectory
        if tick.repair is not None:
            episode.repairs[tick.stamp] = tick.repair
        episode.route = tick.route or episode.route
        episode.lanes = tick.lanes or episode.lanes
        episode.events += tick.events
    if not episode.ego:
        raise InputError(
            str(reader.path), "holds no odometry of an ego", "name a bag that an episode was recorded into"
        )
    if episode.route is not None:
        episode.ego = {stamp: sized(ego, episode.route) for stamp, ego in episode.ego.items()}
    return episode
