"""How two vehicles of a report come together: along which ways, and who runs into whom."""

from enum import Enum

from roadmend.safe.compass import wrap_degrees
from roadmend.safe.dsl import CrashScenario, DescribedCollision, Side
from roadmend.safe.ways import Way


class Relation(Enum):
    """How the way of one vehicle lies to that of another where they come from."""

    SAME = "same way"
    ONCOMING = "oncoming"
    CROSSING = "crossing"
    MERGING = "merging"


def relation_of(one: Way, other: Way) -> Relation:
    """How two ways begin."""
    if one.route[0] == other.route[0]:
        return Relation.SAME
    if set(one.route) & set(other.route) and one.heading == other.heading:
        return Relation.MERGING
    if len(one.route) == len(other.route) == 1 or wrap_degrees(one.heading - other.heading) == 180.0:
        return Relation.ONCOMING
    return Relation.CROSSING


def is_alone(crash: CrashScenario) -> bool:
    """Whether one vehicle crashes alone: nobody can take its place, and the ego looks on."""
    return len(crash.vehicles) == 1


def collisions_of(crash: CrashScenario, ego: int) -> list[DescribedCollision]:
    """The described collisions that a vehicle takes part in; one with every other vehicle if the report names none."""
    if crash.collisions:
        return [each for each in crash.collisions if ego + 1 in {each.striking, each.struck}]
    return [DescribedCollision(other + 1, ego + 1) for other in range(len(crash.vehicles)) if other != ego]


def goes_first(crash: CrashScenario, ego: int, other: int) -> bool | None:
    """Whether, of two that go the same way, the other one is ahead of the ego; None if the report does not say."""
    for each in crash.collisions:
        if {each.striking, each.struck} == {ego + 1, other + 1}:
            rear_end = each.striking_side in {Side.FRONT, None} and each.struck_side in {Side.REAR, None}
            return each.striking == ego + 1 if rear_end else None
    return None


def first_collision(crash: CrashScenario) -> DescribedCollision | None:
    """The collision that a run is to show: the report's first one; None where it names none."""
    return crash.collisions[0] if crash.collisions else None


def collision_between(crash: CrashScenario, one: int, other: int) -> DescribedCollision | None:
    """The first described collision of two vehicles, by their indices; None if the report names none."""
    numbers = {one + 1, other + 1}
    return next((each for each in crash.collisions if {each.striking, each.struck} == numbers), None)


def is_struck_from_behind(crash: CrashScenario, index: int) -> bool:
    """Whether a vehicle is run into from behind."""
    return any(
        each.struck == index + 1 and each.struck_side is Side.REAR and each.striking_side in {Side.FRONT, None}
        for each in crash.collisions
    )
