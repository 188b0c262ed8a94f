"""replay_node: publishes what a bag holds, as it was recorded, on the wall clock or tick by tick with live nodes."""

import sys
import time
from collections.abc import Sequence
from functools import partial
from pathlib import Path

from rclpy.clock import Clock, ClockType
from rclpy.node import Node
from rclpy.parameter import Parameter
from rclpy.time import Time
from rosgraph_msgs.msg import Clock as ClockMessage
from std_srvs.srv import Trigger

from roadmend.core.errors import InputError
from roadmend.nodes import qos
from roadmend.nodes.configuration import ConfigurationAnnouncer
from roadmend.nodes.diagnostics import DiagnosticsReporter, Health, Level
from roadmend.nodes.discovery import look_up
from roadmend.nodes.parameters import declare
from roadmend.nodes.players import Players
from roadmend.nodes.recorder_progress import ProgressWatch
from roadmend.nodes.spinning import run_node
from roadmend.recording import topics
from roadmend.recording.messages import stamp_of_bytes
from roadmend.recording.reader import BagReader, Record
from roadmend.recording.replay import (
    Playhead,
    ReplaySource,
    ReplayTick,
    absolute,
    find_topic,
    select_topics,
)

BEAT_S = 0.002  # [s] of wall time between two looks at what is due
BUSY_S = 0.05  # [s] of publishing after which services get their turn
SETTLE_S = 0.5  # [s] without a new subscription after which nobody else is expected to join
TELL_S = 2.0  # [s] of waiting for those that must join after which it is said
ASK_S = 0.1  # [s] between two looks for those that must join
REPEAT_S = 0.25  # [s] after which an unanswered tick is published again: a node may have joined only now
FIRST_ANSWER_S = 60.0  # [s] of wall time for the first answer: a node may still be loading
_NANOSECONDS = 1_000_000_000
_HEADER = "std_msgs/Header"


