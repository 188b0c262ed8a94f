"""sim_node: runs a scenario in SUMO, publishes what there is to see, drives the ego on the repaired command."""

import hashlib
import json
import math
import sys
import time
from collections.abc import Sequence
from pathlib import Path
from typing import Literal

from nav_msgs.msg import Odometry
from pydantic import Field
from rclpy.clock import Clock, ClockType
from rclpy.node import Node
from roadmend_msgs import msg
from rosgraph_msgs.msg import Clock as ClockMessage

from roadmend.core.command import Command
from roadmend.core.command_age import age_of, is_obeyed
from roadmend.core.episode_result import EpisodeResult, ResultBuilder
from roadmend.core.errors import InputError
from roadmend.core.outcome import Event, EventKind
from roadmend.core.parameters import Parameters
from roadmend.core.tick import INTERVAL, INTERVAL_NS, Tick
from roadmend.core.whole_file import write_text
from roadmend.nodes import qos
from roadmend.nodes.configuration import ConfigurationAnnouncer, Running
from roadmend.nodes.diagnostics import DiagnosticsReporter, Health, Level
from roadmend.nodes.graph_view import GraphView
from roadmend.nodes.inputs import REPAIRED
from roadmend.nodes.parameters import declare_parameters
from roadmend.nodes.recorder_progress import ProgressWatch
from roadmend.nodes.spinning import run_node
from roadmend.nodes.writer_gate import GatedInput
from roadmend.recording import messages, topics
from roadmend.recording.codec import encode
from roadmend.world.road_network import lanes_of
from roadmend.world.scenario_file import load_scenario
from roadmend.world.simulation import Simulation

WATCH_PERIOD_S = 0.01  # how often the lockstep watchdog looks [s]
PATIENCE_S = 5.0  # [s] after which it is said what keeps the drive from beginning: nodes of ours may compile meanwhile
IMPATIENCE_S = 1.5  # [s] the same where a node of somebody else's is waited for
REPEAT_S = 0.25  # period in which the first tick is repeated until it is answered [s]
BEGUN_SUFFIX = ".begun"  # of the empty file that lies beside the summary once the episode has begun
DRIVING_SUFFIX = ".driving"  # of the same once the first tick has been answered
LINGER_S = 0.3  # time for the others to take in the last tick [s]
IMPATIENT_S = 0.05  # lockstep: time a command is waited for while the repair node is known to be silent [s]
WATCHDOG_COMMAND = Command(0.0, 0.5)  # half brake: a controlled stop of 4 m/s2 on a dry road
_ANSWER = "an answer to the first tick"

# Who must listen to what before an episode begins, so that nothing of it is lost; of others it is enough that they are.
_LISTENERS = {
    topics.CLOCK: ("foxglove_node",),
    topics.EGO: ("policy_node", "repair_node", "recorder_node", "viz_node"),
    topics.OBJECTS: ("policy_node", "repair_node", "recorder_node", "viz_node"),
    topics.ROUTE: ("policy_node", "repair_node", "recorder_node", "viz_node"),
    topics.MAP: ("recorder_node", "viz_node"),
    topics.EVENTS: ("recorder_node", "viz_node"),
    topics.POLICY_COMMAND: ("repair_node", "recorder_node"),
    topics.POLICY_TRAJECTORY: ("repair_node", "recorder_node", "viz_node"),
    topics.REPAIR_COMMAND: ("recorder_node",),
    topics.REPAIR_STATE: ("recorder_node", "viz_node"),
}


class SimParameters(Parameters):
    """Parameters of the node, read once at start."""

    scenario: str = Field("", description="scenario file to run")
    clock: Literal["lockstep", "realtime"] = Field("lockstep", description="how time passes")
    rate: float = Field(1.0, ge=0.01, le=100.0, description="real time: simulated seconds per wall second")
    command_timeout: float = Field(
        5.0, ge=0.05, le=600.0, description="[s] lockstep: wall time without a command after which the watchdog brakes"
    )
    wait_for: tuple[str, ...] = Field(
        ("policy_node", "repair_node"), description="nodes that must have joined before the episode begins"
    )
    driver: Literal["unwatched", "own", "external"] = Field(
        "unwatched",
        description="who sends the policy's commands: own: policy_node, and others are named; external: a node of "
        "somebody else's, which is waited for and what is wrong with it named",
    )
    writer: str = Field(
        "",
        description="name of the node whose repaired commands are obeyed, without its namespace; whoever is there alone "
        "first if empty",
    )
    summary: str = Field("", description="file for the summary of the episode; none if empty")


