"""Records the running graph into a bag: every topic, as the serialized bytes that came over the wire."""

import contextlib
import hashlib
import json
import re
import sys
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from pydantic import Field
from rclpy.clock import Clock, ClockType
from rclpy.event_handler import SubscriptionEventCallbacks
from rclpy.node import Node
from rclpy.qos import QoSProfile
from rclpy.time import Time
from roadmend_msgs.msg import ScenarioEvent

from roadmend.core.claim import check_name
from roadmend.core.errors import InputError
from roadmend.core.outcome import Event
from roadmend.core.parameters import Parameters
from roadmend.core.whole_file import write_text
from roadmend.nodes import qos
from roadmend.nodes.announcement import UNKNOWN
from roadmend.nodes.configuration import Announcements, ConfigurationAnnouncer
from roadmend.nodes.discovery import LookUp, request_for
from roadmend.nodes.parameters import declare_parameters
from roadmend.nodes.qos import offer_from
from roadmend.nodes.recorder_drain import drain
from roadmend.nodes.recorder_progress import ProgressReport
from roadmend.nodes.spinning import run_node
from roadmend.recording import topics
from roadmend.recording.definitions import Definition
from roadmend.recording.enclosure import Attachment, metadata_from_file
from roadmend.recording.errors import RecordingError
from roadmend.recording.layout import RECORD
from roadmend.recording.messages import EVENT, event_of
from roadmend.recording.timekeeper import Timekeeper
from roadmend.recording.writer import BagOptions, BagWriter, Compression

DISCOVERY_PERIOD_S = 0.1  # [s] between two looks at the graph
DIAGNOSTICS_PERIOD_S = 1.0  # [s] of wall time
_QUEUED_EACH = 3  # of a topic in the executor's queue, besides its messages: what DDS says of it, and timers

Callback = Callable[[bytes], None]


class RecorderParameters(Parameters):
    """Parameters of the node, read once at start."""

    output: str = Field("bags", description="folder in which the bag's folder is made")
    name: str = Field("recording", description="name of the bag and of its folder")
    claimed: bool = Field(
        default=False, description="the bag's folder is there, empty, made for this bag by who starts the node"
    )
    include: str = Field("", description="regular expression found in each topic to record")
    exclude: str = Field(
        "^/parameter_events$", description="regular expression found in each topic not to record; empty for none"
    )
    time_source: Literal["simulation", "system"] = Field(
        "simulation", description="simulation (/clock rules) or system (wall time at which a message came)"
    )
    compression: str = Field("zstd", description="of the chunks: zstd, lz4 or none")
    chunk_size: int = Field(1 << 20, ge=1 << 12, le=1 << 26, description="size at which a chunk is written [bytes]")
    max_bagfile_size: int = Field(
        0, ge=0, le=1 << 50, description="size on disk at which the next file begins [bytes]; 0 for one file"
    )
    max_bagfile_duration: float = Field(
        0.0, ge=0.0, le=1e9, description="message time after which the next file begins [s]; 0 for one file"
    )
    flush_interval: float = Field(
        0.25, ge=0.01, le=10.0, description="wall time after which a chunk is written even if small [s]"
    )
    drain_limit: float = Field(
        15.0,
        ge=0.2,
        le=60.0,
        description="wall time after which the bag is closed even if messages sent before the end still come [s]",
    )
    metadata: str = Field("", description="JSON file with an object that goes into the bag's metadata")
    attachments: tuple[str, ...] = Field((), description="files that go into the bag")
    summary: str = Field("", description="file for what was recorded and lost, written at the end; none if empty")


@dataclass(slots=True)
class _Recorded:
    """A topic that is being recorded."""

    definition: Definition
    message_type: Any
    callback: Callback
    offers: Sequence[QoSProfile] = ()  # of its publishers, when there last were any
    request: QoSProfile | None = None
    subscription: Any = None
    lost: int = 0  # messages that DDS says did not arrive
    lost_before: int = 0  # of these, on earlier subscriptions


