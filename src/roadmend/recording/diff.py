"""Two bags held against each other, tick by tick."""

import itertools
import math
import re
from collections.abc import Callable, Iterator
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

from roadmend.core.errors import InputError
from roadmend.recording.deviation import deviations
from roadmend.recording.layout import RECORD
from roadmend.recording.reader import BagReader, Record

# What depends on the machine and not on the drive: diagnostics, what viz_node draws when it has time, what ROS itself stamps
# by the wall clock, and the nodes' parameters, among them folders and the bag's name.
UNSTEADY = r"(^|/)(configuration|diagnostics|rosout|transition_event|tf|tf_static|plan|ego/distance|markers/[^/]+)$"
_ODOMETRY = "nav_msgs/msg/Odometry"
_TICK_LIMIT = 1 << 27  # [bytes] of one tick's messages
_SECOND = 1e9  # [ns]

Tick = dict[str, list[Record]]  # one tick's messages by topic


@dataclass(slots=True)
class TopicDiff:
    """How one topic differs; times of the simulation [s]."""

    name: str
    first_messages: int = 0  # in the first bag
    second_messages: int = 0
    differing: int = 0  # messages that are not equal, or are in one bag only
    first_difference: float | None = None
    largest: dict[str, float] = field(default_factory=dict)  # by field; infinite where it is not a matter of numbers


@dataclass(slots=True)
class TrajectoryDistance:
    """How far apart the vehicle was at equal times [m]."""

    topic: str
    ticks: int = 0
    mean: float = 0.0
    largest: float = 0.0
    largest_at: float = 0.0  # [s]
    last: float = 0.0


@dataclass(slots=True)
class BagDiff:
    """How two bags differ."""

    first: str
    second: str
    ticks: int = 0  # times at which either bag has a message
    differing_ticks: int = 0
    first_difference: float | None = None  # [s]
    topics: dict[str, TopicDiff] = field(default_factory=dict)
    types: dict[str, tuple[str, str]] = field(default_factory=dict)  # topics whose types differ
    trajectories: dict[str, TrajectoryDistance] = field(default_factory=dict)
    metadata: dict[str, tuple[str, str]] = field(default_factory=dict)  # what the recorder noted, where it differs

    @property
    def is_equal(self) -> bool:
        """Whether all compared messages are equal; metadata may differ."""
        return not self.differing_ticks and not self.types

    def as_dict(self) -> dict[str, Any]:
        """Plain values, for JSON."""
        values = asdict(self) | {"equal": self.is_equal}
        for topic in values["topics"].values():
            topic["largest"] = {name: one if math.isfinite(one) else None for name, one in topic["largest"].items()}
        return values


def bag_diff(
    first: Path,
    second: Path,
    include: str = "",
    exclude: str = UNSTEADY,
    advance: Callable[[int], None] = lambda _count: None,
) -> BagDiff:
    """Compare the decoded messages of two bags: equal ones may have different padding bytes.

    Messages of one topic and one time are compared in the order in which they were written. Where one bag has more of
    them, equal ones in a row count once: the simulator repeats its first tick until it is answered.

    Args:
        first: a bag.
        second: another.
        include: regular expression found in each topic to compare.
        exclude: regular expression found in each topic not to compare; empty for none.
        advance: called with the number of messages that were passed.

    Raises:
        InputError: a bag or an expression is unusable.
    """
    readers = BagReader(first), BagReader(second)
    wanted = _choose({*readers[0].topics, *readers[1].topics}, include, exclude)
    diff = BagDiff(str(first), str(second))
    for name in wanted:
        types = tuple(reader.topics[name].type_name for reader in readers if name in reader.topics)
        if len(set(types)) == 2:
            diff.types[name] = types[0], types[-1]
        diff.topics[name] = TopicDiff(name)
    noted = [reader.metadata.get(RECORD, {}) for reader in readers]
    for key in sorted({*noted[0], *noted[1]}):
        if noted[0].get(key) != noted[1].get(key):
            diff.metadata[key] = noted[0].get(key, ""), noted[1].get(key, "")
    comparison = _Comparison(diff, *readers)
    for time_ns, one, other in _aligned(*(_ticks(reader, set(wanted) - set(diff.types)) for reader in readers)):
        comparison.tick(time_ns, one, other)
        advance(sum(map(len, (*one.values(), *other.values()))))
    return diff


