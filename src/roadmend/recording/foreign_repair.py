"""Repair in a graph that is not ours: the newest of every input, whatever its rate and its stamps, at every command.

Needs no ROS: the node hands over messages with the time of their arrival, and so does who reads a bag.
"""

import math
from dataclasses import dataclass, replace
from typing import Any

from roadmend.core.command import Decision, Trajectory
from roadmend.core.repair import Repair, RepairStatus
from roadmend.core.route import Route
from roadmend.core.scene import ObjectList, Scene
from roadmend.recording import messages
from roadmend.recording.foreign_commands import CommandForm
from roadmend.recording.foreign_objects import EgoOutline, EgoPose, ObjectReader, Signals, ego_pose_of
from roadmend.repair.assumed_motion import AssumedMotion, open_route
from roadmend.repair.guard import GuardedRepairer, gravest
from roadmend.repair.sanitise import is_usable_plan

EGO, OBJECTS, COMMAND, TRAJECTORY, ROUTE = "ego", "objects", "command", "trajectory", "route"
NEEDED = (EGO, OBJECTS, COMMAND)  # without these nothing can be repaired
REPEATED_NS = 100_000_000  # [ns] a stamp less far behind the last one is no jump of the clock, but a repeated stamp
STEP_NS = 1_000  # [ns] between the ticks of commands with the same stamp


@dataclass(frozen=True, slots=True)
class Answer:
    """What goes to the vehicle for one command, or in place of one."""

    stamp: int  # [ns]
    repair: Repair
    message: Any  # of the form in which the command came


@dataclass(frozen=True, slots=True)
class _Seen:
    objects: ObjectList
    signals: Signals
    stamp: int  # [ns]


