"""repair_node: the last thing before the actuator. A lifecycle node that always answers, toward braking when in doubt."""

import contextlib
import json
import sys
import time
from collections.abc import Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

from nav_msgs.msg import Odometry
from rcl_interfaces.msg import SetParametersResult
from rclpy.clock import Clock, ClockType
from rclpy.lifecycle import LifecycleState, TransitionCallbackReturn
from rclpy.parameter import Parameter
from roadmend_msgs import msg

from roadmend.core.command import Decision
from roadmend.core.errors import InputError, RoadmendError
from roadmend.core.repair import Repair, RepairStatus
from roadmend.core.route import Route
from roadmend.core.scene import Scene
from roadmend.core.whole_file import write_text
from roadmend.nodes import qos
from roadmend.nodes.configuration import ConfigurationAnnouncer
from roadmend.nodes.diagnostics import DiagnosticsReporter, Health, Level
from roadmend.nodes.foreign_inputs import ForeignInputs
from roadmend.nodes.frame_check import FrameCheck
from roadmend.nodes.inputs import COMMAND
from roadmend.nodes.lifecycle import SteadyLifecycleNode
from roadmend.nodes.method_settings import MethodSettings
from roadmend.nodes.parameters import declare_parameters
from roadmend.nodes.repair_settings import RepairNodeParameters, Times
from roadmend.nodes.repair_tally import RepairTally
from roadmend.nodes.spinning import run_node
from roadmend.nodes.tick_parts import TickParts, scene_of
from roadmend.nodes.writer_gate import GatedInput
from roadmend.recording import messages, topics
from roadmend.recording.codec import encode
from roadmend.recording.foreign_parameters import ForeignParameters
from roadmend.recording.foreign_repair import Answer
from roadmend.repair.assumed_motion import AssumedMotion
from roadmend.repair.guard import GuardedRepairer
from roadmend.repair.method import RepairMethod
from roadmend.repair.parameters import GuardParameters
from roadmend.repair.registry import make_method

_COMPLAINTS = frozenset({RepairStatus.STALE_COMMAND, RepairStatus.STALE_OBJECTS, RepairStatus.MODEL_FAULT})
_DOUBTS = frozenset({RepairStatus.INVALID_COMMAND, RepairStatus.INVALID_OBJECTS})


