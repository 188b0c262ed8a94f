"""Who goes the ego's way: stands before it, comes from behind, comes into its lane from the side, or slows down."""

import math
from collections.abc import Mapping
from dataclasses import dataclass

from roadmend.safe.dsl import SIDEWAYS, STANDING, CrashScenario, DescribedCollision, Side
from roadmend.safe.spots import GAP, Casting, Spot
from roadmend.safe.staging import collision_between, goes_first
from roadmend.safe.ways import Way
from roadmend.world import scenario_actors as world
from roadmend.world.network import LANE_WIDTH
from roadmend.world.space import Value

_NOW = world.Trigger(time=0.0)
_PASSING = 1.5  # [s] that a vehicle is beside its lane before it comes back
_FASTER = 4.0  # [m/s] at least of who overtakes


@dataclass(frozen=True, slots=True)
class Neighbour:
    """What is known of who goes the ego's way.

    Attributes:
        crash: as the report has it.
        ego: index of the ego's vehicle.
        index: of this one.
        way: of both.
        ego_spot: where the ego starts.
        time: [s] until the ego is at the place of the crash.
        lane: that was drawn for this one.
        length: of this one [m].
        speed: of this one [m/s].
        drawn: what the report leaves open.
    """

    crash: CrashScenario
    ego: int
    index: int
    way: Way
    ego_spot: Spot
    time: float
    lane: int
    length: float
    speed: float
    drawn: Mapping[str, Value]

    def of(self, what: str) -> float:
        """What was drawn for this one."""
        return float(self.drawn[f"v{self.index + 1}.{what}"])

    def cast(self) -> Casting:
        """Where it starts and what it does."""
        collision = collision_between(self.crash, self.ego, self.index)
        vehicle = self.crash.vehicles[self.index]
        if vehicle.manoeuvre in STANDING:
            return self._standing()
        if self.crash.vehicles[self.ego].manoeuvre not in STANDING:
            side = self._side(collision)
            if side is not None:
                return self._from_the_side(side)
        first = goes_first(self.crash, self.ego, self.index)
        behind = self.drawn[f"v{self.index + 1}.order"] == "behind" if first is None else not first
        return self._behind() if behind else self._ahead()

    def _standing(self) -> Casting:
        """It stands in the ego's lane."""
        front = self.way.meeting + 8.0 + 3.0 * self.of("delay")
        spot = Spot(self.ego_spot.edge, self.ego_spot.lane, min(front, self.way.meeting), self.length, 0.0)
        return spot, [world.Heedless(when=_NOW, speed=0.0)]

    def _side(self, collision: DescribedCollision | None) -> Side | None:
        """The side of the ego that it comes from, if it comes from one; a side that nobody tells is drawn."""
        vehicle = self.crash.vehicles[self.index]
        told = None
        if collision is not None:
            own, other = collision.striking_side, collision.struck_side
            if collision.striking != self.ego + 1:
                own, other = other, own
            if own in {Side.LEFT, Side.RIGHT}:
                told = own
            elif other in {Side.LEFT, Side.RIGHT}:
                told = Side.RIGHT if other is Side.LEFT else Side.LEFT
        if told is None and vehicle.manoeuvre in SIDEWAYS:
            told = (Side.RIGHT, Side.LEFT)[int(self.drawn[f"v{self.index + 1}.side"]) % 2]
        return told

    def _from_the_side(self, side: Side) -> Casting:
        """It changes into the ego's lane, from the next lane or, where there is none, having gone past beside it."""
        ego, over, delay = self.ego_spot, self.of("drift_time"), self.of("delay")
        lane = ego.lane + (1 if side is Side.LEFT else -1)
        sign = 1.0 if side is Side.LEFT else -1.0
        begin = max(0.1, self.time - over)
        if 0 <= lane < self.way.lane_count:
            front = ego.front + (ego.speed - self.speed) * self.time - self.speed * delay * 0.3
            return Spot(ego.edge, lane, front, self.length, self.speed), [
                world.Heedless(when=_NOW, speed=round(self.speed, 2)),
                world.Drift(when=world.Trigger(time=round(begin, 2)), offset=-sign * LANE_WIDTH, over=over),
            ]
        speed = max(self.speed, ego.speed + _FASTER)
        front = ego.front + (ego.speed - speed) * self.time - speed * delay * 0.15
        behind = ego.front - ego.length - GAP
        out = min(max(0.1, (behind - front) / max(speed - ego.speed, 0.1) - 2.5), max(0.1, begin - _PASSING - 2.0))
        return Spot(ego.edge, ego.lane, min(front, behind), self.length, speed), [
            world.Heedless(when=_NOW, speed=round(speed, 2)),
            world.Drift(when=world.Trigger(time=round(out, 2)), offset=sign * LANE_WIDTH, over=2.0),
            world.Drift(when=world.Trigger(time=round(max(begin, out + 2.5), 2)), offset=-sign * LANE_WIDTH, over=over),
        ]

    def _behind(self) -> Casting:
        """It comes from behind, faster."""
        ego, delay = self.ego_spot, self.of("delay")
        lane = ego.lane if ego.lane in self.way.lanes else self.lane
        closing = self.of("closing") if ego.speed else self.speed
        speed = ego.speed + closing
        gap = max(GAP, (speed - ego.speed) * (self.time + delay))
        return Spot(ego.edge, lane, ego.front - ego.length - gap, self.length, speed), self._drive(speed)

    def _ahead(self) -> Casting:
        """It is ahead and brakes."""
        ego = self.ego_spot
        lane = ego.lane if ego.lane in self.way.lanes else self.lane
        front = ego.front + self.length + 0.6 * ego.speed + 6.0 * (self.of("delay") + 2.5)
        brake = world.Brake(
            when=world.Trigger(time=round(0.5 * self.time, 2)),
            speed=0.0,
            hold=8.0,
            deceleration=self.of("braking"),
        )
        return Spot(ego.edge, lane, front, self.length, min(self.speed, ego.speed)), [brake]

    def _drive(self, speed: float) -> list[world.Manoeuvre]:
        if self.drawn[f"v{self.index + 1}.heed"] == "none":
            return [world.Heedless(when=_NOW, speed=round(speed, 2))]
        return [world.RunRightOfWay(when=_NOW, hold=math.ceil(self.time) + 20.0)]
