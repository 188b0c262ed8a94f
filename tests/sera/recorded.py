"""Hand-made recorded episodes: an ego on a straight road or through a junction, and others on ways of their own."""

from pathlib import Path

import numpy as np

from roadmend.core.command import Command, Trajectory
from roadmend.core.outcome import Event, EventKind
from roadmend.core.repair import Repair, RepairStatus
from roadmend.core.route import RightOfWay, Route, Stage, Zone
from roadmend.core.scene import EgoState, ObjectKind, ObjectList
from roadmend.recording.episode import BagEpisode
from roadmend.sera.incident import Incident, IncidentEgo, IncidentPlace, Other, RepairAccount
from roadmend.sera.pattern import Where
from roadmend.sera.track import Track

TICK_NS = 50_000_000
LANE = Stage(np.array([-100.0, 300.0]), np.zeros(2), np.full(2, 14.0))
JUNCTION = Zone(0, 190.0, 210.0, RightOfWay.YIELD)  # 90 to 110 m east of the origin
CROSSING = Zone(0, 140.0, 144.0, RightOfWay.CROSSING)
NO_METHOD = RepairAccount("no_method", "none", (("PASS", 8.0),))


def route(*zones, stage=LANE):
    return Route("drawn", 4.0, 2.0, 350.0, 60.0, (stage,), (), zones)


def ego(x=0.0, y=0.0, yaw=0.0, speed=10.0, yaw_rate=0.0):
    return EgoState.from_yaw(x, y, yaw, speed, yaw_rate, 4.0, 2.0)


def track(x, y, yaw, speed, kind=ObjectKind.CAR, acceleration=0.0, interval=TICK_NS):
    """A way given by numbers or arrays; as many moments as the longest has, one tick after another."""
    columns = np.broadcast_arrays(
        *(np.atleast_1d(np.asarray(each, dtype=float)) for each in (x, y, yaw, speed, acceleration))
    )
    stamps = np.arange(len(columns[0]), dtype=np.int64) * interval
    return Track(7, int(kind), 4.0, 2.0, stamps, *columns)


def objects_at(tracks, number):
    """Everybody at a tick."""
    moving = ("x", "y", "yaw", "speed", "acceleration")
    return ObjectList.of(
        id=7 + np.arange(len(tracks)),
        yaw_rate=0.0,
        **{name: [getattr(one, name)[number] for one in tracks] for name in moving},
        **{name: [getattr(one, name) for one in tracks] for name in ("kind", "length", "width")},
    )


def repair(policy=0.5, final=0.5, status=None):
    status = status or (RepairStatus.PASS if policy == final else RepairStatus.REPAIRED)
    return Repair(Command.from_action(final), status, 0.0, 0.5, policy, final, policy != final)


def episode(egos, tracks=(), repairs=None, method="rss", final=None, plan=None):
    """An episode of one tick after another.

    Args:
        egos: the poses.
        tracks: of the others, as long as ``egos``.
        repairs: the node's answers by tick; PASS where none is given, no node at all for an empty mapping.
        method: its method.
        final: kind, text and object ids of the final event.
        plan: the policy's trajectory at every tick.
    """
    stamps = [number * TICK_NS for number in range(len(egos))]
    made = BagEpisode(Path("made"), account={"method": method, "policy": "modular"})
    made.ego = dict(zip(stamps, egos, strict=True))
    made.objects = {stamp: objects_at(tracks, number) for number, stamp in enumerate(stamps)}
    if repairs is None or repairs:
        made.repairs = {stamp: (repairs or {}).get(number, repair()) for number, stamp in enumerate(stamps[:-1])}
    if plan is not None:
        made.trajectories = dict.fromkeys(stamps, plan)
    made.route = route()
    if final is not None:
        kind, text, ids = final
        made.events = [Event(stamps[-1] * 1e-9, kind, text, ids, ("v7",) * len(ids))]
    return made


def straight_plan(speed, x=0.0, seconds=4.0):
    steps = 0.2 * np.arange(1, round(seconds / 0.2) + 1)
    still = np.zeros(len(steps))
    return Trajectory(0.2, x + speed * steps, still, still, np.full(len(steps), speed))


def incident(**chosen):
    given = {
        "kind": "collision",
        "bag": "a",
        "time": 5.0,
        "where": Where(family="S3", road="intersection", weather="rainy"),
        "place": IncidentPlace("in_junction", 0, "yield", -3.0),
        "ego": IncidentEgo("crossing_straight", 8.0, "straight"),
        "other": Other(7, "car", "crossing_from_left", "left", 9.0, 0.0, None, "v7", "normal"),
        "repair": NO_METHOD,
        "manner": "hit in the side",
        "at_fault": False,
        "avoidable": 1.2,
        "scenario": "5" * 64,
        "policy": "modular",
        "text": "bang",
    }
    return Incident(**(given | chosen))


COLLISION = EventKind.COLLISION
