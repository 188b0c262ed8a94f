"""Scripted misbehaviour of single actors, on top of what SUMO's drivers do by themselves."""

import math
from collections.abc import Collection, Iterator, Mapping
from dataclasses import dataclass

import libsumo

from roadmend.core.scene import ObjectList
from roadmend.world.courtesy import Courtesy, set_deceleration
from roadmend.world.drifting import Drifter, Follower
from roadmend.world.ego import GRAVITY
from roadmend.world.participants import Observation
from roadmend.world.scenario import Scenario
from roadmend.world.scenario_actors import Brake, CutIn, Drift, Follow, Heedless, Manoeuvre, RunRightOfWay, Vehicle
from roadmend.world.steering import SteeredVehicle
from roadmend.world.traffic_file import EGO

_SPEED_MODE_NORMAL = 31
_SPEED_MODE_HEEDLESS = 2 + 4  # keeps to what its engine and brakes can do, and to nothing else
_SPEED_MODE_NO_RIGHT_OF_WAY = 31 - 8 - 16  # gives way to nobody who is not in the junction yet, sees no red light
_RUN_ACCELERATION = 4.0  # [m/s2] of a driver in haste
_LANE_CHANGE_FORCED = 0  # SUMO obeys the request whatever is in the way
_LANE_CHANGE_NORMAL = 1621
_SAME_LANE = 1.6  # [m] half a lane
_CUT_IN_TIME = 3.0  # [s] that a cut-in keeps its lane


_Passing = Brake | CutIn | RunRightOfWay  # over after a while


@dataclass
class _Running:
    until: float  # [s]
    slow_at: float  # [s] a braking vehicle has its low speed and keeps it from then on
    vehicle: str
    manoeuvre: _Passing
    deceleration: float  # [m/s2] that the driver brakes with otherwise


class ManoeuvreScript:
    """Starts and ends the manoeuvres of a scenario's vehicles.

    Who waits for the ego out of ``courtesy`` goes on where the manoeuvre is by then.
    """

    def __init__(self, scenario: Scenario, courtesy: Courtesy | None = None) -> None:
        self._courtesy = courtesy or Courtesy()
        self._held: dict[str, float] = {}
        self._waiting: list[tuple[str, Manoeuvre]] = [
            (actor.id, manoeuvre)
            for actor in scenario.actors
            if isinstance(actor, Vehicle)
            for manoeuvre in actor.manoeuvres
        ]
        self._grip = scenario.environment.effective_friction * GRAVITY  # [m/s2]
        self._running: list[_Running] = []
        self._drifting: dict[str, Drifter | Follower] = {}
        self._heedless: set[str] = set()
        self._names: tuple[str, ...] = ()
        self._places: dict[str, int] = {}

    @property
    def heedless(self) -> Collection[str]:
        """Names of those who have stopped to look at others."""
        return self._heedless

    @property
    def held(self) -> Mapping[str, float]:
        """Speeds [m/s] that vehicles hold at the end of their braking."""
        return self._held

    @property
    def steered(self) -> Iterator[SteeredVehicle]:
        """Those who have left the lanes."""
        return (leader.driven for leader in self._drifting.values())

    def step(self, time: float, ego: tuple[float, float, float], seen: Observation | None) -> None:
        """Start what is due at ``time`` [s] with the ego at a pose ([m], [m], [rad]), end what is over.

        ``seen`` is the last observation; an actor that is not in it is not near the ego.
        """
        if not self._running and not self._waiting and not self._drifting:
            return
        self._drifting = {name: drifter for name, drifter in self._drifting.items() if drifter.step(time)}
        if self._running:
            self._end(time)
        if not self._waiting or seen is None:
            return
        if seen.names is not self._names:
            self._names = seen.names
            self._places = {name: place for place, name in enumerate(seen.names)}
        still = []
        for vehicle, manoeuvre in self._waiting:
            if self._due(time, ego, vehicle, manoeuvre, seen.around) and vehicle in libsumo.vehicle.getIDList():
                if isinstance(manoeuvre, Heedless | Drift | Follow):
                    self._begin_heedless(time, vehicle, manoeuvre)
                    continue
                if isinstance(manoeuvre, Brake):  # of two, the end of the first would undo the second
                    self._finish(
                        [
                            each
                            for each in self._running
                            if each.vehicle == vehicle and isinstance(each.manoeuvre, Brake)
                        ]
                    )
                deceleration = libsumo.vehicle.getDecel(vehicle)
                until = time + _start(vehicle, manoeuvre, self._grip)
                slow_at = until - manoeuvre.hold if isinstance(manoeuvre, Brake) else math.inf
                self._running.append(_Running(until, slow_at, vehicle, manoeuvre, deceleration))
            else:
                still.append((vehicle, manoeuvre))
        self._waiting = still

    def _begin_heedless(self, time: float, vehicle: str, manoeuvre: Heedless | Drift | Follow) -> None:
        """Begin what lasts to the end of the episode; what is under way ends now, since its end would undo this later."""
        goes_on: tuple[type, ...] = (
            (CutIn,) if isinstance(manoeuvre, Heedless) else ()
        )  # sideways, beside a speed that is held
        self._finish(
            [each for each in self._running if each.vehicle == vehicle and not isinstance(each.manoeuvre, goes_on)]
        )
        self._heedless.add(vehicle)
        if isinstance(manoeuvre, Drift | Follow):
            before = self._drifting.get(vehicle)
            if isinstance(manoeuvre, Drift):
                leader: Drifter | Follower = Drifter(vehicle, manoeuvre, time, self._grip, before)
            else:
                leader = Follower(vehicle, manoeuvre, self._grip, before)
            if before is None:  # SUMO would move it along its lane meanwhile; who was led has been moved already
                leader.step(time)
            self._drifting[vehicle] = leader
            return
        libsumo.vehicle.setSpeedMode(vehicle, _SPEED_MODE_HEEDLESS)
        libsumo.vehicle.setSpeed(vehicle, manoeuvre.speed)

    def _due(
        self, time: float, ego: tuple[float, float, float], vehicle: str, manoeuvre: Manoeuvre, around: ObjectList
    ) -> bool:
        when = manoeuvre.when
        if when.ego_distance is None:
            return when.time is not None and time >= when.time
        place = self._places.get(vehicle)
        if place is None:
            return False
        dx, dy = around.x[place] - ego[0], around.y[place] - ego[1]
        near = dx * dx + dy * dy <= when.ego_distance * when.ego_distance
        return bool(near and math.cos(ego[2]) * dx + math.sin(ego[2]) * dy > 0.0)

    def _end(self, time: float) -> None:
        still = []
        present = frozenset(libsumo.vehicle.getIDList())
        for running in self._running:
            if running.vehicle not in present:
                continue
            if time < running.until:
                if time >= running.slow_at and isinstance(running.manoeuvre, Brake):
                    if running.vehicle not in self._courtesy.waiting:
                        slow = min(running.manoeuvre.speed, libsumo.vehicle.getSpeed(running.vehicle))
                        libsumo.vehicle.setSpeed(running.vehicle, slow)
                    self._held[running.vehicle] = running.manoeuvre.speed
                    running.slow_at = math.inf
                still.append(running)
                continue
            self._let_go(running)
        self._running = still

    def _finish(self, ending: list[_Running]) -> None:
        self._running = [each for each in self._running if each not in ending]
        for each in ending:
            self._let_go(each)

    def _let_go(self, running: _Running) -> None:
        """Let a vehicle drive on as before its manoeuvre; one that has run somebody's right of way stays as lively."""
        vehicle, manoeuvre = running.vehicle, running.manoeuvre
        if isinstance(manoeuvre, Brake):
            self._held.pop(vehicle, None)
            if self._courtesy.resume(vehicle, running.deceleration):
                return
            libsumo.vehicle.setSpeed(vehicle, -1.0)
            set_deceleration(vehicle, running.deceleration)
        elif isinstance(manoeuvre, CutIn):
            libsumo.vehicle.setLaneChangeMode(vehicle, _LANE_CHANGE_NORMAL)
        else:
            libsumo.vehicle.setSpeedMode(vehicle, _SPEED_MODE_NORMAL)
            libsumo.vehicle.setSpeedFactor(vehicle, libsumo.vehicle.getSpeedFactor(vehicle) / manoeuvre.haste)