class ReplayNode(Node):
    """Plays one bag from its beginning, or from an offset, to its end."""

    linger = 2.0  # [s] for which the end waits for slow subscribers

    def __init__(self) -> None:
        super().__init__("replay_node")
        self.finished = False
        self.exit_code = 0
        path = declare(self, "bag", "", "bag to play: its folder or an .mcap file")
        rate = declare(
            self, "rate", 1.0, "realtime: simulated seconds per wall second", low=1e-3, high=1e3, read_only=False
        )
        start = declare(self, "start_offset", 0.0, "[s] after the bag's first message at which to begin", low=0.0)
        self._loop = declare(self, "loop", False, "begin again at the end")
        wanted = declare(self, "topics", [""], "topics to play, and the clock; all if none is named")
        exclude = declare(self, "exclude", [""], "topics not to play")
        clock = declare(
            self,
            "clock",
            "realtime",
            "realtime: on the wall clock; lockstep: each tick waits for the answers to it",
            choices=("realtime", "lockstep"),
        )
        answers = declare(
            self,
            "answers",
            [topics.REPAIR_COMMAND, topics.REPAIR_STATE],
            "lockstep: topics that live nodes answer on; they are not played",
        )
        self._answer_timeout = declare(
            self,
            "answer_timeout",
            10.0,
            "[s] lockstep: wall time without an answer after which it is given up",
            low=0.05,
            high=3600.0,
        )
        self._wait_for: list[str] = list(
            filter(None, declare(self, "wait_for", [""], "nodes that must listen before it begins"))
        )
        self._wait_for_listeners = declare(
            self, "wait_for_listeners", False, "begin only when every topic has a listener, a recorder for example"
        )
        paused = declare(self, "start_paused", False, "wait for resume or step at the beginning")
        self._configuration = ConfigurationAnnouncer(self, "replay")
        reader = BagReader(Path(path))
        self._lockstep = clock == "lockstep"
        self._answers = [find_topic(reader, name) for name in answers if name] if self._lockstep else []
        chosen = select_topics(reader, list(filter(None, wanted)), [*filter(None, exclude), *self._answers])
        self._players = Players(self, reader, chosen)
        self._source = ReplaySource(reader, [*self._players.publishers, *self._answers], start)
        self._makes_clock = topics.CLOCK not in reader.topics and topics.CLOCK not in map(absolute, exclude)
        if self._makes_clock:
            self._clock_publisher = self.create_publisher(ClockMessage, topics.CLOCK, qos.STREAM)
        self._listen(reader)
        self._playhead = Playhead(rate, paused=paused)
        self._ticks = self._source.ticks()
        self._next: ReplayTick | None = None
        self._begun = False
        self._made, self._told_missing = time.monotonic(), list[str]()
        self._settled: tuple[int, float] = (-1, 0.0)  # subscriptions, and the wall time [s] at which they were counted
        self._awaited: set[tuple[str, int]] = set()  # topic and stamp [ns] of answers that have not come yet
        self._published = (0.0, 0.0)  # wall times [s] at which the tick that is not answered was published: first, last
        self._answered_once = False
        self._current: ReplayTick | None = None
        self._recorder = ProgressWatch(self, self._answer_timeout, self._go_on)
        for name, callback in (
            ("pause", self._on_pause),
            ("resume", self._on_resume),
            ("toggle_paused", self._on_toggle_paused),
            ("step", self._on_step),
        ):
            self.create_service(Trigger, f"~/{name}", callback)
        self.add_post_set_parameters_callback(self._on_parameters)
        # Steady time: the replay itself is what moves simulation time.
        self._timer = self.create_timer(BEAT_S, self._beat, clock=Clock(clock_type=ClockType.STEADY_TIME))
        self._diagnostics = DiagnosticsReporter(self, self._health)
        self._configuration.announce()

    # -- what is played -----------------------------------------------------------------------------------------------

    def _listen(self, reader: BagReader) -> None:
        for name in self._answers:
            topic = reader.topics[name]
            definition, kind = look_up(name, [topic.type_name])
            if definition.first_field != _HEADER:
                raise InputError(f"answers {name}", f"{topic.type_name} has no header to tell its tick", "name another")
            self.create_subscription(kind, name.lstrip("/"), partial(self._on_answer, name), qos.STREAM, raw=True)

    # -- time ---------------------------------------------------------------------------------------------------------

    def _beat(self) -> None:
        now = time.monotonic()
        if not self._begun and not self._begin(now):
            return
        if self._awaited:
            self._repeat(now)
        elif not self._playhead.paused:
            self._play(now)

    def _begin(self, now: float) -> bool:
        """Begin once whoever is expected has joined and nobody else is joining any more."""
        count = self._players.subscriptions()
        if count != self._settled[0]:
            self._settled = (count, now)
        if now - self._settled[1] < SETTLE_S:
            return False
        missing = self._missing()
        if missing:
            if missing != self._told_missing and now - self._made > TELL_S:
                self.get_logger().info(f"waiting for {', '.join(missing)}")
                self._told_missing = missing
            self._settled = (count, now - SETTLE_S + ASK_S)
            return False
        self._begun = True
        self._publish(self._source.latched())
        self._next = self._read()
        if self._next is None and not self.finished:
            self._fail("start: no message of the topics to play comes after it; begin earlier", 2)
        if self.finished:
            return False
        self._playhead.seek(self._source.start_ns, now)
        length = (self._source.end_ns - self._source.start_ns) / _NANOSECONDS
        self.get_logger().info(f"playing {len(self._players.publishers)} topics, {length:.2f} s")
        return True

    def _missing(self) -> list[str]:
        """Nodes that have not joined yet, and answers that nobody gives yet."""
        there = self._players.listeners()
        missing = [name for name in self._wait_for if name not in there]
        if self._wait_for_listeners:
            missing += [f"a listener on {name}" for name in self._players.unheard()]
        return missing + [f"a node that answers on {name}" for name in self._answers if not self._answered(name)]

    def _answered(self, name: str) -> bool:
        return bool(self.count_publishers(self.resolve_topic_name(name.lstrip("/"))))

    def _play(self, now: float) -> None:
        """Publish what is due."""
        while not self._awaited and not self.finished:
            if self._next is None:
                self._end(now)
                return
            if self._lockstep:
                if self._waits_for_recorder(now):
                    return
            elif self._next.time_ns > self._playhead.time_ns(time.monotonic()):
                return
            self._advance()
            if time.monotonic() - now > BUSY_S:
                return

    def _waits_for_recorder(self, now: float) -> bool:
        """Whether a recorder that is there has not come far enough for another tick."""
        return self._current is not None and self._recorder.holds(self._current.time_ns, now - self._published[1])

    def _advance(self) -> None:
        tick = self._current = self._next
        if tick is None:
            return
        answers = {_answer_of(record.topic, record.data) for record in tick.records if record.topic in self._answers}
        self._awaited = {answer for answer in answers if answer is not None}
        now = time.monotonic()
        self._published = (now, now)
        if self._makes_clock:
            self._clock_publisher.publish(ClockMessage(clock=Time(nanoseconds=tick.time_ns).to_msg()))
        self._publish(tick.records)
        self._next = self._read()

    def _publish(self, records: Sequence[Record]) -> None:
        """Publish messages; what is none ends the replay."""
        try:
            self._players.play(records)
        except InputError as error:
            self._fail(error, 2)

    def _read(self) -> ReplayTick | None:
        """The next tick; a bag that turns out to be broken ends the replay."""
        try:
            return next(self._ticks, None)
        except InputError as error:
            self._fail(error, 2)
            return None

    def _fail(self, error: object, code: int) -> None:
        self.get_logger().error(str(error))
        self.finished, self.exit_code = True, code

    def _end(self, now: float) -> None:
        if self._loop:
            self._publish(self._source.latched())
            self._ticks = self._source.ticks()
            self._next = self._read()
            self._playhead.seek(self._source.start_ns, now)
            return
        self.finished = True
        self.get_logger().info(f"{self._players.count} messages of {len(self._players.publishers)} topics played")

    # -- answers ------------------------------------------------------------------------------------------------------

    def _on_answer(self, name: str, data: bytes) -> None:
        answer = _answer_of(name, data)
        if answer is None or answer not in self._awaited:
            return  # a tick that was published twice is answered twice
        self._awaited.remove(answer)
        self._answered_once = True
        self._go_on()

    def _go_on(self) -> None:
        """Publish what is due at once: the beat would make every tick wait."""
        if self._begun and not self._awaited and not self._playhead.paused:
            self._play(time.monotonic())

    def _repeat(self, now: float) -> None:
        first, last = self._published
        if now - first > (self._answer_timeout if self._answered_once else FIRST_ANSWER_S):
            name, stamp = min(self._awaited)
            self._fail(f"no answer on {name} to the tick at {stamp / _NANOSECONDS:g} s in {now - first:.1f} s", 1)
        elif now - last > REPEAT_S and self._current is not None:
            self._published = (first, now)
            self._players.repeat(self._current.records)

    # -- services and parameters --------------------------------------------------------------------------------------

    def _on_pause(self, _request: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        return self._set_paused(response, paused=True)

    def _on_resume(self, _request: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        return self._set_paused(response, paused=False)

    def _on_toggle_paused(self, _request: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        return self._set_paused(response, paused=not self._playhead.paused)

    def _set_paused(self, response: Trigger.Response, *, paused: bool) -> Trigger.Response:
        (self._playhead.pause if paused else self._playhead.resume)(time.monotonic())
        response.success, response.message = True, "paused" if paused else "playing"
        return response

    def _on_step(self, _request: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        """Publish one tick while paused."""
        if not self._playhead.paused:
            response.message = "playing: pause first"
        elif not self._begun:
            response.message = f"not begun: waiting for {', '.join(self._missing()) or 'the graph to settle'}"
        elif self._awaited:
            response.message = f"waiting for an answer on {min(self._awaited)[0]}"
        else:
            now = time.monotonic()
            if self._next is None:
                self._end(now)
            if self._next is None:
                response.message = "the bag is at its end"
                return response
            self._playhead.seek(self._next.time_ns, now)
            response.success, response.message = True, f"{self._next.time_ns / _NANOSECONDS:.3f} s"
            self._advance()
        return response

    def _on_parameters(self, changed: list[Parameter]) -> None:
        for parameter in changed:
            if parameter.name == "rate":
                self._playhead.set_rate(parameter.value, time.monotonic())

    def _health(self) -> Health:
        here = self._current.time_ns if self._current is not None else self._source.start_ns
        values = {
            "time [s]": f"{here / _NANOSECONDS:.2f}",
            "messages": self._players.count,
            "topics": len(self._players.publishers),
            **{f"not played: {name}": why for name, why in self._players.skipped.items()},
        }
        if not self._begun:
            return Health(Level.WARN, f"waiting for {', '.join(self._missing()) or 'the graph to settle'}", values)
        if self._awaited:
            return Health(Level.OK, f"waiting for an answer on {min(self._awaited)[0]}", values)
        state = "paused" if self._playhead.paused else "playing"
        return Health(Level.WARN if self._players.skipped else Level.OK, state, values)


def _answer_of(topic: str, data: bytes) -> tuple[str, int] | None:
    """What an answer is known by: its topic and stamp [ns]; None where the bytes are too few to hold one."""
    try:
        return topic, stamp_of_bytes(data)
    except ValueError:
        return None


def main(args: Sequence[str] | None = None, *, interrupted: int = 0) -> int:
    """Run the node until the bag is over or it is stopped; ``interrupted``: exit code where it is stopped."""
    return run_node(ReplayNode, args, interrupted=interrupted)


if __name__ == "__main__":
    sys.exit(main())
