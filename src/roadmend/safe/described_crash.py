"""Whether a contact is the crash that a report describes: who met whom, in which manoeuvre, and who ran into whom."""

import itertools
from dataclasses import dataclass

from roadmend.safe.compass import wrap_degrees
from roadmend.safe.dsl import STANDING, CrashScenario, DescribedCollision, Manoeuvre, RoadType, Side
from roadmend.safe.layout import Layout
from roadmend.safe.staging import collisions_of
from roadmend.safe.trial import Contact

_ANGLE = 35.0  # [deg] by which two headings may differ from what the manoeuvres explain
_BEFORE_THE_LINE = 0.5  # [m] before its stop line a vehicle still counts as in the junction
_STANDING = 1.0  # [m/s] at most of a vehicle that had stopped on the other's way
_SHARES = (0.0, 0.25, 0.5, 0.75, 1.0)  # of a turn that may be done at the contact
# What no policy does on its own account, so that it cannot take the place of who did.
_NOT_PLAYED = {
    Manoeuvre.ENTER_THE_WRONG_WAY,
    Manoeuvre.CHANGING_LANE,
    Manoeuvre.OVERTAKE,
    Manoeuvre.U_TURN,
    Manoeuvre.REVERSE,
    Manoeuvre.PARKED,
    Manoeuvre.RUN_OFF,
}


@dataclass(frozen=True, slots=True)
class Verdict:
    """Whether a contact is the described crash, and if not, what is different."""

    is_described: bool
    reason: str = ""


def why_not_played(crash: CrashScenario, ego: int) -> str:
    """Why the crash cannot happen as described with the policy in a vehicle's place; empty if it can."""
    if len(crash.vehicles) == 1:
        return "a single vehicle: there is nobody to collide with, and the ego does not leave its road"
    if not collisions_of(crash, ego):
        return "the vehicle is in no collision of the report"
    manoeuvre = crash.vehicles[ego].manoeuvre
    joins = manoeuvre is Manoeuvre.MERGE and crash.road.road_type is not RoadType.MERGING
    if manoeuvre in _NOT_PLAYED or joins:
        return f"the vehicle does what no policy is asked to do here ({manoeuvre})"
    return ""


def judge(crash: CrashScenario, layout: Layout, ego: int, contact: Contact) -> Verdict:
    """Compare a contact of the ego with the collisions that the report describes for its vehicle.

    Approaches are right by construction: everybody is on the way that the report gives. Sides of the vehicles are
    compared as far as they say who ran into whom, since that is what reports are sure of.

    Args:
        crash: as the report has it.
        layout: that the scenario was built with.
        ego: index of the vehicle whose place the ego takes.
        contact: what happened.
    """
    other = int(contact.name.removeprefix("v")) - 1
    partners = [each for each in collisions_of(crash, ego) if other + 1 in {each.striking, each.struck}]
    if not partners:
        return Verdict(is_described=False, reason=f"the report has no collision with {contact.name}")
    own, their = layout.ways[ego], layout.ways[other]
    if layout.is_junction and own.route[0] != their.route[0] and contact.ego_front > own.stop_line + _BEFORE_THE_LINE:
        return Verdict(is_described=False, reason="the ego had not entered the junction")
    if not _angle_fits(layout, ego, other, contact.angle):
        return Verdict(
            is_described=False, reason=f"they met at {contact.angle:.0f} deg, which the manoeuvres do not explain"
        )
    stands = crash.vehicles[ego].manoeuvre in STANDING and own.route[0] == their.route[0]
    if stands and contact.ego_speed > _STANDING:
        return Verdict(is_described=False, reason="the report's vehicle had stopped, the ego had not")
    if crash.collisions and not any(_same_striker(each, ego, contact) for each in partners):
        return Verdict(is_described=False, reason="the other way round: who was struck ran into the other")
    return Verdict(is_described=True)


def _angle_fits(layout: Layout, ego: int, other: int, angle: float) -> bool:
    """Whether two headings are some that the vehicles have on their ways at the same time."""
    one, two = layout.ways[ego], layout.ways[other]
    if not layout.is_junction:
        # On a road both have turned by the same angle where they meet.
        same = one.route[0] == two.route[0] or len(one.route) > 1
        return abs(wrap_degrees(angle - (0.0 if same else 180.0))) <= _ANGLE
    return any(
        abs(wrap_degrees(angle - (two.heading + v * two.turn - one.heading - u * one.turn))) <= _ANGLE
        for u, v in itertools.product(_SHARES, _SHARES)
    )


def _same_striker(described: DescribedCollision, ego: int, contact: Contact) -> bool:
    """Whether who ran into whom is as described; who hits with its front is who runs into the other."""
    ego_strikes, other_strikes = Side.FRONT in contact.ego_sides, Side.FRONT in contact.other_sides
    if ego_strikes == other_strikes or (described.striking_side or Side.FRONT) is not Side.FRONT:
        return True  # head on, or side to side: neither is the one
    return ego_strikes == (described.striking == ego + 1)
