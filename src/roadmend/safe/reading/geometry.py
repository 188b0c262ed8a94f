"""Who can have met whom: how well the ways of two vehicles explain a contact, and a way its road. Weights in nats."""

from dataclasses import dataclass

from roadmend.safe.claims import WayRelation
from roadmend.safe.compass import TOWARDS, opposite, origin_of, turned
from roadmend.safe.dsl import Action, Compass, Position, RoadType, Side

JUNCTIONS = (RoadType.INTERSECTION, RoadType.T_INTERSECTION)
_HAND = {Action.MOVE_FORWARD: None, Action.TURN_LEFT: Side.LEFT, Action.TURN_RIGHT: Side.RIGHT}
_FLANKS = {Side.LEFT, Side.RIGHT}
_MISSING_LEG = 2.5  # that nobody comes from where a T has no road
_NO_EXIT = 1.75  # that nobody goes there


@dataclass(frozen=True, slots=True)
class StatedWay:
    """How one vehicle goes in a scene."""

    heading: Position
    action: Action

    @property
    def leaves(self) -> Position:
        """Its direction after its turn."""
        return turned(self.heading, _HAND[self.action])

    @property
    def is_straight(self) -> bool:
        """Whether it does not turn."""
        return self.action is Action.MOVE_FORWARD


def holds(kind: WayRelation, mine: Position, theirs: Position) -> bool:
    """Whether two directions lie to each other in a certain way."""
    left, right = turned(mine, Side.LEFT), turned(mine, Side.RIGHT)
    allowed = {
        WayRelation.SAME: {mine},
        WayRelation.OPPOSITE: {opposite(mine)},
        WayRelation.CROSSING: {left, right},
        WayRelation.FROM_LEFT: {right},
        WayRelation.FROM_RIGHT: {left},
    }
    return theirs in allowed[kind]


def fits_road(way: StatedWay, road: RoadType, stem: Compass | None, *, may_turn: bool, on_stem: float) -> float:
    """How well a way fits a road: turns want a junction, and a T has one leg less.

    Args:
        way: of a vehicle.
        road: its type.
        stem: where the stem of a T lies.
        may_turn: whether it can turn where no roads meet.
        on_stem: weight of the claims that it comes along the stem.
    """
    weight = 0.0 if way.is_straight or road in JUNCTIONS or may_turn else -0.5
    if stem is None:
        return weight
    comes, goes = origin_of(way.heading), TOWARDS[way.leaves]
    missing = TOWARDS[next(each for each in Position if each in TOWARDS and origin_of(each) is stem)]
    runs_through = bool(on_stem) and comes is stem and way.is_straight
    weight -= _MISSING_LEG * (comes is missing) + _NO_EXIT * (goes is missing and not runs_through)
    return weight + 0.3 * (stem in {comes, goes}) + (on_stem if comes is stem else -on_stem)


def explains(mine: StatedWay, theirs: StatedWay, front: Side | None, side: Side | None, *, crosses: bool) -> float:
    """How well two ways explain a contact, the first running into the second.

    Args:
        mine: way of the one who strikes.
        theirs: of the one who is struck.
        front: what the first hits with.
        side: where the second is hit.
        crosses: whether ways cross on such a road.
    """
    same, facing = mine.heading is theirs.heading, mine.heading is opposite(theirs.heading)
    crossing, turns = not same and not facing, not (mine.is_straight and theirs.is_straight)
    weight = (0.3 if crosses else -2.2) if crossing else -0.4 if facing and not turns and crosses else 0.0
    match front, side:
        case Side.FRONT, Side.REAR:
            joins = crossing and turns and mine.leaves is theirs.leaves
            weight += 2.0 if same else 0.6 if joins else -1.5
        case Side.FRONT, Side.FRONT:
            weight += 1.2 if facing else -0.3 if crossing else -1.8
        case Side.FRONT, Side.LEFT | Side.RIGHT:
            weight += _broadside(mine, theirs, side)
        case Side.FRONT, None:
            weight += 0.4 * same
        case Side.REAR, Side.FRONT:
            weight += 0.8 if same else -0.5
        case _ if front in _FLANKS and side in _FLANKS:
            fits, against = (facing, same) if front is side else (same, False)
            weight += 0.9 * fits - 0.6 * against
    return weight


def _broadside(mine: StatedWay, theirs: StatedWay, side: Side) -> float:
    """A front meets a side: the one who strikes comes from that side of the other, at some moment of the other's turn."""
    if opposite(mine.heading) in {turned(heading, side) for heading in (theirs.heading, theirs.leaves)}:
        return 1.3
    if mine.heading is opposite(theirs.heading) and not theirs.is_straight:
        # Who turns across the path of an oncoming vehicle shows it the outer flank.
        return 1.0 if side is (Side.RIGHT if theirs.action is Action.TURN_LEFT else Side.LEFT) else -0.4
    if mine.heading is theirs.heading:
        return -0.2
    return -1.0 if theirs.is_straight else -0.5