class SimNode(Node):
    """One episode: waits for the graph, ticks until a final event, then finishes."""

    def __init__(self) -> None:
        super().__init__("sim_node")
        self.finished = False
        self.exit_code = 0
        settings = declare_parameters(self, SimParameters)
        self._lockstep = settings.clock == "lockstep"
        self._rate = settings.rate
        self._timeout = settings.command_timeout
        self._wait_for = settings.wait_for
        self._summary_path = settings.summary
        self._scenario_file = Path(settings.scenario)
        self._configuration = ConfigurationAnnouncer(self, "sim", self._running)
        if not settings.scenario:
            raise InputError("parameter scenario", "is empty", "name a scenario file: -p scenario:=FILE")
        self._simulation = Simulation(load_scenario(self._scenario_file))
        self._builder = ResultBuilder(self._simulation.scenario.name)
        self._view = GraphView(self, settings.driver, self._summary_path)
        self._tick: Tick | None = None
        self._tick_at = 0.0  # wall time [s] at which the current tick was published
        self._lacking: list[str] = []  # what keeps the drive from beginning, a policy of somebody else's aside
        self._lacking_since = 0.0  # wall time [s]
        self._begun_at = 0.0  # wall time [s] of the first answer
        self._watchdog = False
        self._watchdog_ticks = 0
        self._watchdog_since = 0  # ticks, if it brakes now
        self._last_command: tuple[int, Command] | None = None
        self._held: Command | None = None  # lockstep: of the current tick, until the recorder has caught up
        self._ended_at = 0.0
        self._clock_publisher = self.create_publisher(ClockMessage, topics.CLOCK, qos.STREAM)
        self._ego_publisher = self.create_publisher(Odometry, topics.EGO, qos.STREAM)
        self._objects_publisher = self.create_publisher(msg.ObjectList, topics.OBJECTS, qos.STREAM)
        self._event_publisher = self.create_publisher(msg.ScenarioEvent, topics.EVENTS, qos.EVENT)
        self._route_publisher = self.create_publisher(msg.Route, topics.ROUTE, qos.LATCHED)
        self._map_publisher = self.create_publisher(msg.Map, topics.MAP, qos.LATCHED)
        self._progress = ProgressWatch(self, self._timeout, self._release)
        self._commands = GatedInput(self, REPAIRED, msg.Command, settings.writer, self._on_command, time.monotonic)
        header = messages.header_of(0.0)
        self._route_publisher.publish(encode(messages.route_message_of(self._simulation.route, header)))
        self._map_publisher.publish(encode(messages.map_message_of(lanes_of(self._simulation.network), header)))
        steady = Clock(clock_type=ClockType.STEADY_TIME)
        self._timer = self.create_timer(WATCH_PERIOD_S, self._watch, clock=steady)
        self._real_time = None if self._lockstep else self.create_timer(INTERVAL / self._rate, self._beat, clock=steady)
        self._diagnostics = DiagnosticsReporter(self, self._health)
        self._configuration.announce()
        self.get_logger().info(f"{self._builder.scenario}: waiting for {', '.join(self._wait_for) or 'nobody'}")

    def _running(self) -> Running:
        digest = hashlib.sha256(self._scenario_file.read_bytes()).hexdigest()
        told = {"scenario_file": str(self._scenario_file.resolve()), "scenario_sha256": digest}
        return Running(self._simulation.scenario.name, told)

    # -- start --------------------------------------------------------------------------------------------------------

    def _missing(self) -> list[str]:
        """Nodes that have not joined yet, each with the first topic it does not listen to."""
        missing: dict[str, str] = {}
        for topic, listeners in _LISTENERS.items():
            wanted = [name for name in listeners if name in self._wait_for]
            if topic == topics.POLICY_TRAJECTORY and self._view.does_without_trajectory:
                wanted = [name for name in wanted if name != "recorder_node"]  # it subscribes to what is published
            infos = self.get_subscriptions_info_by_topic(topic)
            there = {self._view.original_name(info.node_name) for info in infos}
            for name in wanted:
                if name not in there:
                    missing.setdefault(name, f"{name} ({topic})")
        known = {name for listeners in _LISTENERS.values() for name in listeners}
        if others := [name for name in self._wait_for if name not in known]:
            there = set(map(self._view.original_name, self.get_node_names()))
            missing |= {name: name for name in others if name not in there}
        if "repair_node" in self._wait_for and not self.count_publishers(topics.REPAIR_COMMAND):
            missing.setdefault("repair_node", f"repair_node ({topics.REPAIR_COMMAND})")
        return [*missing.values(), *self._view.missing]

    def _begin(self) -> None:
        self._leave(BEGUN_SUFFIX)
        self._tick = self._simulation.first()
        self._publish(self._tick)

    def _leave(self, suffix: str) -> None:
        """An empty file beside the summary, for the launcher, which is no node."""
        if self._summary_path:
            Path(self._summary_path).with_suffix(suffix).touch()

    def _missing_long(self, now: float) -> list[str]:
        """What has kept the drive from beginning for so long that somebody should be told."""
        if self._begun_at or self._ended_at:
            return []
        lacking = (
            [name for name in self._missing() if name not in self._view.missing] if self._tick is None else [_ANSWER]
        )
        if lacking != self._lacking:
            self._lacking, self._lacking_since = lacking, now
        if now - self._lacking_since < (IMPATIENCE_S if self._view.is_external else PATIENCE_S):
            return []
        return lacking if self._tick is None else [f"{_ANSWER}: {self._view.repair_health}"]

    # -- time ---------------------------------------------------------------------------------------------------------

    def _watch(self) -> None:
        now = time.monotonic()
        self._view.look(now, self._missing_long, is_driving=self._begun_at > 0.0)
        if self._ended_at:
            if now - self._ended_at > LINGER_S:
                self.finished = True
            return
        if self._tick is None:
            if not self._missing() and self._view.is_settled(now):
                self._begin()
            return
        if not self._lockstep:
            return
        if self._tick.number == 0 and not self._watchdog:
            self._repeat(now)
            return
        if self._held is not None:
            self._release()
            return
        if now - self._tick_at > (IMPATIENT_S if self._watchdog else self._timeout):
            self._bite(f"no repaired command within {now - self._tick_at:.2f} s of wall time")

    def _beat(self) -> None:
        """Real time: the next tick is due, whatever has arrived."""
        if self._tick is None or self._ended_at:
            return
        if self._tick.number == 0 and self._last_command is None:
            self._repeat(time.monotonic())  # start-up is a state of its own: held until the first command
            return
        stamp, command = self._last_command or (-1, WATCHDOG_COMMAND)
        age = age_of(stamp, self._tick.number * INTERVAL_NS)
        if stamp < 0 or not is_obeyed(age):
            self._bite(f"the newest repaired command is {age * INTERVAL:.2f} s old")
        else:
            self._advance(command, obeyed=True)

    def _on_command(self, data: bytes) -> None:
        if self._tick is None or self._ended_at:
            return
        try:
            message = messages.COMMAND.decode(data)
        except ValueError as error:  # as good as none: the watchdog brakes
            self.get_logger().error(f"refused a command: {error}", throttle_duration_sec=1.0)
            return
        stamp, command = messages.stamp_of(message.header), messages.command_of(message)
        if command.fault:
            self.get_logger().error(f"refused a command: {command.fault}", throttle_duration_sec=1.0)
            return
        if stamp > self._tick.number * INTERVAL_NS:
            # Obeyed, it would count as fresh for as long as its stamp lies ahead.
            self.get_logger().error("refused a command for a tick that has not been yet", throttle_duration_sec=1.0)
            return
        if not self._lockstep:
            if self._last_command is None or stamp >= self._last_command[0]:
                self._last_command = (stamp, command)
        elif stamp == self._tick.number * INTERVAL_NS:
            self._held = command
            self._release()

    def _release(self) -> None:
        """Lockstep: obey the command that is held, unless the recorder is too far behind."""
        if self._tick is None or self._held is None or self._ended_at:
            return
        if not self._progress.holds(self._tick.number * INTERVAL_NS, time.monotonic() - self._tick_at):
            command, self._held = self._held, None
            self._advance(command, obeyed=True)

    def _bite(self, reason: str) -> None:
        """The watchdog: brake, and say so once."""
        if not self._watchdog:
            self._watchdog = True
            self._announce(EventKind.WATCHDOG, f"{reason}: the simulator brakes")
            self._diagnostics.complain(Level.ERROR)
        self._watchdog_ticks += 1
        self._watchdog_since += 1
        self._advance(WATCHDOG_COMMAND, obeyed=False)

    def _advance(self, command: Command, *, obeyed: bool) -> None:
        tick = self._tick
        if tick is None:
            return
        if obeyed and self._watchdog:
            self._watchdog = False
            self._watchdog_since = 0
            self._announce(EventKind.RECOVERED, "repaired commands arrive again")
        if not self._begun_at:
            self._begun_at = time.monotonic()
            self._leave(DRIVING_SUFFIX)
        now = tick
        if tick.final is None:  # else the ego stood in something from the first, and no command moves it
            now = self._tick = self._simulation.step(command)
            self._publish(now)
            # Book-keeping comes after the messages have left: the others work meanwhile.
            self._builder.command(tick, command)
        if now.final is not None:
            self._builder.command(now, Command(0.0, 0.0))
            self._end()

    # -- output -------------------------------------------------------------------------------------------------------

    def _publish(self, tick: Tick) -> None:
        self._publish_scene(tick)
        self._builder.see(tick)
        for event in tick.events:
            self._event_publisher.publish(encode(messages.event_message_of(event)))
        self._tick_at = time.monotonic()

    def _repeat(self, now: float) -> None:
        """Say the first tick again, now and then by the wall time [s]."""
        if self._tick is not None and now - self._tick_at > REPEAT_S:
            self._publish_scene(self._tick)
            self._tick_at = now

    def _publish_scene(self, tick: Tick) -> None:
        scene = tick.scene
        header = messages.header_of(scene.time)
        self._ego_publisher.publish(encode(messages.ego_message_of(scene.ego, header)))
        self._objects_publisher.publish(encode(messages.object_message_of(scene.objects, scene.signals, header)))
        # Last, because nobody on the command path waits for it.
        self._clock_publisher.publish(encode(messages.clock_message_of(scene.time)))

    def _announce(self, kind: EventKind, text: str) -> None:
        event = Event(self._tick.scene.time if self._tick is not None else 0.0, kind, text)
        self._builder.note(event)
        self._event_publisher.publish(encode(messages.event_message_of(event)))
        self.get_logger().warning(f"{kind.name}: {text}")

    def _end(self) -> None:
        self._ended_at = time.monotonic()
        self._view.look(math.inf, lambda _now: [], is_driving=True)  # whoever came late is in the summary
        result = self._builder.result()
        self._write_summary(result)
        self.get_logger().info(f"{result.outcome.name} after {result.duration:.2f} s: {result.text}")

    def _real_time_factor(self) -> float:
        wall = (self._ended_at or time.monotonic()) - self._begun_at
        return self._builder.duration / wall if self._begun_at and wall > 0.0 else 0.0

    def _write_summary(self, result: EpisodeResult) -> None:
        if not self._summary_path:
            return
        content = {
            "result": result.dump(),
            "watchdog_ticks": self._watchdog_ticks,
            "watchdog_since": self._watchdog_since,
            "real_time_factor": self._real_time_factor(),
            **self._view.content(),
        }
        write_text(Path(self._summary_path), json.dumps(content, indent=1))

    def _health(self) -> Health:
        values = {
            "scenario": self._builder.scenario,
            "tick": self._tick.number if self._tick else 0,
            "objects": len(self._tick.scene.objects) if self._tick else 0,
            "real_time_factor": f"{self._real_time_factor():.2f}",
            "watchdog_ticks": self._watchdog_ticks,
        }
        if self._tick is None:
            return Health(Level.WARN, f"waiting for {', '.join(self._missing())}", values)
        if self._watchdog:
            return Health(Level.ERROR, "no repaired commands: the watchdog brakes", values)
        if self._commands.warning:
            return Health(Level.WARN, self._commands.warning, values)
        return Health(Level.OK, self._builder.final.kind.name if self._builder.final else "running", values)

    def close(self) -> None:
        """An episode that is stopped before its end is recorded as aborted."""
        if not self._ended_at and self._tick is not None:
            self._announce(EventKind.ABORTED, "stopped before the end")
            self._end()
        self._simulation.close()


def main(args: Sequence[str] | None = None) -> int:
    """Run the node until the episode is over or it is stopped."""
    return run_node(SimNode, args)


if __name__ == "__main__":
    sys.exit(main())