class _Comparison:
    """Compares tick after tick and puts what it finds into a diff."""

    def __init__(self, diff: BagDiff, first: BagReader, second: BagReader) -> None:
        self._diff = diff
        self._readers = first, second
        self._placed: dict[str, float] = {}  # by topic of odometry, the time [s] of the last one that was counted

    def tick(self, time_ns: int, first: Tick, second: Tick) -> None:
        time_s = time_ns / _SECOND
        differs = False
        for name in {**first, **second}:
            topic = self._diff.topics[name]
            ones, others = first.get(name, []), second.get(name, [])
            if len(ones) != len(others):
                ones, others = self._distinct(0, ones), self._distinct(1, others)
            for one, other in itertools.zip_longest(ones, others):
                topic.first_messages += one is not None
                topic.second_messages += other is not None
                if not self._is_equal(topic, one, other, time_s):
                    differs = True
                    topic.differing += 1
                    topic.first_difference = time_s if topic.first_difference is None else topic.first_difference
        self._diff.ticks += 1
        if differs:
            self._diff.differing_ticks += 1
            if self._diff.first_difference is None:
                self._diff.first_difference = time_s

    def _distinct(self, place: int, records: list[Record]) -> list[Record]:
        """The messages without those that repeat the one before."""
        reader, kept = self._readers[place], records[:1]
        for record in records[1:]:
            last = kept[-1]
            if record.data != last.data and deviations(reader.decode(last), reader.decode(record)):
                kept.append(record)
        return kept

    def _is_equal(self, topic: TopicDiff, one: Record | None, other: Record | None, time_s: float) -> bool:
        if one is None or other is None:
            return False
        distance, found = 0.0, {}
        if one.data != other.data:
            values = self._readers[0].decode(one), self._readers[1].decode(other)
            found = deviations(*values)
            if one.type_name == _ODOMETRY:
                places = [value.pose.pose.position for value in values]
                distance = math.hypot(places[0].x - places[1].x, places[0].y - places[1].y)
        if one.type_name == _ODOMETRY:
            self._place(topic.name, distance, time_s)
        for name, size in found.items():
            topic.largest[name] = max(size, topic.largest.get(name, 0.0))
        return not found

    def _place(self, name: str, distance: float, time_s: float) -> None:
        trajectory = self._diff.trajectories.setdefault(name, TrajectoryDistance(name))
        if self._placed.get(name) != time_s:  # the final tick's odometry is sent twice
            self._placed[name] = time_s
            trajectory.ticks += 1
            trajectory.mean += (distance - trajectory.mean) / trajectory.ticks
        trajectory.last = distance
        if distance > trajectory.largest:
            trajectory.largest, trajectory.largest_at = distance, time_s


def _choose(topics: set[str], include: str, exclude: str) -> list[str]:
    try:
        wanted, unwanted = re.compile(include), re.compile(exclude or "$^")
    except re.error as error:
        text = error.pattern if isinstance(error.pattern, str) else ""
        raise InputError(text, f"is not a regular expression ({error})", "correct it") from error
    chosen = [name for name in sorted(topics) if wanted.search(name) and not unwanted.search(name)]
    if not chosen:
        raise InputError("the bags", "hold no topic to compare", "choose others with --topics and --exclude")
    return chosen


def _ticks(reader: BagReader, topics: set[str]) -> Iterator[tuple[int, Tick]]:
    """The messages of each time, in the order of the times."""
    for time_ns, records in itertools.groupby(reader.records(topics), key=lambda record: record.time_ns):
        tick: Tick = {}
        size = 0
        for record in records:
            tick.setdefault(record.topic, []).append(record)
            size += len(record.data)
            if size > _TICK_LIMIT:
                what = f"more than {_TICK_LIMIT >> 20} MB have the time {time_ns / _SECOND:g} s"
                raise InputError(str(reader.path), what, "compare fewer topics")
        yield time_ns, tick


def _aligned(first: Iterator[tuple[int, Tick]], second: Iterator[tuple[int, Tick]]) -> Iterator[tuple[int, Tick, Tick]]:
    """Ticks of both, by time; an empty one where a bag has none."""
    one, other = next(first, None), next(second, None)
    while one is not None or other is not None:
        if other is None or (one is not None and one[0] < other[0]):
            assert one is not None
            yield one[0], one[1], {}
            one = next(first, None)
        elif one is None or other[0] < one[0]:
            yield other[0], {}, other[1]
            other = next(second, None)
        else:
            yield one[0], one[1], other[1]
            one, other = next(first, None), next(second, None)
