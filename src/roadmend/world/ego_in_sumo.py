"""The ego as SUMO and its drivers see it: a body that is where the ego's own dynamics put it."""

import math

import libsumo

from roadmend.world.ego import RouteFollower
from roadmend.world.scenario import Scenario
from roadmend.world.scenario_networks import SumoConfiguration
from roadmend.world.traffic_file import EGO

_TYPE = "roadmend_ego"
_OFF_BY = 0.25  # [m] beyond which the body is put back into place instead of being steered there
_FREE_PLACE = 2  # moveToXY: exactly there, on or off the lane
_ON_ITS_ROUTE = 1  # moveToXY, beside: SUMO shall not take it for somebody who goes elsewhere
# [m] from which on a body's front may stand off its lane in a tight bend: SUMO would have it go elsewhere from there,
# and take it away at that road's end.
_LONG = 8.0


class EgoInSumo:
    """Steers SUMO's vehicle after the ego.

    Along a lane it is enough to tell SUMO the speed: all its own care is off, it follows the lane's centre as the ego
    does, and the difference of the last step is corrected in the next. During a lane change, and wherever the two
    differ by more than a little, it is put into place, which costs SUMO several times as much.
    """

    def __init__(self, scenario: Scenario, interval: float) -> None:
        self._front = 0.5 * scenario.ego.length
        self._interval = interval
        self._placed = False
        network = scenario.network
        is_drawn = isinstance(network, SumoConfiguration) and network.draw
        self._how = _FREE_PLACE | (_ON_ITS_ROUTE if is_drawn or scenario.ego.length > _LONG else 0)
        libsumo.vehicletype.copy("DEFAULT_VEHTYPE", _TYPE)
        libsumo.vehicletype.setVehicleClass(_TYPE, "passenger")
        libsumo.vehicletype.setLength(_TYPE, scenario.ego.length)
        libsumo.vehicletype.setWidth(_TYPE, scenario.ego.width)
        libsumo.route.add(_TYPE, list(scenario.ego.route))
        libsumo.vehicle.add(EGO, _TYPE, typeID=_TYPE, departPos=f"{scenario.ego.position:g}")
        libsumo.vehicle.setSpeedMode(EGO, 0)
        libsumo.vehicle.setLaneChangeMode(EGO, 0)

    def follow(self, ego: RouteFollower, distance: float) -> None:
        """Before a SUMO step: the ego is about to be at ``ego``'s pose, ``distance`` [m] further than now."""
        if self._placed and not ego.changing:
            x, y = libsumo.vehicle.getPosition(EGO)
            cosine, sine = math.cos(ego.yaw), math.sin(ego.yaw)
            # What is left to drive for SUMO's front bumper, and how far it is beside the line.
            ahead = cosine * (ego.x - x) + sine * (ego.y - y) + self._front
            beside = cosine * (ego.y - y) - sine * (ego.x - x)
            if abs(ahead - distance) < _OFF_BY and abs(beside) < _OFF_BY:
                libsumo.vehicle.setSpeed(EGO, max(0.0, ahead / self._interval))
                return
        libsumo.vehicle.moveToXY(
            EGO,
            "",
            -1,
            ego.x + self._front * math.cos(ego.yaw),
            ego.y + self._front * math.sin(ego.yaw),
            (90.0 - math.degrees(ego.yaw)) % 360.0,
            self._how,
        )
        self._placed = True
