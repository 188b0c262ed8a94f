"""The guard around a repair method: whatever arrives and whatever the method does, an answer toward braking leaves."""

import math
import time
from dataclasses import replace

import numpy as np

from roadmend.core.command import Command, Decision, Trajectory
from roadmend.core.plain_moment import plain_moment
from roadmend.core.repair import Proposal, Repair, RepairStatus
from roadmend.core.route import Route
from roadmend.core.scene import Scene
from roadmend.repair.merger import merge, proposal_fault
from roadmend.repair.method import RepairMethod
from roadmend.repair.none import NO_OPINION
from roadmend.repair.parameters import GuardParameters, RssParameters
from roadmend.repair.rss import RssRepair
from roadmend.repair.sanitise import is_usable_ego, is_usable_plan, mark_usable, sanitise_command

GRAVITY = (  # from the least grave to the gravest; a repair reports the gravest that holds
    RepairStatus.PASS,
    RepairStatus.REPAIRED,
    RepairStatus.RESET,
    RepairStatus.INVALID_OBJECTS,
    RepairStatus.INVALID_COMMAND,
    RepairStatus.MODEL_FAULT,
    RepairStatus.STALE_COMMAND,
    RepairStatus.STALE_OBJECTS,
    RepairStatus.STARTING,
)
_EMPTY = Trajectory.empty()
_RULE_PAUSE = RssParameters().hold  # [s] what the rule remembers counts no longer than an intervention is held


def gravest(*held: RepairStatus) -> RepairStatus:
    """The gravest of some statuses, PASS if there is none."""
    return max(held, key=GRAVITY.index, default=RepairStatus.PASS)


