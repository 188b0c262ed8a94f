"""The events of an episode, each with its sentence for people: the one place where these are made."""

from collections.abc import Sequence

from roadmend.core.outcome import Blame, Event, EventKind
from roadmend.core.scene import ObjectKind
from roadmend.world.stand_off import PATIENCE

_CONTACT = {
    Blame.UNKNOWN: "it is not known how",
    Blame.EGO_STOOD: "it hit the standing ego",
    Blame.OTHER_STOOD: "it stood and the ego hit it",
    Blame.FRONT: "the ego's front hit it",
    Blame.REAR: "it hit the ego's rear",
    Blame.SIDE: "it hit the ego's side",
    Blame.CHANGING: "the ego was changing lanes",
}


def started(scenario: str, way: float) -> Event:
    """The episode begins, with ``way`` [m] to the goal."""
    return Event(0.0, EventKind.STARTED, f"{scenario}: {way:.0f} m to go")


def change_of_lane(time: float, stage: int) -> Event:
    """The ego begins to change to a stage of its route."""
    return Event(time, EventKind.CHANGE_LANE, f"to stage {stage}")


def collision(time: float, hit: Sequence[tuple[int, str, ObjectKind]], blame: Blame, impact_speed: float) -> Event:
    """The ego's outline has met others'.

    Args:
        time: [s].
        hit: number, name and kind of everybody whom it met.
        blame: for the contact with the first of them.
        impact_speed: [m/s] of the ego.
    """
    numbers, names, kinds = zip(*hit, strict=True)
    text = f"the ego ({impact_speed:.1f} m/s) and {', '.join(names)} collided: {_CONTACT[blame]}"
    return Event(time, EventKind.COLLISION, text, numbers, names, kinds, blame, impact_speed)


def goal(time: float) -> Event:
    """The ego has completed its route."""
    return Event(time, EventKind.GOAL, f"route completed after {time:.2f} s")


def off_route(time: float) -> Event:
    """The ego has left its route."""
    return Event(time, EventKind.OFF_ROUTE, "the ego ran past the end of its lane")


def timeout(time: float, limit: float) -> Event:
    """The scenario's time limit [s] has passed."""
    return Event(time, EventKind.TIMEOUT, f"time limit of {limit:g} s passed")


def cleared(time: float, number: int, name: str, kind: ObjectKind) -> Event:
    """Somebody who blocked the ego was taken off the road."""
    text = f"{name} and the ego blocked each other for {PATIENCE:g} s: taken off the road"
    return Event(time, EventKind.CLEARED, text, (number,), (name,), (kind,))