def _sideways(vehicle: str, manoeuvre: CutIn) -> int:
    """Lanes to move to the left."""
    if manoeuvre.direction != "ego":
        return 1 if manoeuvre.direction == "left" else -1
    heading = math.radians(90.0 - libsumo.vehicle.getAngle(vehicle))
    x, y = libsumo.vehicle.getPosition(vehicle)
    ego_x, ego_y = libsumo.vehicle.getPosition(EGO)
    offset = math.cos(heading) * (ego_y - y) - math.sin(heading) * (ego_x - x)  # [m] of the ego to the left
    return 0 if abs(offset) < _SAME_LANE else 1 if offset > 0.0 else -1


def _start(vehicle: str, manoeuvre: _Passing, grip: float) -> float:
    """Begin a manoeuvre on a road that transmits ``grip`` [m/s2]; returns how long it lasts [s]."""
    if isinstance(manoeuvre, Brake):
        speed = libsumo.vehicle.getSpeed(vehicle)
        deceleration = min(manoeuvre.deceleration, grip)
        set_deceleration(vehicle, max(deceleration, libsumo.vehicle.getDecel(vehicle)))
        duration = max(0.1, (speed - manoeuvre.speed) / deceleration)
        libsumo.vehicle.slowDown(vehicle, min(speed, manoeuvre.speed), duration)
        return float(duration + manoeuvre.hold)
    if isinstance(manoeuvre, CutIn):
        here, edge = libsumo.vehicle.getLaneIndex(vehicle), libsumo.vehicle.getRoadID(vehicle)
        lane = here + _sideways(vehicle, manoeuvre)
        if lane != here and 0 <= lane < libsumo.edge.getLaneNumber(edge):
            libsumo.vehicle.setLaneChangeMode(vehicle, _LANE_CHANGE_FORCED)
            libsumo.vehicle.changeLane(vehicle, lane, _CUT_IN_TIME)
            # By itself the sublane model keeps its lateral gaps and gives the change up beside the ego.
            width = libsumo.lane.getWidth(libsumo.vehicle.getLaneID(vehicle))
            libsumo.vehicle.changeSublane(vehicle, (lane - here) * width)
        return _CUT_IN_TIME
    libsumo.vehicle.setSpeedMode(vehicle, _SPEED_MODE_NO_RIGHT_OF_WAY)
    factor = libsumo.vehicle.getSpeedFactor(vehicle)
    libsumo.vehicle.setAccel(vehicle, max(_RUN_ACCELERATION, libsumo.vehicle.getAccel(vehicle)))
    libsumo.vehicle.setSpeedFactor(vehicle, factor * manoeuvre.haste)  # last: setAccel puts the type's own back
    return manoeuvre.hold