class GuardedRepairer:
    """A Repairer that never raises (``core.interfaces.Repairer``) around a method that may.

    Holds no clock of its own: ages of messages are the node's affair, which calls ``controlled_stop`` for them. Wall
    time is looked at only where ``budget`` is set.
    """

    def __init__(self, method: RepairMethod, parameters: GuardParameters | None = None) -> None:
        self.name = method.name
        self.parameters = parameters or GuardParameters()
        self.stop_brake = min(1.0, self.parameters.stop_deceleration / self.parameters.full_brake)
        self._method = method
        self._rule = RssRepair(RssParameters(full_brake=self.parameters.full_brake))
        self._route: Route | None = None
        self._route_fault = ""
        self._method_fault = ""
        self.first_fault = ""  # why the method, ever since it was made, first could not answer; not that it was slow
        self._time = math.nan  # [s] stamp of the last tick; NaN before the first of an episode
        self._ruled = math.nan  # [s] stamp of the last tick that the rule judged; NaN before the first of an episode
        self._keep = np.zeros(64, dtype=np.bool_)

    def reset(self, route: Route) -> None:
        """Begin an episode on ``route``; the first tick after it is reported as RESET.

        On an unusable route every tick is answered with a controlled stop.
        """
        try:
            fault = route.fault
            self._route_fault = f"unusable route: {fault}" if fault else ""
        except Exception as error:  # noqa: BLE001 -- not even shaped like a route
            self._route_fault = f"unusable route: {error!r}"
        self._route = None if self._route_fault else route
        self._forget()

    def warm_up(self) -> None:
        """Compile and load everything before the first tick, which a time budget would else call a fault.

        To be called between episodes: the guard then waits for a ``reset``.
        """
        moment = plain_moment()
        self.reset(moment.route)
        self.step(moment.scene, moment.decision)
        self.controlled_stop(RepairStatus.STALE_COMMAND, scene=moment.scene)
        self._route = None

    def step(self, scene: Scene, decision: Decision) -> Repair:
        """Check one decision and repair it where needed."""
        try:
            return self._step(scene, decision)
        except Exception as error:  # noqa: BLE001 -- the last thing before the actuator always answers
            return self.controlled_stop(RepairStatus.STALE_OBJECTS, f"unusable input: {error!r}")

    def controlled_stop(
        self, status: RepairStatus, reason: str = "", scene: Scene | None = None, decision: Decision | None = None
    ) -> Repair:
        """The answer while something is missing: a bounded deceleration, held at standstill, no lane change.

        The brake is that of ``stop_deceleration``; harder only if a valid ``decision`` asks for it, or if ``scene`` is
        still current and the RSS method finds that the controlled stop would be too soft in it.

        Args:
            status: STARTING, STALE_COMMAND or STALE_OBJECTS.
            reason: what is missing or late, with numbers.
            scene: the scene of this tick if that is not what is missing.
            decision: the policy's decision for this tick if that is not what is missing.
        """
        brake = self.stop_brake
        asked = math.nan
        proposal = NO_OPINION
        try:
            if decision is not None:
                command = sanitise_command(decision.command, self.stop_brake)
                asked = command.action
                brake = max(brake, command.brake)
            if scene is not None and self._route is not None and is_usable_ego(scene.ego, scene.time):
                stop = Command(0.0, brake)
                rule = self._ask_rule(self._usable(scene)[0], Decision(stop, _EMPTY), self._route)
                if not proposal_fault(rule) and merge(stop, rule) is not stop:
                    proposal = rule
                    brake = -rule.action
                    reason = f"{reason}; rss: {rule.reason}"
        except Exception as error:  # noqa: BLE001 -- a stop must not fail
            reason = f"{reason}; without rss: {error!r}"
        return Repair(
            Command(0.0, brake),
            status,
            proposal.score,
            proposal.threshold,
            asked,
            -brake,
            asked != -brake,
            0,
            proposal.triggers,
            f"controlled stop at brake {brake:.2f}: {reason}",
        )

    def _forget(self) -> None:
        self._time = math.nan
        self._method_fault = ""
        if self._route is None:
            return
        try:
            self._method.reset(self._route)
        except Exception as error:  # noqa: BLE001 -- faults of the method are answered tick by tick
            self._method_fault = f"{self.name} could not be reset: {error!r}"
        try:
            self._reset_rule(self._route)
        except Exception as error:  # noqa: BLE001
            self._method_fault += f" rss could not be reset: {error!r}"

    def _reset_rule(self, route: Route) -> None:
        self._rule.reset(route)
        self._ruled = math.nan

    def _ask_rule(self, scene: Scene, decision: Decision, route: Route) -> Proposal:
        """The rule's proposal. It is asked only now and then: whom and where it saw some while ago is long past."""
        if abs(scene.time - self._ruled) > _RULE_PAUSE:
            self._reset_rule(route)
        self._ruled = scene.time
        return self._rule.propose(scene, decision)

    def _ask_both(
        self, scene: Scene, decision: Decision, route: Route, proposal: Proposal, final: Command
    ) -> tuple[Proposal, Command, list[str]]:
        """The rule's proposal and command in the place of the method's where the rule brakes harder, and a note on it."""
        try:
            rule = self._ask_rule(scene, decision, route)
            harder = final if proposal_fault(rule) else merge(final, rule)
        except Exception as error:  # noqa: BLE001 -- the method has answered: what it says holds
            return proposal, final, [f"without rss: {error!r}"]
        if harder is final:
            return proposal, final, []
        return rule, harder, [f"rss: {rule.reason}"]

    def _usable(self, scene: Scene) -> tuple[Scene, int]:
        """The scene with its usable objects only, and how many were dropped."""
        objects, bounds = scene.objects, self.parameters
        size = len(objects)
        if size > len(self._keep):
            self._keep = np.zeros(2 * size, dtype=np.bool_)
        dropped = mark_usable(self._keep, objects.table, bounds.max_length, bounds.max_width, bounds.max_speed)
        if dropped == 0:
            return scene, 0
        return replace(scene, objects=objects.select(self._keep[:size])), dropped

    def _valid(self, decision: Decision) -> tuple[Decision, str]:
        """A decision with a valid command and a usable trajectory, and what was wrong or an empty string."""
        command, plan = decision.command, decision.trajectory
        fault = command.fault
        is_usable = is_usable_plan(plan.interval, plan.x, plan.y, plan.yaw, plan.speed)
        if not fault and is_usable:
            return decision, ""
        if fault:
            command = sanitise_command(command, self.stop_brake)
            fault += f": taken as {command.action:+.2f}"
        if not is_usable:
            fault += f"{'; ' if fault else ''}the planned trajectory is unusable: the route is used instead"
            plan = _EMPTY
        return Decision(command, plan), fault

    def _step(self, scene: Scene, decision: Decision) -> Repair:
        if self._route is None:
            return self.controlled_stop(RepairStatus.STARTING, self._route_fault or "no route yet", None, decision)
        if not is_usable_ego(scene.ego, scene.time):
            return self.controlled_stop(RepairStatus.STALE_OBJECTS, "odometry is not finite", None, decision)
        notes: list[str] = []
        status = RepairStatus.PASS

        scene, dropped = self._usable(scene)
        if dropped:
            status = RepairStatus.INVALID_OBJECTS
            notes.append(f"dropped {dropped} unusable of {dropped + len(scene.objects)} objects")
        try:
            asked = decision.command
            decision, fault = self._valid(decision)
        except Exception as error:  # noqa: BLE001 -- not even shaped like a decision
            return self.controlled_stop(RepairStatus.STALE_COMMAND, f"unusable decision: {error!r}", scene)
        command = decision.command
        if fault:
            status = gravest(status, RepairStatus.INVALID_COMMAND)
            notes.append(fault)

        if not 0.0 < scene.time - self._time <= self.parameters.clock_jump:
            if not math.isnan(self._time):
                notes.append(f"time went from {self._time:.3f} s to {scene.time:.3f} s: memory cleared")
                self._forget()
            status = gravest(status, RepairStatus.RESET)
        self._time = scene.time

        proposal, fault = self._consult(scene, decision)
        if fault:
            status = gravest(status, RepairStatus.MODEL_FAULT)
            notes.append(fault)
            try:
                proposal = self._ask_rule(scene, decision, self._route)
                fault = proposal_fault(proposal)
            except Exception as error:  # noqa: BLE001 -- the guard's guard is a stop
                fault = repr(error)
            if fault:
                stop = self.controlled_stop(RepairStatus.MODEL_FAULT, "; ".join([*notes, fault]), None, decision)
                return replace(stop, dropped_objects=dropped)
            proposal = replace(proposal, hold_back=True)  # no lane change begins that nobody judges
        final = merge(command, proposal)
        if asked.fault:  # who asks for what cannot be is not the policy that the method knows: the rule judges it too
            proposal, final, note = self._ask_both(scene, decision, self._route, proposal, final)
            notes += note
        if final is not command and status == RepairStatus.PASS:
            status = RepairStatus.REPAIRED
        if proposal.reason:
            notes.append(proposal.reason)
        action = command.action
        return Repair(
            final,
            status,
            float(proposal.score),
            float(proposal.threshold),
            action,
            float(proposal.action),
            final is not asked,
            dropped,
            tuple(proposal.triggers),
            "; ".join(notes),
            None if proposal.worth is None else float(proposal.worth),
            held_back=command.change_lane and not final.change_lane,
        )

    def _consult(self, scene: Scene, decision: Decision) -> tuple[Proposal, str]:
        """The method's proposal, and what is wrong with it or an empty string."""
        budget = self.parameters.budget
        if self._method_fault:
            self._note(self._method_fault)
            return NO_OPINION, self._method_fault
        begin = time.perf_counter() if budget is not None else 0.0
        try:
            proposal = self._method.propose(scene, decision)
            fault = proposal_fault(proposal)
        except Exception as error:  # noqa: BLE001 -- any failure of the method is a fault, never a crash
            fault = f"{self.name} failed: {error!r}"
            self._note(fault)
            return NO_OPINION, fault
        fault = f"{self.name}: {fault}" if fault else ""
        self._note(fault)
        if budget is not None:
            spent = time.perf_counter() - begin
            if spent > budget:
                return proposal, f"{self.name} took {1e3 * spent:.1f} ms of {1e3 * budget:.1f} ms"
        return proposal, fault

    def _note(self, fault: str) -> None:
        self.first_fault = self.first_fault or fault
