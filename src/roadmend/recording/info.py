"""What a bag holds, at a glance: topics, rates, gaps, outcome, interventions, and whether it is complete."""

import contextlib
from collections import Counter
from collections.abc import Callable
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from roadmend.core.errors import InputError
from roadmend.core.outcome import EventKind
from roadmend.core.spell_account import SpellAccount
from roadmend.recording.codec import Codec
from roadmend.recording.enclosure import Attachment
from roadmend.recording.layout import FILE_RECORD, METADATA_FILE, RECORD, REPEATED, promised_counts
from roadmend.recording.recovery import files_left
from roadmend.recording.repeat_watch import RepeatWatch
from roadmend.recording.rhythm import Rhythm
from roadmend.recording.scan import Item, NamedTexts, Scan, ScannedMessage, ScannedTopic
from roadmend.recording.spell_scan import InterventionSummary, SpellScan
from roadmend.recording.topics import EVENTS, REPAIR_STATE, TYPES

_HIDDEN = {FILE_RECORD, REPEATED}  # metadata that repeat what the rest of the information says
SECOND = 1e9  # [ns]


@dataclass(frozen=True, slots=True)
class TopicInfo:
    """One topic of a bag; times of the simulation [s]."""

    name: str
    type: str
    count: int
    rate: float | None  # [1/s]
    gaps: int | None  # silences longer than 2.5 usual intervals; None where messages come as it happens
    longest_gap: float | None  # [s]; None without gaps
    longest_gap_at: float | None  # [s]
    out_of_order: int  # messages older than the one before
    latched: bool


@dataclass(frozen=True, slots=True)
class BagInfo:
    """A bag at a glance; times of the simulation [s]."""

    bag: str
    complete: bool
    missing: list[str]  # lines for people; empty where the bag is complete
    files: list[str]
    bytes: int  # on disk
    messages: int
    start: float | None
    end: float | None
    outcome: str  # as the events or else the recorder tell; UNFINISHED without a final event, empty without any
    outcome_text: str
    interventions: InterventionSummary | None  # of the graph itself; None where no repair state was recorded
    spells: tuple[SpellAccount, ...]  # of the graph itself, not of a shadow in the bag
    topics: list[TopicInfo]
    metadata: dict[str, dict[str, str]]
    attachments: dict[str, int]  # name and size [bytes]

    def as_dict(self) -> dict[str, Any]:
        """Plain values, for JSON."""
        values = asdict(self) | {"spells": [account.as_dict() for account in self.spells]}
        if values["interventions"] is not None:
            del values["interventions"]["_last"]
        return values


def bag_info(path: Path, advance: Callable[[int], None] = lambda _count: None) -> BagInfo:
    """Read through a bag, whole or not.

    Args:
        path: a bag's folder, its metadata.yaml, or an .mcap file by itself.
        advance: called with the number of bytes that were passed.

    Raises:
        InputError: there is no such bag, or nothing of it can be read.
    """
    files, missing = files_left(path)
    reading = _Reading()
    for file in files:
        scan = Scan(file, advance)
        reading.begin(file)
        try:
            for item in scan:
                reading.take(item)
        except InputError as error:
            if len(files) == 1:
                raise
            missing.append(f"{file.name}: {error.what}")
            continue
        missing += [line if len(files) == 1 else f"{file.name}: {line}" for line in scan.report.missing]
    if not missing:  # else more would be told of the same loss
        for name, count in promised_counts(path).items():
            if (found := reading.found[name]) < count:
                missing.append(f"{name}: {found:,} of the {count:,} messages that {METADATA_FILE} promises")
    return reading.info(path, files, missing)


class _Reading:
    """What has been seen of a bag so far."""

    def __init__(self) -> None:
        self.found = Counter[str]()  # messages of each topic, with those that files repeat
        self._rhythms: dict[str, Rhythm] = {}
        self._topics: dict[str, ScannedTopic] = {}
        self._metadata: dict[str, dict[str, str]] = {}
        self._attachments: dict[str, int] = {}
        self._repeats = RepeatWatch()  # what files repeat counts once, and if the first one is lost, where it is left
        self._outcome: tuple[str, str] | None = None  # with its text, as the events tell it
        self._codec = Codec()
        self._spells = SpellScan(self._codec)

    def begin(self, file: Path) -> None:
        """Turn to the next file."""
        self._repeats.begin(file)

    def take(self, item: Item) -> None:
        if isinstance(item, NamedTexts):
            self._metadata.setdefault(item.name, {}).update(item.values)
            self._repeats.hear(item)
            return
        if isinstance(item, Attachment):
            self._attachments[item.name] = len(item.data)
            return
        self.found[item.topic.name] += 1
        if not self._repeats.is_repeat(item):
            self._rhythms.setdefault(item.topic.name, Rhythm()).add(item.time_ns)
            self._topics[item.topic.name] = item.topic
            with contextlib.suppress(ValueError, AttributeError):  # it, or its definition, was altered on the disk
                self._look_into(item)

    def _look_into(self, item: ScannedMessage) -> None:
        if item.topic.definition.type_name not in {TYPES[REPAIR_STATE], TYPES[EVENTS]}:
            self._spells.take(item)
            return
        value = self._codec.decode(item.topic.definition, item.data)
        self._spells.take(item, value)
        if item.topic.definition.type_name == TYPES[REPAIR_STATE]:
            return
        if value.kind in set(EventKind) and EventKind(value.kind).is_final:
            self._outcome = EventKind(value.kind).name, value.text
        elif self._outcome is None:
            self._outcome = "UNFINISHED", "no final event was recorded"

    def info(self, path: Path, files: list[Path], missing: list[str]) -> BagInfo:
        noted = self._metadata.get(RECORD, {})
        outcome, text = self._outcome or (noted.get("outcome", ""), noted.get("outcome_text", ""))
        return BagInfo(
            bag=str(path),
            complete=not missing,
            missing=missing,
            files=[file.name for file in files],
            bytes=sum(file.stat().st_size for file in files),
            messages=sum(rhythm.count for rhythm in self._rhythms.values()),
            start=min((rhythm.first_ns / SECOND for rhythm in self._rhythms.values()), default=None),
            end=max((rhythm.end_ns / SECOND for rhythm in self._rhythms.values()), default=None),
            outcome=outcome,
            outcome_text=text,
            interventions=self._spells.summary(),
            spells=self._spells.accounts(),
            topics=[self._topic(name) for name in sorted(self._rhythms)],
            metadata={name: values for name, values in self._metadata.items() if name not in _HIDDEN},
            attachments=self._attachments,
        )

    def _topic(self, name: str) -> TopicInfo:
        topic, rhythm = self._topics[name], self._rhythms[name]
        gaps = rhythm.gaps
        return TopicInfo(
            name,
            topic.definition.type_name,
            rhythm.count,
            rhythm.rate,
            gaps,
            rhythm.longest_ns / SECOND if gaps else None,
            rhythm.longest_at_ns / SECOND if gaps else None,
            rhythm.back,
            bool(topic.offers) and all(offer.is_latched for offer in topic.offers),
        )
