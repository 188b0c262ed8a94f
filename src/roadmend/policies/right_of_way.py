"""Where the ego must stop for lights, signs, crossing traffic and pedestrians."""

import math

import numpy as np
from numpy.typing import NDArray

from roadmend.core.jit import compiled
from roadmend.core.route import RightOfWay
from roadmend.core.scene import Signal
from roadmend.policies import agents as who
from roadmend.policies import following, motion_plan, occupancy, road
from roadmend.policies.situation import Situation

Floats = NDArray[np.float64]
Record = NDArray[np.void]

# Reasons to stop, in the order of the words of behaviour.py
FREE, LIGHT, SIGN, GIVE_WAY, PEDESTRIANS = range(5)

_PASSED = 0.5  # [m] that the front may be past a line and still count as before it
_AT_LINE = 2.5  # [m] before the line at which a stop counts
_STANDING = 0.3  # [m/s]
_IN_FRONT_OF_CONFLICT = 1.0  # [m] clearance inside a junction

_STOP, _SIGNAL, _CROSSING = int(RightOfWay.STOP), int(RightOfWay.SIGNAL), int(RightOfWay.CROSSING)
_YELLOW, _RED = int(Signal.YELLOW), int(Signal.RED)


@compiled
def _light_holds(parameters: Record, zones: Floats, index: int, signals: NDArray[np.uint8], need: float) -> bool:
    """Whether the ego stops for a traffic light when that takes a deceleration of ``need`` [m/s2]."""
    p = parameters[0]
    light = int(zones[index, road.SIGNAL])
    if not 0 <= light < signals.shape[0]:
        return False
    if signals[light] == _RED:
        return need <= float(p.red_deceleration)
    return int(signals[light]) == _YELLOW and need <= float(p.yellow_deceleration)


@compiled
def _conflict(situation: Situation, plan: Floats, zone: int) -> float:
    """Where the plan first meets somebody with right of way in a zone [m ahead of the centre]; inf if nowhere."""
    p, m = situation.parameters[0], situation.memory[0]
    agents, occupancies = situation.others.agents, situation.others.occupancies
    half = 0.5 * situation.ego.length
    share = 1.0 - p.impatience * min(1.0, m.waited / p.patience)
    nearest = math.inf
    for index in range(agents.shape[0]):
        if agents[index, who.ZONE] != zone or agents[index, who.ROLE] < who.ENTERING:
            continue
        ego_index, other_index = motion_plan.contact(
            plan,
            occupancies[index],
            int(agents[index, who.BEGIN]),
            p.gap_before * share,
            p.gap_after * share,
            half + agents[index, who.CLEARANCE],
            half + 0.3,
        )
        if ego_index >= 0:
            nearest = min(nearest, occupancies[index, other_index, occupancy.LOW])
    return nearest


@compiled
def stop_line(situation: Situation, plan: Floats) -> tuple[float, int]:
    """How far ahead the ego's centre must stop [m] (inf: nowhere) and why.

    ``plan`` is what the ego would do if nobody had right of way. A line that cannot be held any more with the
    deceleration that its rule is worth is passed. The memory counts how long the ego has waited.
    """
    parameters, memory, interval = situation.parameters, situation.memory, situation.interval
    zones, signals = situation.route.zones, situation.signals
    p, m = parameters[0], memory[0]
    speed, half = situation.ego.speed, 0.5 * situation.ego.length
    line, reason = math.inf, FREE
    within = speed * speed / 2.0 + 30.0
    for index in range(zones.shape[0]):
        begin = who.zone_begin(zones, index, memory)
        if begin > within + half:
            continue
        end = begin + zones[index, road.END] - zones[index, road.BEGIN]
        if end < -half:
            continue
        rule = int(zones[index, road.RULE])
        place = begin - half - p.line_margin
        before_line = begin - half > -_PASSED
        need = 0.0 if speed < _STANDING else following.needed_deceleration(speed, place)
        held, why = False, FREE
        if rule == _SIGNAL and before_line and _light_holds(parameters, zones, index, signals, need):
            held, why = True, LIGHT
        if rule == _STOP and before_line and m.stopped_at != index:
            held, why = need <= p.red_deceleration, SIGN
            if speed < _STANDING and place < _AT_LINE:
                m.stood += interval
                if m.stood >= p.stop_duration:
                    m.stopped_at, m.stood = index, 0.0
        if not held and (rule == _CROSSING or who.gives_way(zones, index, signals)):
            meets = _conflict(situation, plan, index)
            if meets < math.inf:
                why = PEDESTRIANS if rule == _CROSSING else GIVE_WAY
                if before_line and need <= p.hold_deceleration:
                    held = True
                elif not before_line:
                    # Inside: wait in front of the conflict itself if there is room for that.
                    place = meets - half - _IN_FRONT_OF_CONFLICT
                    held = place > 0.0 and following.needed_deceleration(speed, place) <= p.hold_deceleration
        if held and place < line:
            line, reason = place, why
    if reason >= GIVE_WAY and speed < 0.5:
        m.waited += interval
    elif speed > 3.0:
        m.waited = 0.0
    return line, reason
