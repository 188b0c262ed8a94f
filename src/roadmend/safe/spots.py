"""Where vehicles stand at the start of a scenario, and room between them."""

from dataclasses import dataclass, replace

from roadmend.world import scenario_actors as world

GAP = 4.0  # [m] between bumpers at the start, at least


@dataclass(frozen=True, slots=True)
class Spot:
    """Where a vehicle is at the start."""

    edge: str
    lane: int
    front: float  # [m] along the edge, negative for those who come later
    length: float  # [m]
    speed: float  # [m/s]


Casting = tuple[Spot, list[world.Manoeuvre]]  # where a vehicle starts, and what it does


def make_room(spot: Spot, taken: list[Spot]) -> Spot:
    """The spot, moved along its lane until it is clear of the others there: forwards if it is ahead of the ego."""
    neighbours = [other for other in taken if (other.edge, other.lane) == (spot.edge, spot.lane)]
    forwards = taken[0] in neighbours and spot.front >= taken[0].front
    for other in sorted(neighbours, key=lambda other: other.front, reverse=not forwards):
        if spot.front - spot.length >= other.front + GAP or other.front - other.length >= spot.front + GAP:
            continue
        front = other.front + GAP + spot.length if forwards else other.front - other.length - GAP
        spot = replace(spot, front=front)
    return spot