class ForeignRepair:
    """Answers each command with the newest ego and objects, and toward braking where one of these is late.

    Every command is answered at once, so it costs no delay. A tick's time is its command's stamp; the ego's where that
    is zero; that of the command's arrival where both are. Without a planned trajectory the present motion is assumed (``repair.assumed_motion``), and the reason says
    so; without a route, nothing is known of lanes and of the right of way.

    Args:
        vehicle: what odometry does not tell.
        reader: of the objects' messages.
        form: of the commands' messages.
        patience: [s] after which an input counts as late: since it arrived, and behind the other's stamp.
    """

    def __init__(self, vehicle: EgoOutline, reader: ObjectReader, form: CommandForm, patience: float) -> None:
        self._vehicle, self._reader, self._form, self._patience = vehicle, reader, form, patience
        self._repairer: GuardedRepairer | None = None
        self._route: Route | None = None
        self._motion = AssumedMotion()
        self._motion.reset(None)
        self._pose: EgoPose | None = None
        self._seen: _Seen | None = None
        self._trajectory: Trajectory | None = None
        self._planned_in = ""  # frame of that
        self._asked: Any | None = None  # the last command's message
        self._arrivals: dict[str, float] = {}  # [s] of the last usable message of each input
        self._faults: dict[str, str] = {}  # why the last message of an input was not usable
        self._stamp = -1  # [ns] of the last command's tick
        self._is_stamped = True  # whether anything said when that was
        self._assumption = str(self._motion.assumption)  # for the last tick
        self._started = False

    def use(self, repairer: GuardedRepairer) -> None:
        """Repair with this from now on."""
        self._repairer = repairer
        self._reset()

    def _reset(self) -> None:
        self._motion.reset(self._route)
        if self._repairer is not None:
            self._repairer.reset(self._route or open_route(self._vehicle.length, self._vehicle.width))

    def take_route(self, message: Any) -> None:
        """Begin anew, on this route (roadmend_msgs/Route).

        Raises:
            ValueError: it is unusable.
        """
        self._route = messages.route_of(message)
        self._reset()

    def take_ego(self, message: Any, now: float) -> None:
        """Take in odometry that arrived at ``now`` [s]."""
        self._pose = ego_pose_of(message, self._vehicle)
        self._arrived(EGO, now)

    def take_objects(self, message: Any, now: float) -> None:
        """Take in objects that arrived at ``now`` [s]."""
        if self._pose is None:
            self._faults[OBJECTS] = "no odometry yet, so that they have no place"
            return
        try:
            objects, signals = self._reader.read(message, self._pose)
        except ValueError as error:
            self._faults[OBJECTS] = str(error)
            return
        self._seen = _Seen(objects, signals, messages.stamp_of(message.header))
        self._arrived(OBJECTS, now)

    def take_trajectory(self, message: Any, now: float) -> None:
        """Take in a planned trajectory (roadmend_msgs/Trajectory) that arrived at ``now`` [s]."""
        frame = message.header.frame_id
        if self._pose is not None and frame != self._pose.frame:
            self._faults[TRAJECTORY] = _other_frame(frame, self._pose.frame)
            return
        self._trajectory, self._planned_in = messages.trajectory_of(message), frame
        self._arrived(TRAJECTORY, now)

    def take_command(self, message: Any, now: float) -> Answer | None:
        """Answer a command that arrived at ``now`` [s]; None as long as there is no repairer."""
        self._asked = message
        self._arrived(COMMAND, now)
        self._stamp = self._tick_of(messages.stamp_of(message.header))
        if self._repairer is None:
            return None
        command = self._form.read(message)
        missing = self._late_inputs(now)
        if missing or self._pose is None or self._seen is None:
            status = RepairStatus.STALE_OBJECTS if self._started else RepairStatus.STARTING
            decision = Decision(command, Trajectory.empty())
            return self._answer(self._repairer.controlled_stop(status, missing, None, decision), self._stamp, message)
        ego, planned = self._pose.ego, self._planned(self._pose.frame, now)
        note = self._faults.get(TRAJECTORY, "")
        # Without a route the guard has nothing to put in the place of a plan that is unusable or has no points.
        is_usable = planned is None or is_usable_plan(
            planned.interval, planned.x, planned.y, planned.yaw, planned.speed
        )
        if not is_usable:
            planned, note = None, "the planned trajectory is unusable: not used"
        if planned is not None and len(planned):
            decision = Decision(command, planned)
            self._assumption = ""
        else:
            decision = self._motion.decide(ego, command)
            self._assumption = str(self._motion.assumption)
        scene = Scene(self._time_of(self._stamp, now), ego, self._seen.objects, self._seen.signals)
        repair = self._repairer.step(scene, decision)
        if not is_usable:  # which the guard, that is not given it, cannot declare
            repair = replace(repair, status=gravest(repair.status, RepairStatus.INVALID_COMMAND))
        self._started = True
        reason = "; ".join(filter(None, (repair.reason, note, self._assumption)))
        return self._answer(replace(repair, reason=reason), self._stamp, message)

    def overdue(self, now: float, clock: int | None = None) -> Answer | None:
        """What to send at ``now`` [s] in place of a command that is late; None while none is, and before the first.

        Its stamp is the last command's and the time since: a vehicle that takes no old commands must take this one. Where
        commands have no stamp it has none either.

        Args:
            now: wall time [s], from any moment on.
            clock: what the stack's own clock says [ns], where that is not the wall's: it may stand still.
        """
        arrived = self._arrivals.get(COMMAND)
        if arrived is None or self._asked is None or self._repairer is None or now - arrived <= self._patience:
            return None
        passed = round((now - arrived) * messages.NANOSECONDS)
        stamp = self._stamp + passed if clock is None else max(self._stamp, clock)
        missing = self._late_inputs(now)
        reason = f"no command for {now - arrived:.2f} s"
        if missing or self._pose is None or self._seen is None:
            status = RepairStatus.STALE_OBJECTS if self._started else RepairStatus.STARTING
            repair = self._repairer.controlled_stop(status, f"{reason}; {missing}")
        else:
            scene = Scene(self._time_of(stamp, now), self._pose.ego, self._seen.objects, self._seen.signals)
            repair = self._repairer.controlled_stop(RepairStatus.STALE_COMMAND, reason, scene)
        header = self._asked.header
        if messages.stamp_of(header):
            header = replace(header, stamp=messages.stamp_message_of(stamp))
        return self._answer(repair, stamp, replace(self._asked, header=header))

    def silent(self, now: float) -> dict[str, str]:
        """The needed inputs that are late at ``now`` [s], and why as far as that is known here."""
        late = {part: self._faults.get(part, "") for part in NEEDED if not self._is_fresh(part, now)}
        if not late and (skew := self._skew()):
            late[OBJECTS] = skew
        return late

    @property
    def assumption(self) -> str:
        """What was assumed for the last tick for want of a planned trajectory; empty where there was one."""
        return self._assumption

    def _arrived(self, part: str, now: float) -> None:
        self._arrivals[part] = now
        self._faults.pop(part, None)

    def _is_fresh(self, part: str, now: float) -> bool:
        return now - self._arrivals.get(part, -math.inf) <= self._patience

    def _planned(self, frame: str, now: float) -> Trajectory | None:
        """The planned trajectory where it is fresh and in the odometry's frame, which nobody knew if it came first."""
        if self._trajectory is None or not self._is_fresh(TRAJECTORY, now):
            return None
        if self._planned_in != frame:
            self._faults[TRAJECTORY] = _other_frame(self._planned_in, frame)
            return None
        return self._trajectory

    def _late_inputs(self, now: float) -> str:
        """What of the scene is late, with numbers; empty if nothing is."""
        told = []
        for part in (EGO, OBJECTS):
            if not self._is_fresh(part, now):
                arrived, why = self._arrivals.get(part), self._faults.get(part)
                age = "none yet" if arrived is None else f"the last {now - arrived:.2f} s ago"
                told.append(f"no {part}: {why or age}")
        return "; ".join(told) or self._skew()

    def _skew(self) -> str:
        """How far the stamps of ego and objects are apart where that is too far; stamps of zero say nothing."""
        if self._pose is None or self._seen is None or not self._pose.stamp or not self._seen.stamp:
            return ""
        behind = 1e-9 * (self._pose.stamp - self._seen.stamp)
        if abs(behind) <= self._patience:
            return ""
        old, new = (OBJECTS, EGO) if behind > 0.0 else (EGO, OBJECTS)
        return f"{old} stamped {abs(behind):.2f} s before {new}"

    def _tick_of(self, stamp: int) -> int:
        """The stamp of a tick [ns], later than the last one's unless the clock was set back."""
        if not stamp and self._pose is not None:
            stamp = self._pose.stamp
        self._is_stamped = stamp != 0
        return self._stamp + STEP_NS if 0 <= self._stamp - stamp < REPEATED_NS else stamp

    def _time_of(self, stamp: int, now: float) -> float:
        """What the methods are told to be the time [s]; without stamps it is only known when something arrived."""
        return 1e-9 * stamp if self._is_stamped else now

    def _answer(self, repair: Repair, stamp: int, asked: Any) -> Answer:
        return Answer(stamp, repair, self._form.write(repair.command, messages.header_at(stamp), asked))


def _other_frame(given: str, wanted: str) -> str:
    return f"planned trajectory in the frame {given!r}, not in {wanted}: not used"
