"""A small world for the repair methods: a straight and a curved road, boxes that move, and an ego that obeys."""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from roadmend.core.command import Command, Decision, Trajectory
from roadmend.core.interfaces import Repairer
from roadmend.core.repair import Repair
from roadmend.core.route import RightOfWay, Route, Stage, Window, Zone
from roadmend.core.scene import COLUMNS, EgoState, ObjectList, Scene

TICK = 0.05  # [s]
FULL_BRAKE = 8.0  # [m/s2]
FULL_THROTTLE = 3.0  # [m/s2]


@dataclass(frozen=True)
class Box:
    """One participant with constant acceleration along its heading; it never reverses."""

    id: int
    x: float
    y: float
    yaw: float = 0.0
    speed: float = 0.0
    acceleration: float = 0.0
    yaw_rate: float = 0.0
    length: float = 4.5
    width: float = 1.8

    def after(self, tick: float) -> "Box":
        yaw = self.yaw + 0.5 * self.yaw_rate * tick
        return replace(
            self,
            x=self.x + self.speed * tick * math.cos(yaw),
            y=self.y + self.speed * tick * math.sin(yaw),
            yaw=self.yaw + self.yaw_rate * tick,
            speed=max(0.0, self.speed + self.acceleration * tick),
        )


def object_list(boxes: Sequence[Box]) -> ObjectList:
    columns = {name: [getattr(box, name) for box in boxes] for name in COLUMNS if name != "kind"}
    return ObjectList.of(**columns, kind=1)


def ego_at(x: float = 0.0, y: float = 0.0, yaw: float = 0.0, speed: float = 10.0) -> EgoState:
    return EgoState.from_yaw(x, y, yaw, speed, 0.0, 4.5, 1.8)


def scene_of(
    boxes: Sequence[Box], time: float = 0.0, ego: EgoState | None = None, signals: Sequence[int] = ()
) -> Scene:
    return Scene(time, ego or ego_at(), object_list(boxes), np.array(signals, dtype=np.uint8))


def stage_of(x: np.ndarray, y: np.ndarray) -> Stage:
    return Stage(x, y, np.full(len(x), 15.0))


def straight_route(rule: RightOfWay | None = None, name: str = "straight", signal: int = -1) -> Route:
    """Along y = 0 from x = -100 to 400; with a rule there is a conflict zone at x = 40 .. 60."""
    x = np.arange(-100.0, 401.0, 2.0)
    zones = () if rule is None else (Zone(0, 140.0, 160.0, rule, signal),)
    return Route(name, 4.5, 1.8, 450.0, 60.0, (stage_of(x, np.zeros_like(x)),), (), zones)


def curved_route(radius: float = 20.0) -> Route:
    """50 m straight to the origin, a quarter circle to the left, then 100 m to the north."""
    angle = np.linspace(0.0, 0.5 * math.pi, 33)[1:]
    x = np.concatenate([np.arange(-50.0, 1.0, 2.0), radius * np.sin(angle), np.full(50, radius)])
    y = np.concatenate([np.zeros(26), radius * (1.0 - np.cos(angle)), radius + np.arange(2.0, 101.0, 2.0)])
    return Route("curve", 4.5, 1.8, 150.0, 60.0, (stage_of(x, y),), (), ())


def two_lane_route(begin: float = 0.0, end: float = 500.0) -> Route:
    """Lane y = 0, then lane y = 3.2; the change may begin from arc length ``begin`` to ``end`` [m], 100 m at x = 0."""
    x = np.arange(-100.0, 401.0, 2.0)
    stages = (stage_of(x, np.zeros_like(x)), stage_of(x, np.full_like(x, 3.2)))
    return Route("lanes", 4.5, 1.8, 450.0, 60.0, stages, (Window(begin, end),), ())


def keep_on(scene: Scene, action: float = 0.2, speed: float | None = None, points: int = 30) -> Decision:
    """A decision to go straight on in the ego's heading at its own or a given speed, planned for 3 s."""
    ego = scene.ego
    pace = ego.speed if speed is None else speed
    times = np.arange(1, points + 1) * 0.1
    way = pace * times
    plan = Trajectory(
        0.1,
        ego.x + way * math.cos(ego.yaw),
        ego.y + way * math.sin(ego.yaw),
        np.full(points, ego.yaw),
        np.full(points, pace),
    )
    return Decision(Command.from_action(action), plan)


@dataclass
class Drive:
    """A closed-loop run on the straight route: a blind policy that wants a speed, repaired."""

    repairs: list[Repair] = field(default_factory=list)
    positions: list[float] = field(default_factory=list)
    speeds: list[float] = field(default_factory=list)
    gaps: list[float] = field(default_factory=list)

    @property
    def interventions(self) -> list[bool]:
        return [repair.intervened for repair in self.repairs]

    @property
    def intensity(self) -> float:
        replaced = [abs(repair.policy_action - repair.final_action) for repair in self.repairs if repair.intervened]
        return sum(replaced) / max(1, len(replaced))

    @property
    def dose(self) -> float:
        return TICK * sum(abs(repair.policy_action - repair.final_action) for repair in self.repairs)


Mover = Callable[[float, Box], Box]


def drive(
    repairer: Repairer,
    boxes: Sequence[Box],
    seconds: float,
    *,
    start: float = 0.0,
    speed: float = 10.0,
    wish: float = 10.0,
    route: Route | None = None,
    move: Mover | None = None,
    stop: float | None = None,
) -> Drive:
    """Let the policy accelerate to ``wish`` [m/s] without looking, except that it stops at x = ``stop``."""
    from roadmend.core.geometry import outline_distances

    run = Drive()
    repairer.reset(route or straight_route())
    x, boxes = start, list(boxes)
    for index in range(round(seconds / TICK)):
        ego = ego_at(x, 0.0, 0.0, speed)
        scene = scene_of(boxes, index * TICK, ego)
        wanted = wish if stop is None else min(wish, math.sqrt(max(0.0, 2.0 * 3.0 * (stop - x))))
        action = 0.5 if speed < wanted - 0.1 else (0.0 if speed < wanted + 0.1 else -0.4)
        pace = np.minimum(wanted, speed + 1.5 * np.arange(1, 31) * 0.1)
        way = x + np.cumsum(pace * 0.1)
        if stop is not None:
            way = np.minimum(way, max(x, stop))
        plan = Trajectory(0.1, way, np.zeros(30), np.zeros(30), pace)
        repair = repairer.step(scene, Decision(Command.from_action(action), plan))
        run.repairs.append(repair)
        run.positions.append(x)
        run.speeds.append(speed)
        gaps = outline_distances(ego, scene.objects.table, 10.0)
        run.gaps.append(float(gaps.min()) if boxes else math.inf)
        final = repair.final_action
        speed = max(0.0, speed + TICK * (final * FULL_BRAKE if final < 0.0 else final * FULL_THROTTLE))
        x += speed * TICK
        boxes = [(move(index * TICK, box) if move else box).after(TICK) for box in boxes]
    return run
