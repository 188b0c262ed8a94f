"""A small world for the policies: straight roads, participants that move by rule, and an ego that obeys."""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from roadmend.core.command import Decision
from roadmend.core.interfaces import Policy
from roadmend.core.route import RightOfWay, Route, Stage, Window, Zone
from roadmend.core.scene import COLUMNS, EgoState, ObjectKind, ObjectList, Scene

TICK = 0.05  # [s]


@dataclass(frozen=True)
class Body:
    """A participant with constant acceleration along its heading; it never reverses."""

    id: int
    x: float
    y: float
    yaw: float = 0.0
    speed: float = 0.0
    acceleration: float = 0.0
    kind: ObjectKind = ObjectKind.CAR
    length: float = 4.6
    width: float = 1.8

    def after(self, tick: float) -> "Body":
        return replace(
            self,
            x=self.x + self.speed * tick * math.cos(self.yaw),
            y=self.y + self.speed * tick * math.sin(self.yaw),
            speed=max(0.0, self.speed + self.acceleration * tick),
        )


def walker(number: int, x: float, y: float, yaw: float, speed: float) -> Body:
    return Body(number, x, y, yaw, speed, kind=ObjectKind.PEDESTRIAN, length=0.5, width=0.6)


def object_list(bodies: Sequence[Body]) -> ObjectList:
    columns = {name: [getattr(body, name) for body in bodies] for name in COLUMNS if name != "yaw_rate"}
    return ObjectList.of(**columns, yaw_rate=0.0)


def scene_at(
    time: float, x: float, speed: float, bodies: Sequence[Body] = (), signals: Sequence[int] = (), y: float = 0.0
) -> Scene:
    ego = EgoState.from_yaw(x, y, 0.0, speed, 0.0, 4.7, 1.85)
    return Scene(time, ego, object_list(bodies), np.array(signals, dtype=np.uint8))


def straight(length: float, y: float = 0.0, limit: float = 13.9, begin: float = 0.0) -> Stage:
    x = np.linspace(begin, begin + length, 12)
    return Stage(x, np.full(12, y), np.full(12, limit))


def road(*zones: Zone, limit: float = 13.9, length: float = 400.0) -> Route:
    return Route("proving-ground", 4.7, 1.85, length - 10.0, 60.0, (straight(length, limit=limit),), (), zones)


def two_lanes(end: float = 150.0) -> Route:
    """The ego's lane ends after 220 m; the lane to its left goes on."""
    stages = (straight(220.0, limit=25.0), straight(600.0, 3.2, 25.0))
    return Route("two-lanes", 4.7, 1.85, 500.0, 60.0, stages, (Window(50.0, end),), ())


def zone(begin: float, end: float, rule: RightOfWay) -> Zone:
    return Zone(0, begin, end, rule, 0 if rule is RightOfWay.SIGNAL else -1)


@dataclass
class Run:
    """What an ego on a straight road did, tick by tick."""

    x: list[float] = field(default_factory=list)
    y: list[float] = field(default_factory=list)
    speed: list[float] = field(default_factory=list)
    acceleration: list[float] = field(default_factory=list)
    decisions: list[Decision] = field(default_factory=list)
    bodies: list[Body] = field(default_factory=list)
    gap: float = math.inf  # [m] least distance between outlines that overlap sideways

    @property
    def words(self) -> set[str]:
        return {decision.trajectory.behaviour for decision in self.decisions}


def drive(
    policy: Policy,
    route: Route,
    seconds: float,
    x: float,
    speed: float,
    bodies: Sequence[Body] = (),
    signals: Callable[[float], Sequence[int]] = lambda _: (),
    change_seconds: float = 3.0,
) -> Run:
    """Let a policy drive along the x axis on an ideal vehicle; lane changes go to y = 3.2 in a straight slope."""
    run = Run(bodies=list(bodies))
    policy.reset(route)
    y, changing = 0.0, False
    for tick in range(round(seconds / TICK)):
        decision = policy.step(scene_at(tick * TICK, x, speed, run.bodies, signals(tick * TICK), y))
        command = decision.command
        assert command.fault == ""
        window = route.windows[0] if route.windows else None
        changing = changing or (command.change_lane and window is not None and window.begin <= x <= window.end)
        acceleration = min(3.5, 60.0 / max(speed, 1.0)) * command.throttle - 8.0 * command.brake
        acceleration -= 0.00027 * speed * speed + (0.12 if speed > 0.0 else 0.0)
        after = max(0.0, speed + acceleration * TICK)
        run.acceleration.append((after - speed) / TICK)
        x += 0.5 * (speed + after) * TICK
        speed = after
        if changing:
            y = min(3.2, y + 3.2 * speed * TICK / max(12.0, change_seconds * speed))
        run.bodies = [body.after(TICK) for body in run.bodies]
        for body in run.bodies:
            c, s = abs(math.cos(body.yaw)), abs(math.sin(body.yaw))
            beside = abs(body.y - y) - 0.5 * (1.85 + body.width * c + body.length * s)
            ahead = abs(body.x - x) - 0.5 * (4.7 + body.length * c + body.width * s)
            run.gap = min(run.gap, max(beside, ahead))
        run.x.append(x)
        run.y.append(y)
        run.speed.append(speed)
        run.decisions.append(decision)
    return run