class RecorderNode(Node):
    """Subscribes to each topic as soon as it has a publisher and writes every message that comes.

    Told to stop, it first takes in what is still on its way, then completes the bag. Where the bag cannot be written
    any further, it stays: it counts what is dropped and reports the error, and the graph drives on.
    """

    def __init__(self) -> None:
        super().__init__("recorder_node")
        settings = declare_parameters(self, RecorderParameters, choices={"compression": list(Compression)})
        self._configuration = ConfigurationAnnouncer(self, "recorder")
        self._include = _pattern("include", settings.include)
        self._exclude = _pattern("exclude", settings.exclude or "$^")
        self._is_wall = settings.time_source == "system"
        self._timekeeper = Timekeeper(simulated=not self._is_wall)
        self._metadata = metadata_from_file(Path(settings.metadata)) if settings.metadata else {}
        attachments = [Attachment.from_file(Path(path)) for path in settings.attachments if path]
        self._attached = {hashlib.sha256(each.data).hexdigest(): each.name for each in attachments}
        options = BagOptions(
            Compression(settings.compression),
            settings.chunk_size,
            settings.flush_interval,
            settings.max_bagfile_size,
            settings.max_bagfile_duration,
        )
        check_name("parameter name", settings.name)
        self._writer = BagWriter(Path(settings.output, settings.name), options, claimed=settings.claimed)
        self._writer.add_metadata(RECORD, self._metadata)
        for attachment in attachments:
            self._writer.add_attachment(attachment.name, attachment.media_type, attachment.data)
        self._writer.flush()
        self._error: RecordingError | None = None  # why nothing more is written
        self._dropped = 0  # messages that came since
        self._drain_limit, self._summary = settings.drain_limit, settings.summary
        self._is_drained = True  # whether all that was sent before the end came
        self._recorded: dict[str, _Recorded] = {}
        self._look_up = LookUp(lambda error: self.get_logger().error(f"not recorded: {error}"))
        self._outcome: Event | None = None
        self._events_topic = self.resolve_topic_name(topics.EVENTS)
        self._to_diagnostics = self.create_publisher(DiagnosticArray, topics.DIAGNOSTICS, qos.DIAGNOSTIC)
        wall = Clock(clock_type=ClockType.STEADY_TIME)
        self.create_timer(DISCOVERY_PERIOD_S, self._discover, clock=wall)
        self.create_timer(settings.flush_interval, self._flush, clock=wall)
        self._report_timer = self.create_timer(DIAGNOSTICS_PERIOD_S, self._report, clock=wall)
        self._configuration.announce()
        self._progress = ProgressReport(self)
        self._known: dict[str, str] = {}  # what the bag says of who runs
        self._is_told = False  # whether the bag has all that was announced
        self._announcements = Announcements(self, self._on_heard)
        self._discover()

    def _on_heard(self) -> None:
        self._is_told = False

    def _note_who_runs(self, *, is_last: bool = False) -> None:
        """What was announced goes into the bag as soon as somebody drives, so that a recorder that is killed leaves it."""
        is_driving = self._timekeeper.now_ns > 0 or (self._is_wall and self._writer.count > 0)
        self._announcements.look(is_driving=is_driving)
        if self._is_told or not (is_driving or is_last):
            return
        self._is_told = True
        known = self._announcements.account | self._scenario()
        known = {name: value for name, value in known.items() if value != UNKNOWN}  # it may be no run that is recorded
        gone = dict.fromkeys(self._known.keys() - known.keys(), "")  # records of a bag add up
        self._known = known
        self._metadata |= gone | known
        self._writer.add_metadata(RECORD, self._metadata)

    def _scenario(self) -> dict[str, str]:
        """The attachment with the scenario that the simulator runs; it is attached now if it was not."""
        sims = [one.values for one in self._announcements.by_node.values() if one.is_ours and one.role == "sim"]
        digest = sims[0].get("scenario_sha256", "") if len(sims) == 1 else ""
        if not digest:
            return {}
        if digest not in self._attached:
            self._attached[digest] = ""
            with contextlib.suppress(InputError):  # it may lie on another machine
                file = Attachment.from_file(Path(sims[0].get("scenario_file", "")))
                if hashlib.sha256(file.data).hexdigest() == digest:
                    self._writer.add_attachment(file.name, file.media_type, file.data)
                    self._attached[digest] = file.name
        return {"scenario_file": self._attached[digest], "scenario_sha256": digest}

    def close(self) -> None:
        """Take in what is still on its way, then complete the bag. Does nothing the second time.

        Raises:
            RecordingError: the bag could not be written to its end.
        """
        if self._error is not None:
            self._summarise()
            raise self._error
        if not self._writer.is_open:
            return
        try:
            self._drain()
            if self._error is None:
                self._note_who_runs(is_last=True)
            if self._error is not None:
                raise self._error
            self._writer.add_metadata(RECORD, self._metadata | self._account())
        finally:
            self._writer.close()
            self._summarise()
        self.get_logger().info(f"{self._writer.folder}: {self._writer.count} messages of {len(self._recorded)} topics")

    def _summarise(self) -> None:
        if self._summary:
            told = {"messages": self._writer.count, "lost_messages": self._lost, "dropped": self._dropped}
            with contextlib.suppress(InputError):  # a full disk: why the bag is not complete is told all the same
                write_text(Path(self._summary), json.dumps(told))

    def _discover(self) -> None:
        if self._timekeeper.now_ns or topics.CLOCK in self._recorded:
            self._progress.tell(self._timekeeper.now_ns)
        for name, types in self.get_topic_names_and_types():
            recorded = self._recorded.get(name)
            if recorded is not None:
                self._subscribe(name, recorded)
            elif self._look_up.is_due(name, types) and self._is_wanted(name) and self.count_publishers(name):
                self._begin(name, types)

    def _is_wanted(self, name: str) -> bool:
        return not ("/_" in name or self._exclude.search(name) or not self._include.search(name))

    def _begin(self, name: str, types: list[str]) -> None:
        found = self._look_up.find(name, types)
        if found is None:
            return
        definition, message_type = found
        callback = self._callback(name, self._timekeeper.rule_for(definition))
        if name == self._events_topic and message_type is ScenarioEvent:
            callback = self._watching(callback)
        elif name == topics.CLOCK:
            callback = self._telling(callback)
        recorded = _Recorded(definition, message_type, callback)
        self._subscribe(name, recorded)
        self._recorded[name] = recorded

    def _callback(self, name: str, time_of: Callable[[bytes], int]) -> Callback:
        """The hot path: what happens with each message."""
        write = self._writer.write

        def store(data: bytes) -> None:
            try:
                try:
                    time_ns = time_of(data)
                except ValueError:  # too few bytes to hold a stamp: that they came belongs into the bag all the same
                    time_ns = self._timekeeper.unstamped()
                write(name, time_ns, data)
            except RecordingError as error:
                self._fail(error)
                self._dropped += 1

        return store

    def _flush(self) -> None:
        try:
            if self._error is None:
                self._note_who_runs()
                self._writer.flush_if_due()
        except RecordingError as error:
            self._fail(error)

    def _fail(self, error: RecordingError) -> None:
        if self._error is None:
            self._error = error
            self.get_logger().error(f"{error}; nothing more is recorded")
            self._report()

    def _watching(self, store: Callback) -> Callback:
        def store_event(data: bytes) -> None:
            store(data)
            with contextlib.suppress(ValueError):  # bytes that are no event end nothing
                event = event_of(EVENT.decode(data))
                if event is not None and event.kind.is_final:
                    self._outcome = event

        return store_event

    def _telling(self, store: Callback) -> Callback:
        def store_clock(data: bytes) -> None:
            store(data)
            self._progress.see(self._timekeeper.now_ns)

        return store_clock

    def _subscribe(self, name: str, recorded: _Recorded) -> None:
        """Subscribe so that all publishers match; anew where one that came, or took another's place, offers less.

        Never for more than before: what is still in the queue of a subscription goes with it.
        """
        offers = [info.qos_profile for info in self.get_publishers_info_by_topic(name)]
        if recorded.request is not None and (not offers or offers == recorded.offers):
            return
        recorded.offers = offers
        self._writer.add_topic(name, recorded.definition.type_name, map(offer_from, offers), recorded.definition)
        request = request_for(offers if recorded.request is None else [recorded.request, *offers])
        if recorded.request == request:
            return
        if recorded.subscription is not None:
            self.destroy_subscription(recorded.subscription)
            recorded.lost_before = recorded.lost
        recorded.request = request

        def on_lost(event: Any) -> None:
            # The event's own difference to the one before is zero for most events in this build.
            recorded.lost = recorded.lost_before + event.total_count

        recorded.subscription = self.create_subscription(
            recorded.message_type,
            name,
            recorded.callback,
            request,
            raw=True,
            event_callbacks=SubscriptionEventCallbacks(message_lost=on_lost),
        )

    def _drain(self) -> None:
        """Take in what was sent before the recorder was told to stop."""
        self._report_timer.cancel()
        if self.executor is None:
            return
        before = self._writer.count
        there = [(one.subscription, one.callback) for one in self._recorded.values()]
        self._is_drained = drain(there, self._has_others, self._drain_limit)
        if not self._is_drained:
            self.get_logger().warning(
                f"{self._writer.folder}: closed after {self._drain_limit:g} s while messages sent before still came; "
                "raise the parameter drain_limit"
            )
        # What DDS says of lost messages stands in the executor's queue behind the messages that were taken without it.
        for _ in range(self._writer.count - before + _QUEUED_EACH * (len(self._recorded) + 1)):
            self.executor.spin_once(timeout_sec=0.0)

    def _has_others(self) -> bool:
        """Whether any node besides this one can still send."""
        me = (self.get_name(), self.get_namespace())
        infos = (info for name in self._recorded for info in self.get_publishers_info_by_topic(name))
        return any((info.node_name, info.node_namespace) != me for info in infos)

    @property
    def _lost(self) -> int:
        return sum(recorded.lost for recorded in self._recorded.values())

    def _account(self) -> dict[str, str]:
        """What the bag's metadata say about the recording and its end."""
        account = {"messages": f"{self._writer.count}", "lost_messages": f"{self._lost}"}
        if not self._is_drained:
            account["incomplete"] = "closed while messages sent before still came"
        if self._outcome is None:
            return account | {"outcome": "UNFINISHED", "outcome_text": "no final event was recorded"}
        return account | {
            "outcome": self._outcome.kind.name,
            "outcome_text": self._outcome.text,
            "outcome_time": f"{self._outcome.time:g}",
        }

    def _report(self) -> None:
        status = DiagnosticStatus(name=f"{self.get_name()}: bag", hardware_id="roadmend", level=DiagnosticStatus.OK)
        status.message = f"recording {len(self._recorded)} topics"
        if self._lost or self._look_up.refused:
            status.level = DiagnosticStatus.WARN
            status.message = f"{self._lost} messages lost, {len(self._look_up.refused)} topics not recorded"
        if self._error is not None:
            status.level = DiagnosticStatus.ERROR
            status.message = f"{self._error}; nothing more is recorded"
        figures = {
            "bag": str(self._writer.folder),
            "topics": str(len(self._recorded)),
            "messages": str(self._writer.count),
            "bytes": str(self._writer.bytes),
            "messages lost": str(self._lost),
            "messages dropped": str(self._dropped),
            "stamps from the wall clock": str(self._timekeeper.wall_stamps),
        }
        figures |= {f"lost on {name}": str(one.lost) for name, one in self._recorded.items() if one.lost}
        figures |= {f"not recorded: {name}": why for name, why in self._look_up.refused.items()}
        status.values = [KeyValue(key=key, value=value) for key, value in figures.items()]
        message = DiagnosticArray(status=[status])
        message.header.stamp = Time(nanoseconds=self._timekeeper.now_ns).to_msg()
        self._to_diagnostics.publish(message)


def _pattern(name: str, text: str) -> re.Pattern[str]:
    try:
        return re.compile(text)
    except re.error as error:
        raise InputError(name, f"{text!r} is not a regular expression ({error})", "correct it") from error


def main(args: Sequence[str] | None = None) -> int:
    """Run the node until it is told to stop."""
    return run_node(RecorderNode, args)


if __name__ == "__main__":
    sys.exit(main())
