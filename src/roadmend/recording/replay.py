"""What a replay plays, tick by tick, and when each tick is due. Needs no ROS."""

from collections import deque
from collections.abc import Collection, Iterable, Iterator
from dataclasses import dataclass, replace

from roadmend.core.errors import InputError
from roadmend.recording.qos import Qos
from roadmend.recording.reader import BagReader, Record
from roadmend.recording.renewal import Renewal, is_installed
from roadmend.recording.topics import CLOCK

DEPTH_MAX = 1000  # messages that a replayed publisher keeps at most where the bag does not tell its depth
_NANOSECONDS = 1_000_000_000
_TICK_BYTES_MAX = 1 << 26  # a bag without a clock is one tick as a whole: such a tick is played in parts


@dataclass(frozen=True, slots=True)
class ReplayTick:
    """Messages of one time, in the order in which they were recorded."""

    time_ns: int
    records: tuple[Record, ...]


class ReplaySource:
    """The messages of some topics of a bag, from a moment on; repair states of an earlier version as such of this one.

    Args:
        reader: the bag.
        topics: the topics to play.
        start_offset: where to begin [s after the bag's first message].

    Raises:
        InputError: the bag is empty, or the beginning lies outside it.
    """

    def __init__(self, reader: BagReader, topics: Collection[str], start_offset: float = 0.0) -> None:
        if not reader.count:
            raise InputError(str(reader.path), "holds no messages", "take another bag")
        length = (reader.end_ns - reader.start_ns) / _NANOSECONDS
        if not 0.0 <= start_offset <= length:
            raise InputError(
                "start", f"{start_offset:g} s is outside the bag", f"give a time from 0 to {length:g} s after its start"
            )
        self.start_ns = reader.start_ns + round(start_offset * _NANOSECONDS)
        self.end_ns = reader.end_ns
        self._reader = reader
        self._renewal = Renewal(reader)
        self._topics = list(topics)

    def latched(self) -> list[Record]:
        """What a late joiner would have got at the beginning: the last earlier messages of the latched topics."""
        if self.start_ns == self._reader.start_ns:
            return []
        known = self._reader.topics
        offers = {name: offer_of(known[name].offers, known[name].count) for name in self._topics}
        kept = {
            name: deque[Record](maxlen=offer.depth)
            for name, offer in offers.items()
            if offer.durability == "transient_local"
        }
        for record in self._renewal.records(list(kept)) if kept else ():
            if record.time_ns >= self.start_ns:
                break
            kept[record.topic].append(record)
        return sorted((record for records in kept.values() for record in records), key=lambda record: record.time_ns)

    def ticks(self) -> Iterator[ReplayTick]:
        """The ticks from the beginning on, in the order of their time."""
        records: list[Record] = []
        size = 0
        for record in self._renewal.records(self._topics):
            if record.time_ns < self.start_ns:
                continue
            if records and (record.time_ns != records[0].time_ns or size > _TICK_BYTES_MAX):
                yield ReplayTick(records[0].time_ns, tuple(records))
                records, size = [], 0
            records.append(record)
            size += len(record.data)
        if records:
            yield ReplayTick(records[0].time_ns, tuple(records))


class Playhead:
    """Where a replay is: a simulation time that runs ``rate`` times as fast as the wall clock, or stands.

    Args:
        rate: simulated seconds a second of wall time, above zero.
        paused: whether it stands until ``resume``.
    """

    def __init__(self, rate: float, *, paused: bool = False) -> None:
        self.paused = paused
        self._rate = rate
        self._time_ns = 0.0  # where it was at the wall time below
        self._wall = 0.0  # [s]

    def time_ns(self, now: float) -> float:
        """Simulation time [ns] at wall time ``now`` [s]."""
        if self.paused:
            return self._time_ns
        return self._time_ns + (now - self._wall) * self._rate * _NANOSECONDS

    def seek(self, time_ns: float, now: float) -> None:
        """Go to a simulation time [ns]."""
        self._time_ns, self._wall = time_ns, now

    def pause(self, now: float) -> None:
        """Stand."""
        self.seek(self.time_ns(now), now)
        self.paused = True

    def resume(self, now: float) -> None:
        """Run on from where it stands."""
        self.seek(self.time_ns(now), now)
        self.paused = False

    def set_rate(self, rate: float, now: float) -> None:
        """Run at another rate from here on."""
        self.seek(self.time_ns(now), now)
        self._rate = rate


def select_topics(reader: BagReader, wanted: Collection[str], exclude: Collection[str]) -> list[str]:
    """The topics of a bag to play: the wanted ones and the clock, all if none is named, less the excluded ones.

    A name without a leading "/" means the topic in the root namespace.

    Raises:
        InputError: a name is no topic of the bag, or nothing is left to play.
    """
    names = [find_topic(reader, name) for name in wanted] or [*reader.topics]
    if CLOCK in reader.topics:
        names.append(CLOCK)
    # A bag without a clock is played with one, which can be excluded as well.
    left_out = {absolute(name) for name in exclude}
    for name in left_out - {CLOCK}:
        find_topic(reader, name)
    chosen = [name for name in dict.fromkeys(names) if name not in left_out]
    if not chosen:
        raise InputError(str(reader.path), "no topic is left to play", "exclude fewer")
    return chosen


def find_topic(reader: BagReader, name: str) -> str:
    """The full name of a topic of a bag.

    Raises:
        InputError: the bag has no such topic.
    """
    found = absolute(name)
    if found not in reader.topics:
        raise InputError(
            f"topic {found}", f"is not in {reader.path}", f"choose from {', '.join(sorted(reader.topics))}"
        )
    return found


def check_definition(reader: BagReader, topic: str) -> None:
    """Make sure that the installed type of a topic reads its messages as a ``Renewal`` hands them on.

    Raises:
        InputError: the type is not installed, or its definition is not the one that the topic was recorded with.
    """
    summary = reader.topics[topic]
    if not is_installed(Renewal(reader).definition(summary.type_name)):
        raise InputError(
            topic, f"was recorded with another definition of {summary.type_name}", "install that version of its package"
        )


def absolute(name: str) -> str:
    """The name with its leading "/"."""
    return f"/{name.lstrip('/')}"


def offer_of(recorded: Iterable[Qos], count: int) -> Qos:
    """What one publisher must offer so that whoever listened to the recorded publishers can listen to it.

    Equal offers are offered again as they were. Of different ones, the stronger policy is offered. DDS does not tell
    the depth of a remote publisher: where the bag has none, room is made for all of a topic's ``count`` messages, so that
    late joiners get what was latched and slow listeners what they have not acknowledged yet.
    """
    offers = list(dict.fromkeys(recorded)) or [Qos()]
    strongest = replace(
        offers[0],
        reliability=_stronger("reliable", [offer.reliability for offer in offers]),
        durability=_stronger("transient_local", [offer.durability for offer in offers]),
        deadline_ns=min(offer.deadline_ns for offer in offers),
        lifespan_ns=max(offer.lifespan_ns for offer in offers),
        depth=max(offer.depth for offer in offers),
    )
    return strongest if strongest.depth > 0 else replace(strongest, depth=min(max(count, 1), DEPTH_MAX))


def _stronger(policy: str, offered: list[str]) -> str:
    return policy if policy in offered else offered[0]