class RepairNode(SteadyLifecycleNode):
    """Intercepts the policy's command, repairs it with one method, and answers every tick."""

    def __init__(self) -> None:
        super().__init__("repair_node")
        self.exit_code = 0
        self.fault: RoadmendError | None = None  # because of which it did not configure
        self.finished = False
        self._repairer: GuardedRepairer | None = None
        self._made: RepairMethod | None = None  # what the repairer asks
        foreign = self._declare_parameters()
        self._check_topics()
        self._route: Route | None = None
        self._route_fault = ""
        self._motion = AssumedMotion()
        self._parts = TickParts(self, may_lack_plans=self._plans_are_optional)
        self._frames = FrameCheck()
        self._tally = RepairTally(self._journal)
        self._active = False
        self._started = False  # a complete tick has been answered in this episode
        self._is_over = False  # the simulator has said so: that no more ticks come is no fault
        self._silent_since: str = ""  # what is missing, or empty
        self._last_stamp = -1
        self._prepared: tuple[int, Scene | None] = (-1, None)
        self._last_answer = 0.0  # wall time [s]
        self._last_arrival = 0.0  # wall time [s] of the last message of a tick to come
        self._last_repair: Repair | None = None
        self._answered_stamp = -1  # [ns] of the last answer, whatever tick it was about
        self._foreign = None
        self._commands: GatedInput | None = None
        if self._is_newest:
            self._foreign = ForeignInputs(self, foreign, self._times.timeout, self._send_foreign)
        kind = msg.Command if self._foreign is None else self._foreign.command_kind
        self._command_publisher = self.create_lifecycle_publisher(kind, topics.REPAIR_COMMAND, qos.COMMAND)
        self._state_publisher = self.create_lifecycle_publisher(msg.RepairState, topics.REPAIR_STATE, qos.STREAM)
        if self._foreign is None:
            self._listen()
        self._diagnostics = DiagnosticsReporter(self, self._health)
        self.add_on_set_parameters_callback(self._on_parameters)
        if self._autostart:
            self._start_by_itself()

    def _listen(self) -> None:
        """Take in the messages of ticks that share a stamp."""
        self.create_subscription(msg.Route, topics.ROUTE, self._on_route, qos.LATCHED, raw=True)
        self.create_subscription(msg.ScenarioEvent, topics.EVENTS, self._on_event, qos.EVENT, raw=True)
        for part, kind, topic, profile in (
            ("ego", Odometry, topics.EGO, qos.STREAM),
            ("objects", msg.ObjectList, topics.OBJECTS, qos.STREAM),
            ("trajectory", msg.Trajectory, topics.POLICY_TRAJECTORY, qos.STREAM),
        ):
            self.create_subscription(kind, topic, partial(self._add, part), profile, raw=True)
        self._commands = GatedInput(
            self, COMMAND, msg.Command, self._writer, partial(self._add, "command"), time.monotonic
        )
        # Steady time: ages are looked at while simulation time stands still.
        self.create_timer(self._times.ages.period, self._watch, clock=Clock(clock_type=ClockType.STEADY_TIME))

    # -- configuration ------------------------------------------------------------------------------------------------

    def _declare_parameters(self) -> ForeignParameters:
        settings = declare_parameters(self, RepairNodeParameters)
        foreign = declare_parameters(self, ForeignParameters)
        self._plans_are_optional = settings.trajectory == "optional"
        self._method, self._seed, self._writer = settings.method, settings.seed, settings.writer
        self._is_newest = settings.inputs == "newest"
        self._times = Times.of(settings)
        self._guard = GuardParameters(budget=self._times.budget, full_brake=foreign.full_brake)
        self._autostart, self._summary = settings.autostart, settings.summary
        self._journal = Path(settings.journal) if settings.journal else None
        self._settings = method = MethodSettings(self, settings.method, settings.policy, foreign.full_brake)
        self._configuration = ConfigurationAnnouncer(self, "repair", lambda: method.running(self._made), method.is_told)
        return foreign

    def _check_topics(self) -> None:
        """Refuse to hear its own answers as the policy's commands, which it would answer again, without an end.

        Raises:
            InputError: the two have one name, after remapping.
        """
        asked, answered = map(self.resolve_topic_name, (topics.POLICY_COMMAND, topics.REPAIR_COMMAND))
        if asked == answered:
            what = "is the topic of the policy's commands and of the repaired ones"
            raise InputError(asked, what, f"remap one of them: -r {topics.REPAIR_COMMAND}:=/YOUR/TOPIC")

    def _make_repairer(self, changed: Sequence[Parameter] = ()) -> GuardedRepairer:
        made = make_method(self._method, self._settings.values(changed), self._seed)
        repairer = GuardedRepairer(made, self._guard)
        repairer.warm_up()  # compiling on the first tick would look like an overrun
        self._made = made
        return repairer

    def _on_parameters(self, changed: list[Parameter]) -> SetParametersResult:
        if self._repairer is None or not self._settings.concerns(changed):
            return SetParametersResult(successful=True)
        try:
            repairer = self._make_repairer(changed)
        except InputError as error:
            return SetParametersResult(successful=False, reason=str(error))
        self._use(repairer)
        return SetParametersResult(successful=True)

    def _use(self, repairer: GuardedRepairer) -> None:
        if self._route is not None:
            repairer.reset(self._route)
        self._repairer = repairer
        if self._foreign is not None:
            self._foreign.use(repairer)

    def _start_by_itself(self) -> None:
        for transition in (self.trigger_configure, self.trigger_activate):
            if transition() != TransitionCallbackReturn.SUCCESS:
                self.finished = True
                self.exit_code = 2
                return

    def on_configure(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Make the method; without one the node stays unconfigured and sends nothing, so the simulator brakes."""
        try:
            self._use(self._make_repairer())
            self._configuration.announce()
        except Exception as error:  # noqa: BLE001 - whatever a method does, there is a refusal with its reason
            told = error if isinstance(error, RoadmendError) else RoadmendError(f"{type(error).__name__}: {error}")
            self.get_logger().error(f"refuses to configure: {told}")
            self.fault = told
            return TransitionCallbackReturn.FAILURE
        return super().on_configure(state)

    def on_activate(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Begin to answer."""
        self._active = True
        self._last_arrival = time.monotonic()
        return super().on_activate(state)

    def on_deactivate(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Stop answering. The simulator's watchdog then brakes; to drive unrepaired, run ``method: none``."""
        self._active = False
        return super().on_deactivate(state)

    def on_shutdown(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Stop answering for good, whatever state it was in."""
        if self._active:
            self.on_deactivate(state)
        return super().on_shutdown(state)

    def on_cleanup(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Forget the method."""
        self._repairer = None
        return super().on_cleanup(state)

    # -- input --------------------------------------------------------------------------------------------------------

    def _on_route(self, data: bytes) -> None:
        self._parts.begin()
        self._prepared = (-1, None)
        self._started = self._is_over = False
        self._last_stamp = self._answered_stamp = -1
        self._last_repair, self._silent_since = None, ""
        try:
            self._route, self._route_fault = messages.route_of(messages.ROUTE.decode(data)), ""
        except ValueError as error:  # without a route nothing is answered, so the simulator holds the vehicle
            self._route, self._route_fault = None, str(error)
            self.get_logger().error(f"unusable: {error}")
            return
        self._motion.reset(self._route)
        if self._repairer is not None:
            self._repairer.reset(self._route)

    def _on_event(self, data: bytes) -> None:
        with contextlib.suppress(ValueError):  # bytes that are no event end nothing
            event = messages.event_of(messages.EVENT.decode(data))
            self._is_over = self._is_over or (event is not None and event.kind.is_final)

    def _add(self, part: str, data: bytes) -> None:
        if self._frames.is_foreign(part, data):
            self.get_logger().warning(self._frames.warning, throttle_duration_sec=1.0)
            return
        try:
            stamp = messages.stamp_of_bytes(data)
        except ValueError as error:  # as good as none: its tick is late
            self.get_logger().error(f"unusable: {part}: {error}", throttle_duration_sec=1.0)
            return
        if self._parts.is_stray(part, stamp):  # paired, it would be waited for as the newest tick
            return
        if stamp == self._last_stamp and part == "objects" and self._last_repair is not None:
            self._publish(self._last_repair, stamp)  # a repeated tick gets the same answer again
            return
        if stamp < self._last_stamp and part in ("ego", "objects"):
            if self._parts.pairing.comes_too_late(stamp, part):
                return
            self._last_stamp = -1  # time ran backwards: the guard sees it and resets the method
            self._parts.pairing.clear()
            self._prepared = (-1, None)
            self._motion.reset(self._route)
        if stamp <= self._last_stamp:
            return
        self._last_arrival = now = time.monotonic()
        tick = self._parts.pairing.add(stamp, part, data, now)
        if tick is not None:
            self._answer(stamp, tick)
        elif part in {"ego", "objects"}:
            self._prepare(stamp)
            if self._active and self._started and not self._times.is_lockstep:
                self._answer_late(now)  # a new tick ages those before it, at high rates faster than the watch looks

    def _prepare(self, stamp: int) -> None:
        """Build the scene while the policy still thinks about it."""
        waiting = self._parts.pairing.waiting()
        if waiting is not None and waiting[0] == stamp and {"ego", "objects"} <= waiting[1].keys():
            with contextlib.suppress(ValueError):  # said when the tick is answered
                self._prepared = (stamp, scene_of(stamp, waiting[1], self._route))

    def _answer(self, stamp: int, tick: dict[str, bytes]) -> None:
        if not self._active or self._repairer is None:
            return
        decision = None
        try:
            decision = self._parts.decision(tick)
            prepared, scene = self._prepared
            if prepared != stamp or scene is None:
                scene = scene_of(stamp, tick, self._route)
        except ValueError as error:  # bytes that are no such message, or arrays that differ in length
            repair = self._repairer.controlled_stop(RepairStatus.STALE_OBJECTS, str(error), None, decision)
        else:
            if scene is None or decision is None:
                return  # no route yet; the simulator repeats the first tick
            repair = self._step(scene, decision, is_planned="trajectory" in tick)
        self._started = True
        self._silent_since = ""
        self._send(stamp, repair)

    def _step(self, scene: Scene, decision: Decision, *, is_planned: bool) -> Repair:
        assert self._repairer is not None
        if is_planned:
            return self._repairer.step(scene, decision)
        repair = self._repairer.step(scene, self._motion.decide(scene.ego, decision.command))
        return replace(repair, reason=f"{self._motion.assumption}; {repair.reason}".removesuffix("; "))

    # -- ages ---------------------------------------------------------------------------------------------------------

    def _watch(self) -> None:
        """Look for inputs that are late, and answer without them."""
        now = time.monotonic()
        self._parts.look(now)
        if not self._active or self._repairer is None or (self._times.is_lockstep and not self._started):
            return  # in lockstep the simulator repeats the first tick until the policy has joined
        self._answer_late(now)
        if self._times.is_lockstep or self._is_over or self._parts.pairing.waiting() is not None:
            return
        ages = self._times.ages
        if now - self._last_arrival > ages.silence and now - self._last_answer > ages.tick:
            self._repeat_stop(now)

    def _answer_late(self, now: float) -> None:
        """Answer the oldest tick, and those that are as late, if it is late.

        A first tick after which none comes is held by the simulator until the policy has answered it: an answer in the
        policy's place would let the vehicle go, and brake it from there on.
        """
        if self._repairer is None or (not self._started and self._parts.is_held):
            return
        late = self._parts.take_late(now, self._times.ages, is_silent=bool(self._silent_since))
        if late is None:
            return
        status = RepairStatus.STALE_OBJECTS if late.lacks_scene else RepairStatus.STALE_COMMAND
        if not self._started:
            status = RepairStatus.STARTING
        self._silent_since = ", ".join(late.missing)
        try:
            scene, decision = scene_of(late.stamp, late.parts, self._route), self._parts.decision(late.parts)
            repair = self._repairer.controlled_stop(status, late.reason, scene, decision)
        except ValueError as error:
            repair = self._repairer.controlled_stop(status, f"{late.reason}; {error}")
        self._send(late.stamp, repair)

    def _repeat_stop(self, now: float) -> None:
        """Real time, and nothing arrives at all: silence never means go."""
        if self._repairer is None or self._answered_stamp < 0:
            return  # before the first answer nothing is stopped yet
        self._silent_since = "odometry, objects"
        age = now - self._last_arrival
        repair = self._repairer.controlled_stop(RepairStatus.STALE_OBJECTS, f"nothing has arrived for {age:.2f} s")
        self._tally.add(self._answered_stamp * 1e-9, repair)
        self._publish(repair, self._answered_stamp)
        self._diagnostics.complain(Level.ERROR)

    # -- output -------------------------------------------------------------------------------------------------------

    def _send_foreign(self, answer: Answer) -> None:
        if self._active:
            self._started = True
            self._send(answer.stamp, answer.repair, answer.message)

    def _send(self, stamp: int, repair: Repair, command: Any = None) -> None:
        """Answer a tick; ``command`` is the message where it is of another form than the repair's own command."""
        self._last_stamp = stamp
        self._last_repair = repair
        self._publish(repair, stamp, command)
        self._tally.add(stamp * 1e-9, repair)
        if repair.status in _COMPLAINTS:
            self.get_logger().warning(f"{repair.status.name}: {repair.reason}", throttle_duration_sec=1.0)
            self._diagnostics.complain(Level.ERROR)
        elif repair.status in _DOUBTS:
            self._diagnostics.complain(Level.WARN)

    def _publish(self, repair: Repair, stamp: int, command: Any = None) -> None:
        self._last_answer = time.monotonic()
        self._answered_stamp = stamp
        header = messages.header_at(stamp)
        message = messages.command_message_of(repair.command, header) if command is None else command
        self._command_publisher.publish(encode(message))
        self._state_publisher.publish(encode(messages.repair_message_of(repair, self._method, header)))

    def _health(self) -> Health:
        values = {"method": self._method, "active": self._active, **self._tally.values()}
        if not self._active:
            return Health(Level.WARN, "inactive: sends no commands, the simulator brakes", values)
        if self._foreign is not None:
            values["trajectory"] = self._foreign.assumption or "planned"
            missing = self._foreign.missing()
            values |= {f"missing {part}": why for part, why in missing.items()}
            if missing:
                return Health(Level.ERROR, f"missing {', '.join(missing)}: no unrepaired command passes", values)
            crowded = self._foreign.crowded()
            if crowded:
                return Health(Level.WARN, "; ".join(crowded.values()), values)
        if self._route_fault:
            return Health(Level.ERROR, self._route_fault, values)
        if self._silent_since:
            why = f"; {self._frames.warning}" if self._frames.warning else ""
            return Health(Level.ERROR, f"controlled stop: missing {self._silent_since}{why}", values)
        if self._frames.warning:
            return Health(Level.WARN, self._frames.warning, values)
        last = self._last_repair
        if last is not None and last.status in _COMPLAINTS:
            return Health(Level.ERROR, last.reason, values)
        if last is not None and last.status in _DOUBTS:
            return Health(Level.WARN, last.reason, values)
        if self._commands is not None and self._commands.warning:
            return Health(Level.WARN, self._commands.warning, values)
        crowd = COMMAND.publishers(self)
        if len(set(crowd)) > 1:
            return Health(Level.WARN, f"several nodes send the policy's commands: {', '.join(crowd)}", values)
        return Health(Level.OK, "repairing" if self._started else self._parts.lack(), values)

    def close(self) -> None:
        """Write the tally if a file was named."""
        self._tally.close()
        if self._summary:
            fault = "" if self._repairer is None else self._repairer.first_fault
            told = {**self._tally.account(), "fault": fault, "frames": self._frames.account}
            write_text(Path(self._summary), json.dumps(told, indent=1))


def main(args: Sequence[str] | None = None) -> int:
    """Run the node until it is stopped."""
    return run_node(RepairNode, args)


if __name__ == "__main__":
    sys.exit(main())
